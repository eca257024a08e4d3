#include "harness/rosbag/bag_writer.h"

#include <geometry_msgs/PoseStamped.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>

#include "harness/rosbag/livox_message.h"

namespace uniquadric {
namespace {

ros::Time ros_time(std::int64_t stamp_ns) {
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(stamp_ns));
  return time;
}

std_msgs::Header ros_header(const BagHeader& header) {
  std_msgs::Header message;
  message.stamp = ros_time(header.stamp_ns);
  message.frame_id = header.frame_id;
  return message;
}

template <typename Vector>
void set_vector(Vector& message, const Eigen::Vector3d& v) {
  message.x = v.x(), message.y = v.y(), message.z = v.z();
}

template <typename Rotation>
void set_rotation(Rotation& message, const Eigen::Quaterniond& q) {
  message.x = q.x(), message.y = q.y(), message.z = q.z(), message.w = q.w();
}

template <typename Covariance>
void set_variance(Covariance& covariance, double variance) {
  for (std::size_t i : {0, 4, 8}) covariance[i] = variance;
}

constexpr std::uint32_t kCloudPointSize = 32;  // as drivers pad it

std::vector<sensor_msgs::PointField> cloud_fields() {
  std::vector<sensor_msgs::PointField> fields;
  const auto add = [&](const char* name, std::uint32_t offset, std::uint8_t type) {
    fields.emplace_back();
    fields.back().name = name;
    fields.back().offset = offset;
    fields.back().datatype = type;
    fields.back().count = 1;
  };
  using Field = sensor_msgs::PointField;
  add("x", 0, Field::FLOAT32);
  add("y", 4, Field::FLOAT32);
  add("z", 8, Field::FLOAT32);
  add("intensity", 12, Field::FLOAT32);
  add("t", 16, Field::UINT32);
  add("time", 20, Field::FLOAT32);
  add("ring", 24, Field::UINT16);
  add("tag", 26, Field::UINT8);
  return fields;
}

void put_cloud_point(const LidarPoint& p, std::uint8_t* bytes) {
  const float time_s = static_cast<float>(p.offset_ns * 1e-9);
  const float xyzi[] = {p.x, p.y, p.z, p.intensity};
  std::memcpy(bytes, xyzi, sizeof xyzi);
  std::memcpy(bytes + 16, &p.offset_ns, sizeof p.offset_ns);
  std::memcpy(bytes + 20, &time_s, sizeof time_s);
  std::memcpy(bytes + 24, &p.ring, sizeof p.ring);
  std::memcpy(bytes + 26, &p.tag, sizeof p.tag);
}

}  // namespace

// rosbag::Bag closes in its destructor, where what a full disk makes it throw would end the program: a bag
// that cannot be closed is never destroyed.
struct BagWriter::Impl {
  ~Impl() {
    try {
      owner->close();
    } catch (const std::exception&) {
      static_cast<void>(owner.release());
    }
  }
  std::unique_ptr<rosbag::Bag> owner = std::make_unique<rosbag::Bag>();
  rosbag::Bag& bag = *owner;
};

BagWriter::BagWriter(const std::filesystem::path& path) : impl_(std::make_unique<Impl>()) {
  impl_->bag.open(path.string(), rosbag::bagmode::Write);
}

BagWriter::~BagWriter() = default;

void BagWriter::close() {
  impl_->bag.close();
}

void BagWriter::image(const std::string& topic, const BagHeader& header, const cv::Mat& image) {
  sensor_msgs::Image message;
  message.header = ros_header(header);
  message.width = static_cast<std::uint32_t>(image.cols);
  message.height = static_cast<std::uint32_t>(image.rows);
  message.encoding = image.type() == CV_8UC3 ? "bgr8" : "32FC1";
  message.step = static_cast<std::uint32_t>(image.cols * image.elemSize());
  for (int v = 0; v < image.rows; ++v)
    message.data.insert(message.data.end(), image.ptr(v), image.ptr(v) + message.step);
  impl_->bag.write(topic, message.header.stamp, message);
}

void BagWriter::camera_info(const std::string& topic, const BagHeader& header, const Camera& camera) {
  sensor_msgs::CameraInfo message;
  message.header = ros_header(header);
  message.width = static_cast<std::uint32_t>(camera.width);
  message.height = static_cast<std::uint32_t>(camera.height);
  message.distortion_model = "plumb_bob";
  message.D.assign(camera.distortion.begin(), camera.distortion.end());
  message.K = {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  message.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  message.P = {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0};
  impl_->bag.write(topic, message.header.stamp, message);
}

void BagWriter::imu(const std::string& topic, const BagHeader& header, const ImuSample& sample,
                    const ImuCalibration& calibration) {
  sensor_msgs::Imu message;
  message.header = ros_header(header);
  message.orientation.w = 1;
  message.orientation_covariance[0] = -1;  // ROS: no orientation is given
  set_vector(message.angular_velocity, sample.angular_velocity_radps);
  set_vector(message.linear_acceleration, sample.specific_force_mps2);
  set_variance(message.angular_velocity_covariance,
               std::pow(calibration.gyroscope_noise_radps_rthz, 2) * calibration.rate_hz);
  set_variance(message.linear_acceleration_covariance,
               std::pow(calibration.accelerometer_noise_mps2_rthz, 2) * calibration.rate_hz);
  impl_->bag.write(topic, message.header.stamp, message);
}

void BagWriter::point_cloud(const std::string& topic, const BagHeader& header, std::int64_t record_ns,
                            const std::vector<LidarPoint>& points) {
  sensor_msgs::PointCloud2 message;
  message.header = ros_header(header);
  message.height = 1;
  message.width = static_cast<std::uint32_t>(points.size());
  message.fields = cloud_fields();
  message.point_step = kCloudPointSize;
  message.row_step = kCloudPointSize * message.width;
  message.is_dense = true;
  message.data.resize(message.row_step);
  for (std::size_t i = 0; i < points.size(); ++i)
    put_cloud_point(points[i], message.data.data() + i * kCloudPointSize);
  impl_->bag.write(topic, ros_time(record_ns), message);
}

void BagWriter::livox(const std::string& topic, const BagHeader& header, std::int64_t record_ns,
                      const std::vector<LidarPoint>& points) {
  LivoxMessage message;
  message.header = ros_header(header);
  message.timebase = static_cast<std::uint64_t>(header.stamp_ns);
  message.point_num = static_cast<std::uint32_t>(points.size());
  for (const LidarPoint& p : points)
    message.points.push_back({p.offset_ns, p.x, p.y, p.z, static_cast<std::uint8_t>(std::lround(p.intensity)),
                              p.tag, static_cast<std::uint8_t>(p.ring)});
  impl_->bag.write(topic, ros_time(record_ns), message);
}

void BagWriter::pose(const std::string& topic, const BagHeader& header, const Pose& pose) {
  geometry_msgs::PoseStamped message;
  message.header = ros_header(header);
  set_vector(message.pose.position, pose.translation);
  set_rotation(message.pose.orientation, pose.rotation);
  impl_->bag.write(topic, message.header.stamp, message);
}

void BagWriter::static_transforms(std::int64_t stamp_ns, const std::vector<BagTransform>& transforms) {
  tf2_msgs::TFMessage message;
  for (const BagTransform& transform : transforms) {
    message.transforms.emplace_back();
    auto& stamped = message.transforms.back();
    stamped.header = ros_header({stamp_ns, transform.parent});
    stamped.child_frame_id = transform.child;
    set_vector(stamped.transform.translation, transform.parent_from_child.translation);
    set_rotation(stamped.transform.rotation, transform.parent_from_child.rotation);
  }
  const auto connection = boost::make_shared<ros::M_string>();
  using Traits = tf2_msgs::TFMessage;
  (*connection)["type"] = ros::message_traits::DataType<Traits>::value();
  (*connection)["md5sum"] = ros::message_traits::MD5Sum<Traits>::value();
  (*connection)["message_definition"] = ros::message_traits::Definition<Traits>::value();
  (*connection)["latching"] = "1";
  impl_->bag.write("/tf_static", ros_time(stamp_ns), message, connection);
}

}  // namespace uniquadric
