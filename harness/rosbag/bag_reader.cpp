#include "harness/rosbag/bag_reader.h"

#include <fmt/format.h>
#include <geometry_msgs/PoseStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/read_file.h"
#include "harness/rosbag/livox_message.h"

namespace uniquadric {
namespace {

constexpr double kUnitTolerance = 1e-3;  // of a quaternion's norm

template <typename Vector>
Eigen::Vector3d vector_of(const Vector& v) {
  return {v.x, v.y, v.z};
}

// The type of an encoding's pixels; -1 for others.
int pixel_type(const std::string& encoding) {
  static const std::map<std::string, int> kTypes = {
      {"bgr8", CV_8UC3},  {"rgb8", CV_8UC3}, {"8UC3", CV_8UC3},    {"bgra8", CV_8UC4},  {"rgba8", CV_8UC4},
      {"mono8", CV_8UC1}, {"8UC1", CV_8UC1}, {"mono16", CV_16UC1}, {"16UC1", CV_16UC1}, {"32FC1", CV_32FC1}};
  const auto type = kTypes.find(encoding);
  return type == kTypes.end() ? -1 : type->second;
}

// PCD's name of a PointField's type; size 0 where there is none.
PcdField pcd_field(const sensor_msgs::PointField& field) {
  static constexpr char kTypes[] = {'I', 'U', 'I', 'U', 'I', 'U', 'F', 'F'};
  static constexpr int kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  if (field.datatype < 1 || field.datatype > 8) return {field.name, 0, 'U', 1};
  return {field.name, kSizes[field.datatype - 1], kTypes[field.datatype - 1], 1};
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace

struct BagReader::Impl {
  const std::filesystem::path& path;
  rosbag::Bag bag{};
  std::map<std::string, std::vector<rosbag::MessageInstance>> messages{};

  explicit Impl(const std::filesystem::path& file) : path(file) {
    require_regular_file(file);
    try {
      bag.open(file.string(), rosbag::bagmode::Read);
      rosbag::View view(bag);
      for (const rosbag::MessageInstance& message : view) messages[message.getTopic()].push_back(message);
    } catch (const rosbag::BagUnindexedException&) {
      throw InputError(file, "is a bag without index, as of a recorder that was stopped: rosbag reindex");
    } catch (const std::exception& e) {  // of rosbag, of any kind
      throw InputError(file, "is no bag of ROS 1 that can be read: " + one_line(e.what()));
    }
  }

  [[noreturn]] void fail(const std::string& topic, std::size_t message, const std::string& what) const {
    throw InputError(path, fmt::format("{}, message {}: {}", topic, message, what));
  }

  // What `use` makes of a message, whatever rosbag throws meanwhile being the file's fault.
  template <typename Use>
  auto with(const std::string& topic, std::size_t message, const Use& use) const {
    try {
      return use(messages.at(topic).at(message));
    } catch (const InputError&) {
      throw;
    } catch (const std::exception& e) {
      fail(topic, message, "cannot be read: " + one_line(e.what()));
    }
  }

  template <typename Message>
  boost::shared_ptr<Message> read(const std::string& topic, std::size_t message) const {
    return with(topic, message, [&](const rosbag::MessageInstance& instance) {
      auto result = instance.instantiate<Message>();
      if (!result)
        fail(topic, message,
             fmt::format("{} is of another definition than is known", instance.getDataType()));
      return result;
    });
  }
};

BagReader::BagReader(const std::filesystem::path& path) : path_(path), impl_(std::make_unique<Impl>(path_)) {}

BagReader::~BagReader() = default;

std::vector<BagTopic> BagReader::topics() const {
  std::vector<BagTopic> topics;
  for (const auto& [name, messages] : impl_->messages)
    topics.push_back({name, messages.front().getDataType(), messages.size()});
  return topics;
}

BagHeader BagReader::header(const std::string& topic, std::size_t message) const {
  return impl_->with(topic, message, [&](const rosbag::MessageInstance& instance) {
    std::vector<std::uint8_t> bytes(instance.size());
    const auto size = static_cast<std::uint32_t>(bytes.size());
    ros::serialization::OStream out(bytes.data(), size);
    instance.write(out);
    std_msgs::Header header;
    ros::serialization::IStream in(bytes.data(), size);
    ros::serialization::deserialize(in, header);
    if (header.stamp.isZero()) impl_->fail(topic, message, "has no stamp");
    return BagHeader{static_cast<std::int64_t>(header.stamp.toNSec()), header.frame_id};
  });
}

BagImage BagReader::image(const std::string& topic, std::size_t message) const {
  if (impl_->messages.at(topic).front().getDataType() == "sensor_msgs/CompressedImage") {
    const auto read = impl_->read<sensor_msgs::CompressedImage>(topic, message);
    return {read->format, {}, std::string(read->data.begin(), read->data.end())};
  }
  const auto read = impl_->read<sensor_msgs::Image>(topic, message);
  const int type = pixel_type(read->encoding);
  if (type < 0) return {read->encoding, {}, {}};
  const std::size_t row = read->width * CV_ELEM_SIZE(type);
  if (read->width == 0 || read->height == 0 || read->step < row ||
      read->data.size() < std::size_t{read->step} * read->height)
    impl_->fail(topic, message, "has fewer bytes than its size says");
  if (read->is_bigendian && CV_ELEM_SIZE1(type) > 1) impl_->fail(topic, message, "is big-endian");
  const cv::Mat pixels(static_cast<int>(read->height), static_cast<int>(read->width), type, read->data.data(),
                       read->step);
  return {read->encoding, pixels.clone(), {}};
}

Camera BagReader::camera_info(const std::string& topic, std::size_t message) const {
  const auto info = impl_->read<sensor_msgs::CameraInfo>(topic, message);
  const auto& model = info->distortion_model;
  const auto& D = info->D;
  const bool is_ideal = std::all_of(D.begin(), D.end(), [](double d) { return d == 0; });
  const bool is_brown = model == "plumb_bob" || (model == "rational_polynomial" && D.size() <= 8);
  if (!is_ideal && !is_brown)
    impl_->fail(topic, message, fmt::format("distortion_model {}: expected plumb_bob", model));
  if (std::any_of(D.begin() + std::min<std::ptrdiff_t>(5, D.end() - D.begin()), D.end(),
                  [](double d) { return d != 0; }))
    impl_->fail(topic, message, "D: expected at most five coefficients other than 0");
  Camera camera;
  camera.width = static_cast<int>(info->width), camera.height = static_cast<int>(info->height);
  camera.fx = info->K[0], camera.fy = info->K[4], camera.cx = info->K[2], camera.cy = info->K[5];
  std::copy_n(D.begin(), std::min(D.size(), camera.distortion.size()), camera.distortion.begin());
  if (!(camera.fx > 0 && camera.fy > 0)) impl_->fail(topic, message, "K: the camera is not calibrated");
  return camera;
}

BagImu BagReader::imu(const std::string& topic, std::size_t message) const {
  const auto read = impl_->read<sensor_msgs::Imu>(topic, message);
  BagImu imu;
  imu.sample.angular_velocity_radps = vector_of(read->angular_velocity);
  imu.sample.specific_force_mps2 = vector_of(read->linear_acceleration);
  if (!imu.sample.angular_velocity_radps.allFinite() || !imu.sample.specific_force_mps2.allFinite())
    impl_->fail(topic, message, "is not finite");
  imu.angular_velocity_variance = read->angular_velocity_covariance[0];
  imu.specific_force_variance = read->linear_acceleration_covariance[0];
  return imu;
}

PcdFile BagReader::point_cloud(const std::string& topic, std::size_t message) const {
  const auto cloud = impl_->read<sensor_msgs::PointCloud2>(topic, message);
  if (cloud->is_bigendian) impl_->fail(topic, message, "is big-endian");
  if (cloud->data.size() < std::size_t{cloud->row_step} * cloud->height ||
      cloud->row_step < std::size_t{cloud->point_step} * cloud->width)
    impl_->fail(topic, message, "has fewer bytes than its size says");
  PcdFile file;
  std::vector<std::size_t> offsets;
  for (const auto& field : cloud->fields) {
    const PcdField column = pcd_field(field);
    if (column.size == 0 || field.count > 1) continue;
    if (std::size_t{field.offset} + static_cast<std::size_t>(column.size) > cloud->point_step)
      impl_->fail(topic, message, fmt::format("field {} lies beyond the point", field.name));
    file.fields.push_back(column);
    offsets.push_back(field.offset);
  }
  for (std::size_t row = 0; row < cloud->height; ++row)
    for (std::size_t i = 0; i < cloud->width; ++i) {
      const std::uint8_t* point = cloud->data.data() + row * cloud->row_step + i * cloud->point_step;
      for (std::size_t k = 0; k < offsets.size(); ++k)
        file.data.append(reinterpret_cast<const char*>(point) + offsets[k],
                         static_cast<std::size_t>(file.fields[k].size));
    }
  file.points = std::int64_t{cloud->height} * cloud->width;
  return file;
}

std::vector<LidarPoint> BagReader::livox(const std::string& topic, std::size_t message) const {
  std::vector<LidarPoint> points;
  const auto scan = impl_->read<LivoxMessage>(topic, message);
  for (const LivoxPoint& p : scan->points) {
    LidarPoint point;
    point.x = p.x, point.y = p.y, point.z = p.z;
    point.intensity = p.reflectivity;
    point.offset_ns = p.offset_time;
    point.ring = p.line;
    point.tag = p.tag;
    points.push_back(point);
  }
  return points;
}

Pose BagReader::pose(const std::string& topic, std::size_t message) const {
  const auto read = impl_->read<geometry_msgs::PoseStamped>(topic, message);
  const auto& q = read->pose.orientation;
  Pose pose;
  pose.rotation = Eigen::Quaterniond(q.w, q.x, q.y, q.z);
  pose.translation = vector_of(read->pose.position);
  if (!(std::abs(pose.rotation.norm() - 1) < kUnitTolerance) || !pose.translation.allFinite())
    impl_->fail(topic, message, "is no pose: its quaternion is not of norm 1, or it is not finite");
  return pose;
}

std::vector<BagTransform> BagReader::static_transforms() const {
  std::vector<BagTransform> transforms;
  const auto found = impl_->messages.find("/tf_static");
  if (found == impl_->messages.end()) return transforms;
  for (std::size_t i = 0; i < found->second.size(); ++i) {
    const auto read = impl_->read<tf2_msgs::TFMessage>("/tf_static", i);
    for (const auto& stamped : read->transforms) {
      const auto& q = stamped.transform.rotation;
      BagTransform transform;
      transform.parent = stamped.header.frame_id, transform.child = stamped.child_frame_id;
      transform.parent_from_child.rotation = Eigen::Quaterniond(q.w, q.x, q.y, q.z);
      transform.parent_from_child.translation = vector_of(stamped.transform.translation);
      if (!(std::abs(transform.parent_from_child.rotation.norm() - 1) < kUnitTolerance))
        impl_->fail("/tf_static", i, fmt::format("{}: its quaternion is not of norm 1", transform.child));
      transforms.push_back(transform);
    }
  }
  return transforms;
}

}  // namespace uniquadric
