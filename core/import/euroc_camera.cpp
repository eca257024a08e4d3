#include "core/import/euroc_camera.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/import/fields.h"
#include "core/import/images.h"
#include "core/import/pinhole.h"
#include "core/import/stereo.h"
#include "core/sequence/stamps.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kDepthUnitsPerM = 1000;

cv::Mat color_of(const fs::path& path, const Camera& camera) {
  const auto made = make_color(path);
  const cv::Mat color = made ? *made : read_image(path);
  require_image(path, color, camera, ImageKind::color);
  return color;
}

StereoRig make_rig(const EurocCamera& left, const EurocCamera& right) {
  const Pose right_from_left = right.body_from_camera.inverse() * left.body_from_camera;
  const Eigen::Vector3d& t = right_from_left.translation;
  if (t.x() >= 0 || std::abs(t.y()) > -t.x())
    throw InputError(right.folder / "sensor.yaml", "T_BS: cam1 does not lie to the right of cam0");
  if (left.camera.width != right.camera.width || left.camera.height != right.camera.height)
    throw InputError(right.folder / "sensor.yaml", "resolution: is not that of cam0");
  return {left.camera, right.camera, right_from_left};
}

}  // namespace

std::int64_t read_euroc_stamp(const fs::path& path, int line, std::string_view field) {
  const auto stamp = parse_stamp_of_ns(field);
  if (!stamp || *stamp < 0)
    throw InputError(path, line, fmt::format("'{}' is not a stamp in nanoseconds", field));
  return *stamp;
}

Pose read_body_from_sensor(const ConfigNode& sensor) {
  return read_pose_matrix(sensor.at("T_BS").at("data"));
}

EurocCamera read_euroc_camera(const fs::path& folder) {
  EurocCamera camera{folder, {}, {}, {}};
  const ConfigNode sensor = ConfigNode::load(folder / "sensor.yaml");
  camera.camera = read_pinhole_camera(sensor, "distortion_coefficients");
  camera.body_from_camera = read_body_from_sensor(sensor);
  const fs::path list = folder / "data.csv";
  for_each_row(list, 2, [&](int line, const Fields& fields) {
    const std::int64_t stamp_ns = read_euroc_stamp(list, line, fields[0]);
    if (!camera.images.empty()) require_later(list, line, camera.images.rbegin()->first, stamp_ns);
    if (!is_plain_name(fields[1]) || fields[1].starts_with('.'))
      throw InputError(list, line, fmt::format("'{}' is no name of an image", fields[1]));
    camera.images[stamp_ns] = folder / "data" / fields[1];
    if (!fs::is_regular_file(camera.images[stamp_ns]))
      throw InputError(list, line, fmt::format("file data/{} is missing", fields[1]));
  });
  if (camera.images.empty()) throw InputError(list, "names no image");
  return camera;
}

void add_images(const EurocCamera& camera, Recording& recording) {
  for (const auto& [stamp_ns, source] : camera.images) {
    const std::string name = format_stamp(stamp_ns) + ".png";
    SequenceFrame& frame = add_frame(recording.sequence, stamp_ns, "rgb/" + name);
    recording.images.push_back({source, frame.rgb, ImageKind::color, make_color});
  }
}

void add_stereo(EurocCamera& left, const EurocCamera& right, Recording& recording) {
  const auto rig = std::make_shared<const StereoRig>(make_rig(left, right));
  recording.sequence.depth_units_per_m = kDepthUnitsPerM;
  for (const auto& [stamp_ns, source] : left.images) {
    const std::string name = format_stamp(stamp_ns) + ".png";
    SequenceFrame& frame = add_frame(recording.sequence, stamp_ns, "rgb/" + name);
    recording.images.push_back(
        {source, frame.rgb, ImageKind::color, [rig, camera = left.camera](const fs::path& path) {
           return rig->rectify_left(color_of(path, camera));
         }});
    const auto other = right.images.find(stamp_ns);
    if (other == right.images.end()) continue;
    frame.depth = "depth/" + name;
    recording.images.push_back(
        {source, frame.depth, ImageKind::depth,
         [rig, a = left.camera, b = right.camera, file = other->second](const fs::path& path) {
           return rig->depth(color_of(path, a), color_of(file, b), kDepthUnitsPerM);
         }});
  }
  left.camera = rig->camera();
  left.body_from_camera = left.body_from_camera * rig->rectified_from_left().inverse();
}

}  // namespace uniquadric
