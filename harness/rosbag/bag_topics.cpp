#include "harness/rosbag/bag_topics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string_view>

#include "core/base/error.h"
#include "harness/rosbag/bag_reader.h"

namespace uniquadric {
namespace {

using Names = std::vector<std::string>;

constexpr const char* kImage = "sensor_msgs/Image";
constexpr const char* kCompressedImage = "sensor_msgs/CompressedImage";
constexpr const char* kCameraInfo = "sensor_msgs/CameraInfo";
constexpr const char* kImu = "sensor_msgs/Imu";
constexpr const char* kPointCloud = "sensor_msgs/PointCloud2";
constexpr const char* kPose = "geometry_msgs/PoseStamped";
constexpr std::string_view kTruth = "/truth/", kObject = "/truth/object_";
const Names kLivox = {"livox_ros_driver/CustomMsg", "livox_ros_driver2/CustomMsg"};

bool is_one_of(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Names topics_where(const BagReader& bag, const std::function<bool(const BagTopic&)>& is_wanted) {
  Names names;
  for (const BagTopic& topic : bag.topics())
    if (is_wanted(topic)) names.push_back(topic.name);
  return names;
}

Names topics_of(const BagReader& bag, const Names& types) {
  return topics_where(bag, [&](const BagTopic& topic) { return is_one_of(types, topic.type); });
}

// Topics whose first image has one of these encodings.
Names images_of(const BagReader& bag, const Names& encodings) {
  return topics_where(bag, [&](const BagTopic& topic) {
    return topic.type == kImage && is_one_of(encodings, bag.image(topic.name, 0).encoding);
  });
}

// Depth is compressed in a way of its own, by the plugin that names such topics.
Names compressed_images(const BagReader& bag) {
  return topics_where(bag, [&](const BagTopic& topic) {
    return topic.type == kCompressedImage && topic.name.find("compressedDepth") == std::string::npos;
  });
}

std::string the_only(const BagReader& bag, const Names& names, const char* what, const char* option) {
  if (names.size() > 1)
    throw InputError(bag.path(), fmt::format("has {} topics of {}, {}: name one, {}", names.size(), what,
                                             fmt::join(names, ", "), option));
  return names.empty() ? "" : names.front();
}

void require_topic(const BagReader& bag, const std::string& name, const Names& types) {
  if (name.empty()) return;
  for (const BagTopic& topic : bag.topics()) {
    if (topic.name != name) continue;
    if (is_one_of(types, topic.type)) return;
    throw InputError(bag.path(), fmt::format("topic {} is of {}, expected {}", name, topic.type,
                                             fmt::join(types, " or ")));
  }
  throw InputError(bag.path(), fmt::format("has no topic {}", name));
}

std::string find_rgb(const BagReader& bag) {
  for (const Names& names : {images_of(bag, {"rgb8", "bgr8", "8UC3", "rgba8", "bgra8"}),
                             compressed_images(bag), images_of(bag, {"mono8", "8UC1"})})
    if (!names.empty()) return the_only(bag, names, "colour images", "--rgb-topic");
  return "";
}

std::string folder_of(const std::string& topic) {
  return topic.substr(0, topic.find_last_of('/'));
}

// By ROS's convention a camera's calibration lies beside its images; compressed ones lie one folder deeper.
std::string find_camera_info(const BagReader& bag, const std::string& rgb) {
  const Names all = topics_of(bag, {kCameraInfo});
  for (const std::string& folder : {folder_of(rgb), folder_of(folder_of(rgb))})
    if (is_one_of(all, folder + "/camera_info")) return folder + "/camera_info";
  return the_only(bag, all, kCameraInfo, "--camera-info-topic");
}

bool has_times(const BagReader& bag, const std::string& topic) {
  static const Names kTimes = {"t", "offset_time", "time", "timestamp"};
  const PcdFile cloud = bag.point_cloud(topic, 0);
  return std::any_of(cloud.fields.begin(), cloud.fields.end(),
                     [](const PcdField& field) { return is_one_of(kTimes, field.name); });
}

// One LiDAR may send both types: Livox's points have times, those of its other type have none.
std::string find_lidar(const BagReader& bag) {
  const Names clouds = topics_of(bag, {kPointCloud}), livox = topics_of(bag, kLivox);
  if (clouds.size() == 1 && livox.size() == 1)
    return has_times(bag, clouds.front()) ? clouds.front() : livox.front();
  Names all = clouds;
  all.insert(all.end(), livox.begin(), livox.end());
  return the_only(bag, all, "a LiDAR's points", "--lidar-topic");
}

}  // namespace

BagTopicNames choose_topics(const BagReader& bag, const BagTopicNames& wanted) {
  require_topic(bag, wanted.rgb, {kImage, kCompressedImage});
  require_topic(bag, wanted.depth, {kImage});
  require_topic(bag, wanted.camera_info, {kCameraInfo});
  require_topic(bag, wanted.imu, {kImu});
  require_topic(bag, wanted.lidar, {kPointCloud, kLivox[0], kLivox[1]});
  BagTopicNames topics = wanted;
  if (topics.rgb.empty()) topics.rgb = find_rgb(bag);
  if (topics.depth.empty() && !topics.rgb.empty())
    topics.depth =
        the_only(bag, images_of(bag, {"16UC1", "mono16", "32FC1"}), "depth images", "--depth-topic");
  if (topics.camera_info.empty() && !topics.rgb.empty())
    topics.camera_info = find_camera_info(bag, topics.rgb);
  if (topics.imu.empty()) topics.imu = the_only(bag, topics_of(bag, {kImu}), kImu, "--imu-topic");
  if (topics.lidar.empty()) topics.lidar = find_lidar(bag);
  if (topics.rgb.empty() && topics.lidar.empty())
    throw InputError(bag.path(), "has neither colour images nor points of a LiDAR");
  if (!topics.rgb.empty() && topics.camera_info.empty())
    throw InputError(bag.path(), fmt::format("has images on {} and no {}", topics.rgb, kCameraInfo));
  return topics;
}

bool is_livox(const BagReader& bag, const std::string& topic) {
  return is_one_of(topics_of(bag, kLivox), topic);
}

std::string truth_camera_topic(const BagReader& bag) {
  const Names poses = topics_of(bag, {kPose});
  const std::string camera = std::string(kTruth) + "camera";
  return is_one_of(poses, camera) ? camera : "";
}

Names truth_object_topics(const BagReader& bag) {
  Names poses = topics_of(bag, {kPose});
  std::erase_if(poses, [](const std::string& name) { return !name.starts_with(kObject); });
  return poses;
}

}  // namespace uniquadric
