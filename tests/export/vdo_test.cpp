#include <cstring>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/import/omd.h"
#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// The step of a disparity at a depth, half of it, and of millimetres.
double depth_tolerance_m(double z_m) {
  return z_m * z_m / (40 * 256) / 2 + 0.5e-3 + 1e-6;
}

TEST_F(Export, VdoImportsAsTheSameSequence) {
  const fs::path out = run("vdo"), imported_folder = folder() / "imported";
  ImportOmdOptions options;
  options.quiet = true;
  import_omd(out, options, imported_folder);
  const Sequence imported = open_sequence(imported_folder / "sequence");
  ASSERT_EQ(imported.frames.size(), sequence_.frames.size());
  EXPECT_EQ(imported.camera.matrix(), sequence_.camera.matrix());
  int depths = 0;
  for (std::size_t i = 0; i < imported.frames.size(); ++i) {
    const SequenceFrame &got = imported.frames[i], &expected = sequence_.frames[i];
    EXPECT_EQ(got.stamp_ns, expected.stamp_ns);
    EXPECT_EQ(cv::norm(read_rgb(imported, got), read_rgb(sequence_, expected)), 0);
    EXPECT_EQ(cv::norm(read_masks(imported, got), read_masks(sequence_, expected)), 0);
    const cv::Mat a = read_depth(imported, got), b = read_depth(sequence_, expected);
    for (int v = 0; v < a.rows; ++v)
      for (int u = 0; u < a.cols; ++u) {
        EXPECT_NEAR(a.at<float>(v, u), b.at<float>(v, u), depth_tolerance_m(b.at<float>(v, u)));
        depths += b.at<float>(v, u) > 0;
      }
    EXPECT_LT((imported.given_camera->at(i).pose.matrix() - truth_.camera[i].pose.matrix()).norm(), 1e-12);
  }
  EXPECT_GT(depths, 1000);
}

// Nearly all pixels of the room stand still but for the camera: flow carries a pixel to where the next frame
// has its point.
TEST_F(Export, VdoHasTheFlowToTheNextFrame) {
  const fs::path out = run("vdo");
  EXPECT_FALSE(fs::exists(out / "flow/000003.flo"));
  const std::string bytes = read_text(out / "flow/000000.flo");
  float tag = 0;
  std::int32_t size[2] = {};
  std::memcpy(&tag, bytes.data(), 4);
  std::memcpy(size, bytes.data() + 4, 8);
  EXPECT_EQ(tag, 202021.25F);
  ASSERT_EQ(size[0], sequence_.camera.width);
  ASSERT_EQ(size[1], sequence_.camera.height);
  ASSERT_EQ(bytes.size(), 12u + 8u * size[0] * size[1]);
  const cv::Mat depth = read_depth(sequence_, sequence_.frames[0]), ids = instances(0);
  const Pose next_from_this = truth_.camera[1].pose.inverse() * truth_.camera[0].pose;
  int right = 0, all = 0;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      if (ids.at<std::uint16_t>(v, u) != 0 || !(z > 0)) continue;
      const auto there = sequence_.camera.project(next_from_this * (z * *sequence_.camera.unproject({u, v})));
      if (!there) continue;
      float flow[2];
      std::memcpy(flow, bytes.data() + 12 + 8 * (v * size[0] + u), 8);
      ++all;
      right += ((Eigen::Vector2d(u, v) + Eigen::Vector2d(flow[0], flow[1])) - *there).norm() < 2;
    }
  EXPECT_GT(all, 5000);
  EXPECT_GT(right, 0.7 * all);
}

TEST_F(Export, VdoWithoutTruthHoldsIdentities) {
  fs::remove_all(data() / "truth");
  const fs::path out = run("vdo");
  const auto camera = table(out / "pose_gt.txt", ' '), objects = table(out / "object_pose.txt", ' ');
  ASSERT_EQ(camera.size(), 4u);
  for (const auto& row : camera)
    EXPECT_EQ(numbers(row, 1), (std::vector<double>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}));
  ASSERT_GE(objects.size(), 4u);
  for (const auto& row : objects) EXPECT_EQ(numbers(row, 2), std::vector<double>(6, 0));
}

}  // namespace
}  // namespace uniquadric
