#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/tracks.h"
#include "harness/mcap/mcap_writer.h"
#include "harness/mcap/ros2_messages.h"
#include "tests/export/exported_scene.h"
#include "tests/export/mcap_reader.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

class McapExport : public Export {
 protected:
  static Pose pose_of(const McapMessage& message, const std::string& path, const char* place,
                      const char* turn) {
    const auto at = [&](const std::string& part) { return message.numbers.at(path + "." + part); };
    const std::string p = place, q = turn;
    return {{at(q + ".w"), at(q + ".x"), at(q + ".y"), at(q + ".z")},
            {at(p + ".x"), at(p + ".y"), at(p + ".z")}};
  }
  // parent_from_child by the child's name.
  static std::map<std::string, Pose> transforms_of(const McapMessage& message) {
    std::map<std::string, Pose> transforms;
    for (int i = 0; i < message.numbers.at("transforms.count"); ++i) {
      const std::string path = "transforms[" + std::to_string(i) + "]";
      transforms[message.texts.at(path + ".child_frame_id")] =
          pose_of(message, path + ".transform", "translation", "rotation");
    }
    return transforms;
  }
};

TEST_F(McapExport, HoldsEveryMessageInOrderOfTime) {
  const std::map<std::string, int> expected = {{"/camera/depth/camera_info", 4},
                                               {"/camera/depth/image_raw", 4},
                                               {"/camera/rgb/camera_info", 4},
                                               {"/camera/rgb/image_raw", 4},
                                               {"/imu", 31},
                                               {"/lidar/points", 3},
                                               {"/tf", 4},
                                               {"/tf_static", 1},
                                               {"/truth/objects", 4}};
  EXPECT_EQ(topic_counts(read_mcap(run("mcap") / "small.mcap"), &McapMessage::time_ns), expected);
}

TEST_F(McapExport, ImagesHoldThePixels) {
  const auto messages = read_mcap(run("mcap") / "small.mcap");
  const auto color = messages_of_topic(messages, "/camera/rgb/image_raw"),
             depth = messages_of_topic(messages, "/camera/depth/image_raw");
  ASSERT_EQ(color.size(), 4u);
  for (std::size_t i = 0; i < color.size(); ++i) {
    EXPECT_EQ(color[i].time_ns, ros_stamp(i));
    EXPECT_EQ(color[i].texts.at("header.frame_id"), "camera_optical");
    EXPECT_EQ(color[i].numbers.at("height"), 120);
    EXPECT_EQ(color[i].numbers.at("width"), 160);
    const cv::Mat bgr = sequence_image(sequence_.frames[i].rgb),
                  units = sequence_image(sequence_.frames[i].depth);
    EXPECT_EQ(color[i].texts.at("data"), std::string(reinterpret_cast<const char*>(bgr.data), 160 * 120 * 3));
    const std::string& bytes = depth[i].texts.at("data");
    ASSERT_EQ(bytes.size(), 160u * 120 * 4);
    for (int k = 0; k < 160 * 120; ++k) {
      float z_m = 0;
      std::memcpy(&z_m, bytes.data() + 4 * k, 4);
      const std::uint16_t value = units.at<std::uint16_t>(k / 160, k % 160);
      if (value == 0)
        EXPECT_TRUE(std::isnan(z_m));
      else
        EXPECT_NEAR(z_m, value / sequence_.depth_units_per_m, 1e-6);
    }
  }
}

TEST_F(McapExport, ScansImuAndTransformsAreTheSequences) {
  const auto messages = read_mcap(run("mcap") / "small.mcap");
  const auto fixed = transforms_of(messages_of_topic(messages, "/tf_static").at(0));
  EXPECT_TRUE(fixed.at("imu").matrix() == sequence_.imu->camera_from_imu.matrix());
  EXPECT_TRUE(fixed.at("lidar").matrix() == sequence_.lidar->camera_from_lidar.matrix());
  const auto clouds = messages_of_topic(messages, "/lidar/points");
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    const std::string& bytes = clouds[i].texts.at("data");
    ASSERT_EQ(bytes.size(), 24 * scans_[i].size());
    float x = 0;
    std::memcpy(&x, bytes.data() + 24, 4);
    EXPECT_EQ(x, scans_[i][1].x);
    EXPECT_EQ(clouds[i].texts.at("fields[3].name"), "intensity");
  }
  const McapMessage imu = messages_of_topic(messages, "/imu").at(0);
  EXPECT_NEAR(imu.numbers.at("orientation_covariance[0]"), -1, 0);
  const auto moving = messages_of_topic(messages, "/tf");
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto poses = transforms_of(moving.at(static_cast<std::size_t>(frame)));
    for (const int id : {kBox, kBall})
      EXPECT_TRUE(poses.at("object_" + std::to_string(id))
                      .matrix()
                      .isApprox(truth_of(id, frame).ellipsoid.world_from_object.matrix(), 1e-9));
  }
}

TEST_F(McapExport, SolidsOfTruthAndEstimateAreMarkers) {
  Tracks estimate = truth_;
  const Pose moved{exp_so3({0, 0, 0.3}), {1, 2, 0}};  // an estimate's world is its own
  for (auto& stamped : estimate.camera) stamped.pose = moved * stamped.pose;
  for (ObjectTrack& track : estimate.objects)
    for (ObjectState& state : track.states) {
      state.ellipsoid.world_from_object = moved * state.ellipsoid.world_from_object;
      state.exponents = {1.5, 1.5, 1.5};
    }
  fs::create_directories(folder() / "estimate/objects");
  write_estimate(folder() / "estimate", estimate);
  ExportOptions options;
  options.estimate = folder() / "estimate";
  const auto messages = read_mcap(run("mcap", options) / "small.mcap");
  const McapMessage truth = messages_of_topic(messages, "/truth/objects").at(2),
                    found = messages_of_topic(messages, "/estimate/objects").at(2);
  EXPECT_EQ(truth.numbers.at("markers.count"), 3);
  EXPECT_EQ(truth.numbers.at("markers[0].action"), 3);  // what was there before goes
  EXPECT_EQ(truth.numbers.at("markers[1].type"), 1);    // the box, a cube
  EXPECT_EQ(truth.numbers.at("markers[2].type"), 2);    // the ball, a sphere
  const ObjectState& box = truth_of(kBox, 2);
  EXPECT_NEAR(truth.numbers.at("markers[1].scale.x"), 2 * box.ellipsoid.semi_axes_m.x(), 1e-12);
  EXPECT_EQ(found.numbers.at("markers[1].type"), 11);
  const Pose world_from_estimate =
      transforms_of(messages_of_topic(messages, "/tf_static").at(0)).at("estimate_world");
  const Pose placed = world_from_estimate * pose_of(found, "markers[1].pose", "position", "orientation");
  EXPECT_TRUE(placed.matrix().isApprox(box.ellipsoid.world_from_object.matrix(), 1e-6));
  Eigen::Vector3d most = Eigen::Vector3d::Zero();  // the triangles reach to the semi-axes
  for (int i = 0; i < found.numbers.at("markers[1].points.count"); ++i) {
    const std::string path = "markers[1].points[" + std::to_string(i) + "]";
    for (int k = 0; k < 3; ++k)
      most[k] = std::max(most[k], std::abs(found.numbers.at(path + "." + "xyz"[k])));
  }
  EXPECT_TRUE(most.isApprox(box.ellipsoid.semi_axes_m, 1e-6)) << most.transpose();
  EXPECT_THROW(run("tum", options), InputError);  // has no place for it
}

TEST(McapWriter, ChunksFollowEachOther) {
  const TempFolder temp;
  McapWriter writer(temp.path() / "long.mcap");
  const cv::Mat image = cv::Mat::zeros(1000, 1000, CV_8UC3);  // 3 MB: two a chunk
  for (int i = 0; i < 5; ++i) writer.write("/image", kImageSchema, i, image_message({i, "camera"}, image));
  writer.close();
  EXPECT_EQ(read_mcap(temp.path() / "long.mcap").size(), 5u);
}

TEST(McapWriter, OnAFullDiskSaysSo) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  EXPECT_THROW(
      {
        McapWriter writer("/dev/full");
        writer.write("/image", kImageSchema, 1, image_message({1, "c"}, cv::Mat::zeros(480, 640, CV_8UC3)));
        writer.close();
      },
      InputError);
}

}  // namespace
}  // namespace uniquadric
