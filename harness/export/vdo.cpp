// The folder that VDO-SLAM (Zhang et al., 2020) and DynOSAM (Morris et al., 2025) read: times.txt, image_0/,
// depth/ (disparities), semantic/ (ids as text), flow/ (Middlebury .flo), pose_gt.txt, object_pose.txt,
// settings.yaml.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <set>

#include "core/base/files.h"
#include "core/base/progress.h"
#include "core/import/rectify.h"
#include "harness/export/export.h"
#include "harness/export/export_source.h"
#include "harness/export/writers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// z = kBf / (value / kUnits): from 0.16 m on, 4e-4 m apart at 2 m and 0.01 m at 10 m.
constexpr double kBf = 40, kUnits = 256;  // ours
constexpr float kFloTag = 202021.25F;     // of the Middlebury format

cv::Mat disparities(const cv::Mat& depth_m) {
  cv::Mat units(depth_m.size(), CV_16UC1, cv::Scalar(0));
  for (int v = 0; v < depth_m.rows; ++v)
    for (int u = 0; u < depth_m.cols; ++u)
      if (const float z = depth_m.at<float>(v, u); z > 0)
        if (const double value = std::round(kBf * kUnits / z);
            value <= std::numeric_limits<std::uint16_t>::max())
          units.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(value);
  return units;
}

std::string ids_text(const cv::Mat& masks) {
  std::string text;
  for (int v = 0; v < masks.rows; ++v) {
    const auto* row = masks.ptr<std::uint16_t>(v);
    text += fmt::format("{}\n", fmt::join(row, row + masks.cols, " "));
  }
  return text;
}

std::set<int> ids_in(const cv::Mat& masks) {
  return {masks.begin<std::uint16_t>(), masks.end<std::uint16_t>()};
}

std::string flo_bytes(const cv::Mat& flow) {
  std::string bytes;
  const auto append = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  append(kFloTag);
  append(flow.cols);
  append(flow.rows);
  for (int v = 0; v < flow.rows; ++v)
    bytes.append(reinterpret_cast<const char*>(flow.ptr(v)), flow.cols * flow.elemSize());
  return bytes;
}

std::string rows_text(const Pose& pose) {
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = pose.matrix();
  return fmt::format("{}", fmt::join(rows.data(), rows.data() + rows.size(), " "));
}

std::string settings(const Sequence& sequence) {
  const Camera& c = sequence.camera;
  return fmt::format(
      "%YAML:1.0\nCamera.fx: {}\nCamera.fy: {}\nCamera.cx: {}\nCamera.cy: {}\nCamera.k1: 0.0\nCamera.k2: "
      "0.0\n"
      "Camera.p1: 0.0\nCamera.p2: 0.0\nCamera.width: {}\nCamera.height: {}\nCamera.fps: {}\nCamera.RGB: 1\n"
      "Camera.bf: {}\nDepthMapFactor: {}\n",
      c.fx, c.fy, c.cx, c.cy, c.width, c.height, sequence.rate_hz, kBf, kUnits);
}

cv::Mat grey_image(const fs::path& png) {
  cv::Mat grey;
  cv::cvtColor(read_image(png), grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// The masks of the sequence's segmenter; no id where a frame has none.
cv::Mat rectified_masks(const Sequence& sequence, const SequenceFrame& frame) {
  if (frame.masks.empty()) return cv::Mat::zeros(sequence.camera.height, sequence.camera.width, CV_16UC1);
  return rectify(sequence.camera, read_masks(sequence, frame), false);
}

// Poses of frames and objects: the truth's where it is known, else the identity.
class PoseFiles {
 public:
  void add(const ExportSource& source, const SequenceFrame& frame, const cv::Mat& masks) {
    const Pose world_from_camera = source.truth ? camera_pose(source, frame).value_or(Pose{}) : Pose{};
    camera_ += fmt::format("{} {}\n", frame.frame, rows_text(world_from_camera));
    if (source.truth) {
      for (const ObjectAtFrame& object : objects_at(source, frame))
        add_object(frame, object.object->id, world_from_camera * object.camera_from_object);
      return;
    }
    for (const int id : ids_in(masks))
      if (id != 0) add_object(frame, id, {});
  }
  void write(const fs::path& folder) const {
    write_text(folder / "pose_gt.txt", camera_);
    write_text(folder / "object_pose.txt", objects_);
  }

 private:
  void add_object(const SequenceFrame& frame, int id, const Pose& world_from_object) {
    const Eigen::Vector3d& t = world_from_object.translation;
    const Eigen::Vector3d r = log_so3(world_from_object.rotation);
    objects_ +=
        fmt::format("{} {} {} {} {} {} {} {}\n", frame.frame, id, t.x(), t.y(), t.z(), r.x(), r.y(), r.z());
  }

  std::string camera_, objects_;
};

}  // namespace

void write_vdo(const ExportSource& source, const ExportOptions& options, const fs::path& folder) {
  const Sequence& sequence = source.sequence;
  require_images(sequence, "export vdo");
  for (const char* name : {"image_0", "depth", "semantic", "flow"}) fs::create_directories(folder / name);
  const auto flow_of = cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM);
  Progress progress("export vdo", std::ssize(sequence.frames), options.quiet);
  std::string times;
  PoseFiles poses;
  cv::Mat last;
  for (const SequenceFrame& frame : sequence.frames) {
    const std::string number = fmt::format("{:06}", frame.frame);
    const fs::path png = folder / "image_0" / (number + ".png");
    write_color_png(source, frame, true, png);
    if (!frame.depth.empty())
      write_png(folder / "depth" / (number + ".png"),
                disparities(rectify(sequence.camera, read_depth(sequence, frame), false)));
    const cv::Mat masks = rectified_masks(sequence, frame), grey = grey_image(png);
    write_text(folder / "semantic" / (number + ".txt"), ids_text(masks));
    if (!last.empty()) {
      cv::Mat flow;
      flow_of->calc(last, grey, flow);
      write_text(folder / "flow" / fmt::format("{:06}.flo", frame.frame - 1), flo_bytes(flow));
    }
    last = grey;
    times += format_stamp(frame.stamp_ns) + '\n';
    poses.add(source, frame, masks);
    progress.advance();
  }
  write_text(folder / "times.txt", times);
  write_text(folder / "settings.yaml", settings(sequence));
  poses.write(folder);
}

}  // namespace uniquadric
