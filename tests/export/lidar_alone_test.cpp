// Sequences of a LiDAR (and an IMU) without images: what of them goes into each format, and what is refused.
#include <map>

#include "core/base/folder_hashes.h"
#include "core/import/kitti.h"
#include "harness/check.h"
#include "harness/info.h"
#include "tests/export/bag_reader.h"
#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

class LidarAlone : public Export {
 protected:
  void SetUp() override {
    Export::SetUp();
    sequence_.frames.clear();
    sequence_.scene_hash.clear();
    sequence_.given_camera.reset();
    rewrite_index();
    for (const char* name :
         {"rgb.txt", "depth.txt", "masks.txt", "camera_given.tum", "rgb", "depth", "masks"})
      fs::remove_all(sequence_.folder / name);
    fs::remove_all(data() / "truth");
    write_hashes(sequence_.folder);
  }
  void without_imu() {
    sequence_.imu.reset();
    rewrite_without_images();
  }
  void rewrite_without_images() {
    rewrite_index();
    fs::remove(sequence_.folder / "rgb.txt");
  }
  void expect_refused(const std::string& format, const std::string& what) {
    const std::string message = input_error([&] { run(format); });
    EXPECT_NE(message.find(what), std::string::npos) << format << ": " << message;
    EXPECT_FALSE(fs::exists(folder() / ("exported-" + format)));
  }
};

TEST_F(LidarAlone, IsDescribedAndChecked) {
  const std::string text = describe(sequence_.folder);
  EXPECT_NE(text.find("frames: 0 over 0.000 s; 0 with depth, 0 with masks\n"), std::string::npos) << text;
  EXPECT_NE(text.find("lidar: by_hand, 10 Hz; 3 scans over 0.200 s\n"), std::string::npos) << text;
  EXPECT_EQ(check_sequence(sequence_.folder), std::vector<std::string>());
}

TEST_F(LidarAlone, ABagHoldsTheScansAndTheImu) {
  if (!UNIQUADRIC_ROSBAG) return expect_refused("rosbag", "was built without rosbag");
  std::map<std::string, int> counts;
  for (const BagMessage& message : read_bag(run("rosbag") / "small.bag")) ++counts[message.topic];
  EXPECT_EQ(counts, (std::map<std::string, int>{
                        {"/imu", 31}, {"/lidar/points", 3}, {"/livox/lidar", 3}, {"/tf_static", 1}}));
}

// Scan by scan, with poses at their ends.
TEST_F(LidarAlone, KittiComesBackByImport) {
  constexpr std::int64_t kPeriod_ns = 100'000'000;
  Trajectory& given = sequence_.given_camera.emplace();
  for (const SequenceScan& scan : sequence_.scans) {
    const Eigen::Vector3d place(1e-9 * static_cast<double>(scan.stamp_ns), 0, 0);
    given.push_back({scan.stamp_ns + kPeriod_ns, Pose{Eigen::Quaterniond::Identity(), place}});
  }
  rewrite_without_images();
  const fs::path out = run("kitti-tracking"), back = folder() / "back";
  EXPECT_FALSE(fs::exists(out / "image_02"));
  EXPECT_FALSE(fs::exists(out / "label_02"));
  ImportKittiOptions options;
  options.quiet = true;
  import_kitti_tracking(out, options, back);
  const Sequence sequence = open_sequence(back);
  EXPECT_TRUE(sequence.frames.empty());
  ASSERT_EQ(sequence.scans.size(), scans_.size());
  EXPECT_EQ(sequence.lidar->rate_hz, 10);
  constexpr double kRounding = 1e-12;
  EXPECT_LT((sequence.lidar->camera_from_lidar.matrix() - sequence_.lidar->camera_from_lidar.matrix()).norm(),
            kRounding);
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    EXPECT_EQ(sequence.scans[i].stamp_ns, sequence_.scans[i].stamp_ns);
    const auto points = read_lidar_points(sequence.folder / sequence.scans[i].file);
    ASSERT_EQ(points.size(), scans_[i].size());
    for (std::size_t j = 0; j < points.size(); ++j) {
      EXPECT_EQ(points[j].x, scans_[i][j].x);
      EXPECT_EQ(points[j].z, scans_[i][j].z);
    }
  }
  ASSERT_TRUE(sequence.given_camera);
  ASSERT_EQ(sequence.given_camera->size(), given.size());
  EXPECT_EQ(sequence.given_camera->back().stamp_ns, given.back().stamp_ns);
  const auto path_m = [](const Trajectory& poses) {
    return (poses.back().pose.translation - poses.front().pose.translation).norm();
  };
  EXPECT_NEAR(path_m(*sequence.given_camera), path_m(given), kRounding);
}

TEST_F(LidarAlone, FormatsOfImagesAreRefused) {
  expect_refused("tum", "has no images, which export tum needs");
  expect_refused("bop", "has no images, which export bop needs");
  const fs::path euroc = run("euroc");
  EXPECT_EQ(table(euroc / "mav0/imu0/data.csv", ',').size(), 31u);
  EXPECT_FALSE(fs::exists(euroc / "mav0/cam0"));
  fs::remove_all(euroc);
  without_imu();
  expect_refused("euroc", "has no images, which export euroc (or an IMU) needs");
}

}  // namespace
}  // namespace uniquadric
