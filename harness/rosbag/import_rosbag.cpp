#include "harness/rosbag/import_rosbag.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/import/kitti_files.h"
#include "core/import/omd_readers.h"
#include "core/sequence/file_list.h"
#include "harness/rosbag/bag_images.h"
#include "harness/rosbag/bag_reader.h"
#include "harness/rosbag/bag_topics.h"
#include "harness/rosbag/static_tree.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr const char* kCameraFrame = "camera_optical";  // where no image says it: as `export rosbag` names it
constexpr double kCameraRateHz = 30, kImuRateHz = 200, kLidarRateHz = 10;  // of one message alone

// A message of a topic by its header's stamp.
struct Stamped {
  std::int64_t stamp_ns = 0;
  std::size_t message = 0;
};

// The messages of a topic.
struct Series {
  std::string topic, frame_id;  // of the first
  std::vector<Stamped> messages;
};

class RosbagImport {
 public:
  RosbagImport(const fs::path& path, const ImportRosbagOptions& options)
      : bag_(std::make_shared<BagReader>(path)),
        topics_(choose_topics(*bag_, options.topics)),
        transforms_(bag_->static_transforms()) {
    recording_.sequence = begin_sequence(recording_name(fs::path(path).replace_extension()));
    recording_.sequence.rate_hz = kCameraRateHz;
    if (!topics_.rgb.empty()) read_images();
    if (!topics_.imu.empty()) read_imu();
    if (!topics_.lidar.empty()) read_scans();
    if (!recording_.sequence.frames.empty()) read_truth(options.objects);
    say_what_is_left();
  }

  const Recording& recording() const { return recording_; }

 private:
  // In strictly increasing order of stamps; of messages with one stamp the first is taken.
  Series series(const std::string& topic) {
    Series result{topic, bag_->header(topic, 0).frame_id, {}};
    for (std::size_t i = 0; i < count(topic); ++i)
      result.messages.push_back({bag_->header(topic, i).stamp_ns, i});
    const auto before = result.messages.size();
    std::ranges::stable_sort(result.messages, {}, &Stamped::stamp_ns);
    const auto same = std::ranges::unique(result.messages, {}, &Stamped::stamp_ns);
    result.messages.erase(same.begin(), same.end());
    if (const auto dropped = before - result.messages.size(); dropped > 0)
      recording_.left_out.push_back(
          fmt::format("{}: {} of {} messages have the stamp of another: left out", topic, dropped, before));
    return result;
  }

  std::size_t count(const std::string& topic) const {
    for (const BagTopic& known : bag_->topics())
      if (known.name == topic) return known.messages;
    return 0;
  }

  // Names a message where an image or a scan is refused.
  fs::path source(const std::string& topic, std::size_t message) const {
    return fmt::format("{}: {}, message {}", bag_->path().string(), topic, message);
  }

  void read_images() {
    Sequence& sequence = recording_.sequence;
    sequence.camera = bag_->camera_info(topics_.camera_info, 0);
    const Series rgb = series(topics_.rgb);
    if (!rgb.frame_id.empty()) camera_frame_ = rgb.frame_id;
    for (const Stamped& image : rgb.messages)
      add_frame(sequence, image.stamp_ns, fmt::format("rgb/{:06}.png", sequence.frames.size()));
    sequence.rate_hz = nominal_rate_hz(stamps_of(sequence.frames), kCameraRateHz);
    const Series depth = topics_.depth.empty() ? Series{} : series(topics_.depth);
    associate(depth);
    for (const SequenceFrame& frame : sequence.frames) {
      add_image(rgb, frame.frame, frame.rgb, ImageKind::color, color_of);
      if (!frame.depth.empty())
        add_image(depth, *parse_integer(frame.depth.stem().string()), frame.depth, ImageKind::depth,
                  depth_of);
    }
  }

  void associate(const Series& depth) {
    if (depth.messages.empty()) return;
    Sequence& sequence = recording_.sequence;
    sequence.depth_units_per_m = kBagDepthUnitsPerM;
    std::vector<ListedFile> files;
    for (const Stamped& image : depth.messages)
      files.push_back({image.stamp_ns, image.stamp_ns, fmt::format("depth/{:06}.png", files.size())});
    associate_depth(sequence.frames, files);
    const auto with_depth = std::ranges::count_if(
        sequence.frames, [](const SequenceFrame& frame) { return !frame.depth.empty(); });
    if (with_depth == 0)
      throw InputError(bag_->path(), fmt::format("no image of {} lies within 0.02 s of one of {}",
                                                 depth.topic, topics_.rgb));
    if (with_depth < std::ssize(sequence.frames))
      recording_.left_out.push_back(fmt::format("{}: {} of {} colour images have no depth within 0.02 s",
                                                depth.topic, std::ssize(sequence.frames) - with_depth,
                                                sequence.frames.size()));
  }

  void add_image(const Series& series, std::int64_t index, const fs::path& target, ImageKind kind,
                 cv::Mat (*convert)(const BagImage&, const fs::path&)) {
    const std::size_t message = series.messages.at(static_cast<std::size_t>(index)).message;
    recording_.images.push_back({source(series.topic, message), target, kind,
                                 [bag = bag_, topic = series.topic, message, convert](const fs::path& path) {
                                   return std::optional(convert(bag->image(topic, message), path));
                                 }});
  }

  Pose camera_from(const Series& sensor) {
    if (const auto pose = static_transform(transforms_, camera_frame_, sensor.frame_id)) return *pose;
    recording_.left_out.push_back(
        fmt::format("/tf_static leads from '{}' ({}) to the camera's '{}' on no way: taken is the identity",
                    sensor.frame_id, sensor.topic, camera_frame_));
    return {};
  }

  void read_imu() {
    const Series series = this->series(topics_.imu);
    ImuCalibration& calibration = recording_.sequence.imu.emplace();
    calibration.camera_from_imu = camera_from(series);
    for (const Stamped& stamped : series.messages) {
      ImuSample& sample = recording_.imu.emplace_back(bag_->imu(series.topic, stamped.message).sample);
      sample.stamp_ns = stamped.stamp_ns;
    }
    calibration.rate_hz = nominal_rate_hz(stamps_of(recording_.imu), kImuRateHz);
    const BagImu first = bag_->imu(series.topic, 0);  // white noise at the IMU's rate
    if (first.angular_velocity_variance > 0)
      calibration.gyroscope_noise_radps_rthz =
          std::sqrt(first.angular_velocity_variance / calibration.rate_hz);
    if (first.specific_force_variance > 0)
      calibration.accelerometer_noise_mps2_rthz =
          std::sqrt(first.specific_force_variance / calibration.rate_hz);
  }

  void read_scans() {
    const Series series = this->series(topics_.lidar);
    LidarCalibration& lidar = recording_.sequence.lidar.emplace();
    lidar.pattern = "recorded";
    lidar.camera_from_lidar = camera_from(series);
    auto& scans = recording_.sequence.scans;
    for (const Stamped& stamped : series.messages)
      scans.push_back({stamped.stamp_ns, fmt::format("lidar/{:06}.pcd", scans.size())});
    lidar.rate_hz = nominal_rate_hz(stamps_of(scans), kLidarRateHz);
    const auto fields = std::make_shared<std::set<std::string>>();
    recording_.read_scan = [this, series, fields](const SequenceScan& scan) {
      const auto index = static_cast<std::size_t>(*parse_integer(scan.file.stem().string()));
      return read_points(series.topic, series.messages.at(index).message, *fields);
    };
    recording_.left_out_of_scans = [topic = series.topic, fields] {
      return fields->empty()
                 ? std::vector<std::string>()
                 : std::vector{fmt::format("{}: not taken: field {}", topic, fmt::join(*fields, ", "))};
    };
  }

  // Points without times are all of the scan's stamp.
  std::vector<LidarPoint> read_points(const std::string& topic, std::size_t message,
                                      std::set<std::string>& left_out) const {
    if (is_livox(*bag_, topic)) return bag_->livox(topic, message);
    KittiScan scan = scan_of_points(source(topic, message), bag_->point_cloud(topic, message), 0);
    left_out.insert(scan.left_out.begin(), scan.left_out.end());
    return std::move(scan.points);
  }

  Trajectory read_poses(const std::string& topic) {
    Trajectory trajectory;
    for (const Stamped& stamped : series(topic).messages)
      trajectory.push_back({stamped.stamp_ns, bag_->pose(topic, stamped.message)});
    return trajectory;
  }

  void read_truth(const fs::path& objects) {
    truth_camera_ = truth_camera_topic(*bag_);
    if (truth_camera_.empty()) {
      if (!objects.empty())
        throw InputError(bag_->path(), "has no poses on /truth/camera, which --objects needs");
      return;
    }
    std::map<std::string, Trajectory> bodies;
    for (const std::string& topic : truth_object_topics(*bag_)) bodies[topic] = read_poses(topic);
    set_truth(
        camera_poses(bag_->path(), read_poses(truth_camera_), recording_), bodies,
        [](const auto& object) { return fmt::format("/truth/object_{}", object.id); }, objects, recording_);
  }

  void say_what_is_left() {
    std::set<std::string> taken = {topics_.rgb,   topics_.depth, topics_.camera_info, topics_.imu,
                                   topics_.lidar, truth_camera_, "/tf_static"};
    if (!truth_camera_.empty())
      for (const std::string& topic : truth_object_topics(*bag_)) taken.insert(topic);
    std::vector<std::string> left;
    for (const BagTopic& topic : bag_->topics())
      if (!taken.contains(topic.name)) left.push_back(fmt::format("{} ({})", topic.name, topic.type));
    if (!left.empty())
      recording_.left_out.push_back(fmt::format("topics not taken: {}", fmt::join(left, ", ")));
  }

  std::shared_ptr<BagReader> bag_;
  BagTopicNames topics_;
  std::vector<BagTransform> transforms_;
  std::string camera_frame_ = kCameraFrame, truth_camera_{};
  Recording recording_{};
};

}  // namespace

void import_rosbag(const fs::path& bag, const ImportRosbagOptions& options, const fs::path& out) {
  const RosbagImport import(bag, options);
  write_recording(import.recording(), options, out);
}

}  // namespace uniquadric
