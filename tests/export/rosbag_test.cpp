#include <array>
#include <cmath>
#include <cstdio>
#include <opencv2/core.hpp>
#include <regex>

#include "core/base/files.h"
#include "harness/rosbag/bag_writer.h"
#include "tests/export/bag_reader.h"
#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

class RosbagExport : public Export {
 protected:
  std::vector<BagMessage> messages = read_bag(run("rosbag") / "small.bag");

  std::vector<BagMessage> of_topic(const std::string& topic, const std::string& type) const {
    const std::vector<BagMessage> found = messages_of_topic(messages, topic);
    for (const BagMessage& message : found) EXPECT_EQ(message.type, type);
    return found;
  }
};

TEST(BagWriter, OnAFullDiskThrowsAndDoesNotEndTheProgram) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  EXPECT_ANY_THROW({
    BagWriter writer("/dev/full");
    writer.image("/image", {1, "camera"}, cv::Mat::zeros(480, 640, CV_8UC3));
    writer.close();
  });
}

TEST_F(RosbagExport, HoldsEveryMessageInOrderOfTime) {
  const std::map<std::string, int> expected = {{"/camera/depth/camera_info", 4},
                                               {"/camera/depth/image_raw", 4},
                                               {"/camera/rgb/camera_info", 4},
                                               {"/camera/rgb/image_raw", 4},
                                               {"/imu", 31},
                                               {"/lidar/points", 3},
                                               {"/livox/lidar", 3},
                                               {"/tf_static", 1},
                                               {"/truth/camera", 4},
                                               {"/truth/object_1", 4},
                                               {"/truth/object_2", 4}};
  EXPECT_EQ(topic_counts(messages, &BagMessage::record_ns), expected);
}

TEST_F(RosbagExport, ImagesHoldThePixels) {
  const auto color = of_topic("/camera/rgb/image_raw", "sensor_msgs/Image"),
             depth = of_topic("/camera/depth/image_raw", "sensor_msgs/Image");
  ASSERT_EQ(color.size(), 4u);
  for (std::size_t i = 0; i < color.size(); ++i) {
    const cv::Mat bgr = sequence_image(sequence_.frames[i].rgb),
                  units = sequence_image(sequence_.frames[i].depth);
    std::string frame;
    MessageReader image(color[i].data);
    EXPECT_EQ(image.header(frame), ros_stamp(i));
    EXPECT_EQ(frame, "camera_optical");
    EXPECT_EQ(image.next<std::uint32_t>(), 120u);
    EXPECT_EQ(image.next<std::uint32_t>(), 160u);
    EXPECT_EQ(image.text(), "bgr8");
    EXPECT_EQ(image.next<std::uint8_t>(), 0);  // little-endian
    EXPECT_EQ(image.next<std::uint32_t>(), 480u);
    EXPECT_EQ(image.text(), std::string(reinterpret_cast<const char*>(bgr.data), 160 * 120 * 3));
    EXPECT_TRUE(image.at_end());
    MessageReader metres(depth[i].data);
    EXPECT_EQ(metres.header(frame), ros_stamp(i));
    EXPECT_EQ(metres.next<std::uint64_t>(), 120u + (160ull << 32));
    EXPECT_EQ(metres.text(), "32FC1");
    metres.next<std::uint8_t>();
    EXPECT_EQ(metres.next<std::uint32_t>(), 640u);
    ASSERT_EQ(metres.next<std::uint32_t>(), 160u * 120 * 4);
    for (int k = 0; k < 160 * 120; ++k) {
      const std::uint16_t value = units.at<std::uint16_t>(k / 160, k % 160);
      const float z = metres.next<float>();
      if (value == 0)
        EXPECT_TRUE(std::isnan(z));
      else
        EXPECT_NEAR(z, value / sequence_.depth_units_per_m, 1e-6);  // single precision
    }
    EXPECT_TRUE(metres.at_end());
  }
}

TEST_F(RosbagExport, CameraInfoAndTransformsPutTheBallsPointsOnItsMask) {
  std::string frame;
  MessageReader info(of_topic("/camera/rgb/camera_info", "sensor_msgs/CameraInfo").at(0).data);
  info.header(frame);
  EXPECT_EQ(info.next<std::uint32_t>(), 120u);
  EXPECT_EQ(info.next<std::uint32_t>(), 160u);
  EXPECT_EQ(info.text(), "plumb_bob");
  EXPECT_EQ(info.next<std::uint32_t>(), 5u);
  EXPECT_EQ(info.doubles(5), std::vector<double>(5, 0.0));
  EXPECT_EQ(info.doubles(9), (std::vector<double>{130, 0, 79.5, 0, 130, 59.5, 0, 0, 1}));
  info.doubles(9);
  const Matrix34d P = matrix34(info.doubles(12));

  const auto tf = of_topic("/tf_static", "tf2_msgs/TFMessage");
  EXPECT_TRUE(tf.at(0).latching);
  MessageReader transforms(tf.at(0).data);
  ASSERT_EQ(transforms.next<std::uint32_t>(), 2u);
  std::map<std::string, Pose> camera_from;
  for (int i = 0; i < 2; ++i) {
    transforms.header(frame);
    EXPECT_EQ(frame, "camera_optical");
    const std::string child = transforms.text();
    const auto v = transforms.doubles(7);
    camera_from[child] = {{v[6], v[3], v[4], v[5]}, {v[0], v[1], v[2]}};
  }
  EXPECT_TRUE(transforms.at_end());
  EXPECT_TRUE(camera_from.at("imu").matrix() == sequence_.imu->camera_from_imu.matrix());

  const auto clouds = of_topic("/lidar/points", "sensor_msgs/PointCloud2");
  int on_mask = 0;
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    MessageReader cloud(clouds[i].data);
    EXPECT_EQ(cloud.header(frame), static_cast<std::uint64_t>(sequence_.scans[i].stamp_ns) + kRosShift_ns);
    EXPECT_EQ(clouds[i].record_ns,
              static_cast<std::uint64_t>(sequence_.scans[i].stamp_ns) + kRosShift_ns + 100'000'000);
    EXPECT_EQ(frame, "lidar");
    EXPECT_EQ(cloud.next<std::uint32_t>(), 1u);
    ASSERT_EQ(cloud.next<std::uint32_t>(), scans_[i].size());
    std::string fields;
    ASSERT_EQ(cloud.next<std::uint32_t>(), 8u);
    for (int k = 0; k < 8; ++k) {
      fields += cloud.text();
      fields += ":" + std::to_string(cloud.next<std::uint32_t>());
      fields += ":" + std::to_string(cloud.next<std::uint8_t>()) + " ";
      EXPECT_EQ(cloud.next<std::uint32_t>(), 1u);
    }
    EXPECT_EQ(fields, "x:0:7 y:4:7 z:8:7 intensity:12:7 t:16:6 time:20:7 ring:24:4 tag:26:2 ");
    EXPECT_EQ(cloud.next<std::uint8_t>(), 0);  // little-endian
    ASSERT_EQ(cloud.next<std::uint32_t>(), 32u);
    EXPECT_EQ(cloud.next<std::uint32_t>(), 32 * scans_[i].size());
    MessageReader points(cloud.text());
    for (const LidarPoint& expected : scans_[i]) {
      const float x = points.next<float>(), y = points.next<float>(), z = points.next<float>();
      EXPECT_EQ(points.next<float>(), expected.intensity);
      EXPECT_EQ(points.next<std::uint32_t>(), expected.offset_ns);
      EXPECT_FLOAT_EQ(points.next<float>(), static_cast<float>(expected.offset_ns * 1e-9));
      EXPECT_EQ(points.next<std::uint16_t>(), expected.ring);
      EXPECT_EQ(points.next<std::uint8_t>(), expected.tag);
      for (int pad = 0; pad < 5; ++pad) points.next<std::uint8_t>();
      const Eigen::Vector3d in_camera = camera_from.at("lidar") * Eigen::Vector3d(x, y, z);
      on_mask += id_at(instances(static_cast<int>(i) + 1), pixel_of(P, in_camera)) == kBall;
    }
    EXPECT_TRUE(points.at_end());
    EXPECT_EQ(cloud.next<std::uint8_t>(), 1);
    EXPECT_TRUE(cloud.at_end());
  }
  EXPECT_EQ(on_mask, 600);
}

TEST_F(RosbagExport, LivoxMessagesHoldThePoints) {
  const auto scans = of_topic("/livox/lidar", "livox_ros_driver/CustomMsg");
  ASSERT_EQ(scans.size(), 3u);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    std::string frame;
    MessageReader message(scans[i].data);
    const std::uint64_t stamp_ns = message.header(frame);
    EXPECT_EQ(message.next<std::uint64_t>(), stamp_ns);
    EXPECT_EQ(message.next<std::uint32_t>(), scans_[i].size());
    for (int k = 0; k < 4; ++k) EXPECT_EQ(message.next<std::uint8_t>(), 0);  // lidar_id, rsvd
    ASSERT_EQ(message.next<std::uint32_t>(), scans_[i].size());
    for (const LidarPoint& expected : scans_[i]) {
      EXPECT_EQ(message.next<std::uint32_t>(), expected.offset_ns);
      EXPECT_EQ(message.next<float>(), expected.x);
      EXPECT_EQ(message.next<float>(), expected.y);
      EXPECT_EQ(message.next<float>(), expected.z);
      EXPECT_EQ(message.next<std::uint8_t>(), expected.intensity);
      EXPECT_EQ(message.next<std::uint8_t>(), expected.tag);
      EXPECT_EQ(message.next<std::uint8_t>(), expected.ring);
    }
    EXPECT_TRUE(message.at_end());
  }
}

TEST_F(RosbagExport, ImuAndTruthReadBack) {
  const auto rows = table(sequence_.folder / "imu.csv", ',');
  const auto imu = of_topic("/imu", "sensor_msgs/Imu");
  ASSERT_EQ(imu.size() + 1, rows.size());
  std::string frame;
  for (std::size_t i = 0; i < imu.size(); ++i) {
    const auto row = numbers(rows[i + 1]);
    MessageReader message(imu[i].data);
    EXPECT_EQ(message.header(frame), static_cast<std::uint64_t>(row[0]) + kRosShift_ns);
    message.doubles(4);
    EXPECT_EQ(message.doubles(9)[0], -1);  // no orientation
    EXPECT_EQ(message.doubles(3), (std::vector<double>{row[1], row[2], row[3]}));
    EXPECT_DOUBLE_EQ(message.doubles(9)[4], 1.6968e-4 * 1.6968e-4 * 100);
    EXPECT_EQ(message.doubles(3), (std::vector<double>{row[4], row[5], row[6]}));
    message.doubles(9);
    EXPECT_TRUE(message.at_end());
  }
  const auto objects = of_topic("/truth/object_1", "geometry_msgs/PoseStamped");
  for (std::size_t i = 0; i < objects.size(); ++i) {
    MessageReader message(objects[i].data);
    EXPECT_EQ(message.header(frame), ros_stamp(i));
    EXPECT_EQ(frame, "world");
    const auto v = message.doubles(7);
    const Pose pose{{v[6], v[3], v[4], v[5]}, {v[0], v[1], v[2]}};
    const Pose& expected = truth_of(kBox, static_cast<int>(i)).ellipsoid.world_from_object;
    EXPECT_LT((pose.matrix() - expected.matrix()).norm(), 1e-14);  // rounding of two products
  }
}

std::string md5_of(const std::string& text) {
  const TempFolder temp;
  write_text(temp.path() / "text", text);
  FILE* pipe = popen(("md5sum " + (temp.path() / "text").string()).c_str(), "r");
  std::array<char, 33> digest{};
  EXPECT_NE(fgets(digest.data(), digest.size(), pipe), nullptr);
  pclose(pipe);
  return digest.data();
}

// What a message's md5 is taken of (genmsg's gentools): no comments, single spaces, types of other messages
// replaced by their md5.
std::string md5_text(std::string definition, const std::map<std::string, std::string>& md5_of_type) {
  definition = std::regex_replace(definition, std::regex("#[^\n]*"), "");
  definition = std::regex_replace(definition, std::regex(" +"), " ");
  definition = std::regex_replace(definition, std::regex(" *\n+"), "\n");
  for (const auto& [type, md5] : md5_of_type)
    definition = std::regex_replace(definition, std::regex(type + R"((\[\])? )"), md5 + " ");
  return std::regex_replace(definition, std::regex("^\n+|\n+$"), "");
}

TEST_F(RosbagExport, LivoxMd5FollowsFromItsDefinition) {
  const BagMessage message = of_topic("/livox/lidar", "livox_ros_driver/CustomMsg").at(0);
  std::vector<std::string> parts;
  const std::regex separator("=+\nMSG: [^\n]*\n");
  for (std::sregex_token_iterator part(message.definition.begin(), message.definition.end(), separator, -1),
       end;
       part != end; ++part)
    parts.push_back(*part);
  ASSERT_EQ(parts.size(), 3u);
  const std::string header = md5_of(md5_text(parts[1], {})), point = md5_of(md5_text(parts[2], {}));
  EXPECT_EQ(header, "2176decaecbce78abc3b96ef049fabed");  // std_msgs/Header
  EXPECT_EQ(md5_of(md5_text(parts[0], {{"std_msgs/Header", header}, {"CustomPoint", point}})),
            message.md5sum);
}

}  // namespace
}  // namespace uniquadric
