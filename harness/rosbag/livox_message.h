#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <array>
#include <cstdint>
#include <vector>

// The messages of the Livox driver for ROS 1, after its public definitions
// (livox_ros_driver/msg/CustomMsg.msg, CustomPoint.msg), with what roscpp wants to know of them. For
// bag_reader.cpp and bag_writer.cpp alone.
namespace uniquadric {

struct LivoxPoint {
  std::uint32_t offset_time = 0;  ///< [ns] after the message's timebase
  float x = 0, y = 0, z = 0;      ///< [m]
  std::uint8_t reflectivity = 0, tag = 0, line = 0;
};

struct LivoxMessage {
  std_msgs::Header header;
  std::uint64_t timebase = 0;  ///< [ns] of the first point
  std::uint32_t point_num = 0;
  std::uint8_t lidar_id = 0;
  std::array<std::uint8_t, 3> rsvd{};
  std::vector<LivoxPoint> points;
};

/// The definition as a bag carries it: the message's, then those it is made of.
inline constexpr const char* kLivoxDefinition =
    R"(# Livox publish pointcloud msg format.

std_msgs/Header header    # ROS standard message header
uint64 timebase           # The time of first point
uint32 point_num          # Total number of pointclouds
uint8  lidar_id           # Lidar device id number
uint8[3]  rsvd            # Reserved use
CustomPoint[] points      # Pointcloud data

================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id

================================================================================
MSG: livox_ros_driver/CustomPoint
# Livox costom pointcloud format.

uint32 offset_time      # offset time relative to the base time
float32 x               # X axis, unit:m
float32 y               # Y axis, unit:m
float32 z               # Z axis, unit:m
uint8 reflectivity      # reflectivity, 0~255
uint8 tag               # livox tag
uint8 line              # laser number in lidar
)";

}  // namespace uniquadric

namespace ros {
namespace message_traits {

template <>
struct MD5Sum<uniquadric::LivoxMessage> {
  static const char* value() { return "e4d6829bdfe657cb6c21a746c86b21a6"; }  // genmsg's rule
  static const char* value(const uniquadric::LivoxMessage&) { return value(); }
};
template <>
struct DataType<uniquadric::LivoxMessage> {
  static const char* value() { return "livox_ros_driver/CustomMsg"; }
  static const char* value(const uniquadric::LivoxMessage&) { return value(); }
};
template <>
struct Definition<uniquadric::LivoxMessage> {
  static const char* value() { return uniquadric::kLivoxDefinition; }
  static const char* value(const uniquadric::LivoxMessage&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<uniquadric::LivoxPoint> {
  template <typename Stream, typename T>
  static void allInOne(Stream& stream, T point) {
    stream.next(point.offset_time);
    stream.next(point.x);
    stream.next(point.y);
    stream.next(point.z);
    stream.next(point.reflectivity);
    stream.next(point.tag);
    stream.next(point.line);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};
template <>
struct Serializer<uniquadric::LivoxMessage> {
  template <typename Stream, typename T>
  static void allInOne(Stream& stream, T message) {
    stream.next(message.header);
    stream.next(message.timebase);
    stream.next(message.point_num);
    stream.next(message.lidar_id);
    for (auto& byte : message.rsvd) stream.next(byte);
    stream.next(message.points);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
