#include "core/geometry/camera.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "core/base/random.h"

namespace uniquadric {
namespace {

Camera distorted_camera() {
  Camera camera;
  camera.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};  // of a real structured-light camera
  return camera;
}

TEST(Camera, DistortionEqualsOpenCv) {
  const Camera camera = distorted_camera();
  cv::Matx33d K(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  RandomStream random(1, "points");
  int cases = 0;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d p(random.uniform(-0.5, 0.5), random.uniform(-0.4, 0.4), random.uniform(0.9, 2));
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, cv::Vec3d(), cv::Vec3d(), K,
                      cv::Mat(1, 5, CV_64F, const_cast<double*>(camera.distortion.data())), pixels);
    const auto pixel = camera.project(p);
    ASSERT_TRUE(pixel.has_value());
    EXPECT_NEAR(pixel->x(), pixels[0].x, 1e-9);  // px, rounding of two formulas
    EXPECT_NEAR(pixel->y(), pixels[0].y, 1e-9);
    ++cases;
  }
  EXPECT_EQ(cases, 100);
}

TEST(Camera, UnprojectInvertsProject) {
  const Camera camera = distorted_camera();
  for (int u = 0; u < camera.width; u += 80)
    for (int v = 0; v < camera.height; v += 60) {
      const auto ray = camera.unproject({u, v});
      ASSERT_TRUE(ray.has_value()) << u << ' ' << v;
      const auto pixel = camera.project(2.5 * *ray);
      ASSERT_TRUE(pixel.has_value());
      EXPECT_LT((*pixel - Eigen::Vector2d(u, v)).norm(), 1e-9);
    }
}

TEST(Camera, PointsBehindHaveNoPixelAndFoldedDistortionNoRay) {
  Camera camera;
  EXPECT_FALSE(camera.project({0, 0, -1}).has_value());
  EXPECT_FALSE(camera.project({0, 0, 0}).has_value());
  camera.distortion = {-0.5, 0, 0, 0, 0};  // r (1 - r^2 / 2) never exceeds 0.544
  EXPECT_FALSE(camera.unproject({camera.cx + 0.6 * camera.fx, camera.cy}).has_value());
}

TEST(Camera, TheImageRunsHalfAPixelPastItsOuterPixelCentres) {
  const Camera camera;
  EXPECT_TRUE(camera.contains({-0.5, -0.5}));
  EXPECT_FALSE(camera.contains({-0.51, 0}));
  EXPECT_TRUE(camera.contains({639.5, 479.5}));
  EXPECT_FALSE(camera.contains({639.51, 0}));
}

TEST(Camera, CalibrationsOfNoCameraAreTold) {
  EXPECT_TRUE(calibration_faults(Camera{}).empty());
  Camera aside, wide, narrow, folded;
  aside.cx = 5000;
  wide.fx = 20;
  narrow.fy = 525'000;
  folded.distortion = {-5, 0, 0, 0, 0};
  const auto first = [](const Camera& camera) { return calibration_faults(camera).at(0); };
  EXPECT_NE(first(aside).find("principal point"), std::string::npos);
  EXPECT_NE(first(wide).find("fx of 20 px"), std::string::npos);
  EXPECT_NE(first(narrow).find("fy of 525000 px"), std::string::npos);
  EXPECT_NE(first(folded).find("pixel (0, 0)"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
