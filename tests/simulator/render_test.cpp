#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <thread>

#include "core/geometry/ellipsoid.h"
#include "simulator/render/renderer.h"
#include "tests/simulator/ray_cast.h"
#include "tests/simulator/same_image.h"
#include "tests/simulator/simple_scene.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

// Promise of the renderer: single precision coordinates and interpolation, measured 8e-6 at most.
constexpr double kDepthTolerance = 1e-5;  // relative
// Promise of the pixel convention; half a pixel would show as 0.5.
constexpr double kMomentTolerance_px = 0.05;

bool is_flat(const cv::Mat& ids, int u, int v) {
  for (int dv = -1; dv <= 1; ++dv)
    for (int du = -1; du <= 1; ++du)
      if (ids.at<std::uint16_t>(v + dv, u + du) != ids.at<std::uint16_t>(v, u)) return false;
  return true;
}

TEST(Renderer, DepthAndIdsAgreeWithARayCast) {
  const Scene scene = two_boxes();
  Renderer renderer(scene);
  const ScenePoses poses = poses_at(scene, 0.4);
  const RenderedFrame frame = renderer.render(poses);
  int compared = 0;
  double worst = 0;
  for (int v = 1; v + 1 < frame.ids.rows; ++v)
    for (int u = 1; u + 1 < frame.ids.cols; ++u) {
      if (!is_flat(frame.ids, u, v)) continue;
      const auto hit = cast_ray(scene, poses, u, v);
      const float z_m = frame.depth_m.at<float>(v, u);
      ASSERT_TRUE(hit) << u << ", " << v;
      ASSERT_EQ(hit->id, frame.ids.at<std::uint16_t>(v, u)) << u << ", " << v;
      ++compared;
      worst = std::max(worst, std::abs(z_m - hit->z_m) / hit->z_m);
    }
  EXPECT_GT(compared, 17000);  // of 160 x 120
  EXPECT_LT(worst, kDepthTolerance);
  RecordProperty("worst_relative_depth_error_1e_9", static_cast<int>(worst * 1e9));
}

struct Moments {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

Moments mask_moments(const cv::Mat& ids, int id) {
  Moments m;
  double n = 0;
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (int v = 0; v < ids.rows; ++v)
    for (int u = 0; u < ids.cols; ++u)
      if (ids.at<std::uint16_t>(v, u) == id) {
        const Eigen::Vector2d p(u, v);
        n += 1, m.mean += p, second += p * p.transpose();
      }
  m.mean /= n;
  m.covariance = second / n - m.mean * m.mean.transpose();
  return m;
}

TEST(Renderer, SphereHasTheMomentsOfItsProjectedConic) {
  const std::vector<Eigen::Vector3d> centers_m = {
      {0, 0, 2}, {0.5, -0.3, 2.2}, {-0.61, 0.37, 1.9}, {0.33, 0.21, 1.5}};
  constexpr double kRadius_m = 0.3;
  Scene scene;
  scene.objects = {make_body(1, sphere_mesh(kRadius_m, 200), Eigen::Vector3d::Constant(kRadius_m), Motion())};
  Renderer renderer(scene);
  for (const auto& center_m : centers_m) {
    const Pose camera_from_object = {Eigen::Quaterniond::Identity(), center_m};
    const auto frame = renderer.render({Pose(), {camera_from_object}});
    const auto truth = project(scene.camera, camera_from_object, Eigen::Vector3d::Constant(kRadius_m));
    ASSERT_EQ(truth.status, ProjectionStatus::ok);
    const Moments m = mask_moments(frame.ids, 1);
    EXPECT_LT((m.mean - truth.ellipse.center).norm(), kMomentTolerance_px);
    // a filled ellipse's covariance is Sigma / 4
    const Eigen::Vector2d axes =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(4 * m.covariance).eigenvalues().cwiseSqrt();
    EXPECT_NEAR(axes[1], truth.ellipse.semi_major, kMomentTolerance_px);
    EXPECT_NEAR(axes[0], truth.ellipse.semi_minor, kMomentTolerance_px);
  }
}

TEST(Renderer, DrawsTheSameBytesInAnyThreadAndOrder) {
  const Scene scene = two_boxes();
  const auto draw = [&](std::initializer_list<double> times_s) {
    Renderer renderer(scene);
    RenderedFrame frame;
    for (const double time_s : times_s) frame = renderer.render(poses_at(scene, time_s));
    return frame;
  };
  const RenderedFrame alone = draw({0.7});
  RenderedFrame other;
  std::jthread a([&] { draw({0.1, 0.2, 0.3}); }), b([&] { other = draw({0.0, 0.9, 0.7}); });
  a.join(), b.join();
  EXPECT_TRUE(same(alone.rgba, other.rgba));
  EXPECT_TRUE(same(alone.ids, other.ids));
  EXPECT_TRUE(same(alone.depth_m, other.depth_m));
}

TEST(Renderer, EglDrawsTheBytesOfOsmesaOnLlvmpipe) {
  const Scene scene = two_boxes();
  std::unique_ptr<Renderer> egl, osmesa;
  try {
    egl = std::make_unique<Renderer>(scene, GlLibrary::egl);
    osmesa = std::make_unique<Renderer>(scene, GlLibrary::osmesa);
  } catch (const std::runtime_error& e) {
    GTEST_SKIP() << e.what();
  }
  if (!egl->device().starts_with("llvmpipe")) GTEST_SKIP() << "EGL draws with " << egl->device();
  EXPECT_EQ(osmesa->device(), egl->device());
  for (const double time_s : {0.0, 0.4, 0.9}) {
    const ScenePoses poses = poses_at(scene, time_s);
    const RenderedFrame &a = osmesa->render(poses), &b = egl->render(poses);
    EXPECT_TRUE(same(a.rgba, b.rgba)) << time_s;
    EXPECT_TRUE(same(a.ids, b.ids)) << time_s;
    EXPECT_TRUE(same(a.depth_m, b.depth_m)) << time_s;
    EXPECT_EQ(a.objects[1].silhouette_px, b.objects[1].silhouette_px);
  }
}

TEST(Renderer, RefusesWhatItCannotDraw) {
  Scene scene = two_boxes();
  scene.camera.distortion[0] = -1;  // folds the image
  EXPECT_NE(input_error([&] { check_can_render(scene); }).find("camera.calibration.distortion"),
            std::string::npos);
  scene = two_boxes();
  scene.objects[1].id = 7;
  EXPECT_NE(input_error([&] { check_can_render(scene); }).find("body300: id 7"), std::string::npos);
  scene.objects[1].id = 65536;
  EXPECT_NE(input_error([&] { check_can_render(scene); }).find("65536"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
