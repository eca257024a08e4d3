#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "core/geometry/ellipsoid.h"
#include "simulator/render/box_pixels.h"
#include "simulator/render/renderer.h"
#include "simulator/scene/named_motions.h"
#include "tests/simulator/ray_cast.h"
#include "tests/simulator/simple_scene.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

// Promise of the renderer: single precision coordinates and interpolation, measured 8e-6 at most.
constexpr double kDepthTolerance = 1e-5;  // relative
// Promise of the pixel convention; half a pixel would show as 0.5.
constexpr double kMomentTolerance_px = 0.05;

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() &&
         std::equal(a.datastart, a.dataend, b.datastart, b.dataend);
}

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

TEST(Renderer, VisibleFractionOfAKnownOcclusion) {
  // A screen that ends at x = 0 hides the left half of a square behind it; columns 0..49 of 100 are its.
  const Eigen::Vector3d screen_axes(1, 1, 0.01), square_axes(0.2, 0.1, 0.01);
  Scene scene;
  scene.camera = {100, 80, 100, 100, 49.5, 39.5, {}};
  scene.objects = {make_body(1, box_mesh(square_axes), square_axes, Motion()),
                   make_body(2, box_mesh(screen_axes), screen_axes, Motion())};
  const auto at = [](double x, double y, double z) {
    return Pose{Eigen::Quaterniond::Identity(), {x, y, z}};
  };
  Renderer renderer(scene);
  const auto frame = renderer.render({Pose(), {at(0, 0, 1.01), at(-1, 0, 0.51)}});
  // front face at z = 1 m: 40 x 20 px, half of it hidden
  EXPECT_EQ(frame.objects[0].silhouette_px, 40 * 20);
  EXPECT_EQ(frame.objects[0].visible_px, 20 * 20);
  EXPECT_EQ(frame.objects[0].visible_fraction(), 0.5);
  EXPECT_FALSE(frame.objects[0].touches_border);
  EXPECT_EQ(frame.objects[1].silhouette_px, 50 * 80);
  EXPECT_EQ(frame.objects[1].visible_fraction(), 1);
  EXPECT_TRUE(frame.objects[1].touches_border);
}

TEST(Renderer, OutsideTheImageCountsAsNeitherSeenNorHidden) {
  const Eigen::Vector3d axes(0.2, 0.1, 0.01);
  Scene scene;
  scene.camera = {100, 80, 100, 100, 49.5, 39.5, {}};
  scene.objects = {make_body(1, box_mesh(axes), axes, Motion())};
  Renderer renderer(scene);
  const auto view = [&](double x, double z) {
    return renderer.render({Pose(), {{Eigen::Quaterniond::Identity(), {x, 0, z}}}}).objects[0];
  };
  const ObjectView cut = view(0.5, 1.01);  // its middle stands on the right border
  EXPECT_EQ(cut.visible_fraction(), 1);
  EXPECT_TRUE(cut.touches_border);
  EXPECT_NEAR(static_cast<double>(cut.silhouette_px), 20 * 20, 20);  // a column more: the side face shows
  const ObjectView behind = view(0, -1);
  EXPECT_EQ(behind.silhouette_px, 0);
  EXPECT_EQ(behind.visible_fraction(), 0);
  EXPECT_FALSE(behind.touches_border);
}

// The box around a body may not lose a pixel of it, wherever it stands.
TEST(PixelsOfBox, HoldEveryPixelOfTheBody) {
  Scene scene = two_boxes();
  const Eigen::Vector3d axes(0.3, 0.2, 0.1);
  const Eigen::AlignedBox3f box(-axes.cast<float>(), axes.cast<float>());
  scene.world.clear();
  scene.objects = {make_body(1, box_mesh(axes), axes, Motion())};
  Renderer renderer(scene);
  int cut = 0, tight = 0, whole = 0, empty = 0;
  for (int i = 0; i < 150; ++i) {
    const Pose pose{exp_so3(Eigen::Vector3d(0.1 * i, 0.07 * i, 0.05 * i)),
                    {0.8 * std::sin(1.3 * i), 0.5 * std::sin(2.1 * i), 1.3 + 1.25 * std::sin(0.7 * i)}};
    const RenderedFrame& frame = renderer.render({Pose(), {pose}});
    const cv::Rect part = pixels_of_box(box, pose, scene.camera, 0.01);
    const std::int64_t all = cv::countNonZero(frame.ids);
    EXPECT_EQ(frame.objects[0].silhouette_px, all) << i;
    EXPECT_EQ(part.empty() ? 0 : cv::countNonZero(frame.ids(part)), all) << i;
    empty += part.empty();
    whole += part.size() == frame.ids.size();
    cut += frame.objects[0].touches_border;
    if (all == 0 || frame.objects[0].touches_border) continue;
    const cv::Rect seen = cv::boundingRect(frame.ids > 0);  // a box's corners are its outermost points
    EXPECT_LE(part.width, seen.width + 6) << i;
    EXPECT_LE(part.height, seen.height + 6) << i;
    ++tight;
  }
  EXPECT_GT(tight, 10);
  EXPECT_GT(cut, 5);
  EXPECT_GT(whole, 2);
  EXPECT_GT(empty, 2);
}

TEST(Renderer, SilhouettesOfMoreThanEightObjects) {
  const Eigen::Vector3d axes(0.04, 0.04, 0.01);
  Scene scene;
  scene.camera = {100, 80, 100, 100, 49.5, 39.5, {}};
  ScenePoses poses;
  for (int i = 0; i < 9; ++i) {  // all behind one another, the last one nearest
    scene.objects.push_back(make_body(65535 - i, box_mesh(axes), axes, Motion()));
    poses.world_from_object.push_back({Eigen::Quaterniond::Identity(), {0, 0, 2.01 - 0.1 * i}});
  }
  const auto frame = Renderer(scene).render(poses);
  for (int i = 0; i < 9; ++i) {
    const double side_px = 8 / (2 - 0.1 * i);
    EXPECT_NEAR(std::sqrt(static_cast<double>(frame.objects[i].silhouette_px)), side_px, 1) << i;
    EXPECT_EQ(frame.objects[i].id, 65535 - i);
    EXPECT_EQ(frame.objects[i].visible_fraction() > 0.99, i == 8) << i;
  }
}

TEST(Renderer, ColorFollowsTheLightAndTheTexture) {
  // A face turned to the sun shows its texture's colour, one turned away the ambient share of it.
  const Eigen::Vector3d axes(0.2, 0.2, 0.2);
  Scene scene;
  scene.camera = {100, 80, 100, 100, 49.5, 39.5, {}};
  scene.ambient = 0.25;
  Mesh mesh = box_mesh(axes);
  mesh.texture = cv::Mat(4, 4, CV_8UC3, cv::Scalar(40, 80, 200));
  mesh.color = {1.0f, 0.5f, 1.0f};
  scene.objects = {make_body(1, mesh, axes, Motion())};
  const ScenePoses poses = {Pose(), {{Eigen::Quaterniond::Identity(), {0, 0, 1.2}}}};
  const auto center = [&](const Eigen::Vector3d& sun) {
    scene.sun_direction = sun;
    return Renderer(scene).render(poses).rgba.at<cv::Vec4b>(40, 50);
  };
  EXPECT_EQ(center({0, 0, 1}), cv::Vec4b(200, 40, 40, 255));
  EXPECT_EQ(center({0, 0, -1}), cv::Vec4b(50, 10, 10, 255));
  EXPECT_EQ(center({0, 1, 1})[0], std::lround(200 * (0.25 + 0.75 * std::sqrt(0.5))));
}

TEST(Renderer, TextureStandsUpright) {
  // uv (0, 0) is the texture's first pixel: the front face's corners show the texture's four quarters.
  const Eigen::Vector3d axes(0.2, 0.2, 0.01);
  Scene scene;
  scene.camera = {100, 80, 100, 100, 49.5, 39.5, {}};
  scene.ambient = 1;
  Mesh mesh = box_mesh(axes);
  mesh.texture = cv::Mat::zeros(8, 8, CV_8UC3);
  mesh.texture(cv::Rect(0, 0, 4, 4)).setTo(cv::Scalar(255, 0, 0));
  mesh.texture(cv::Rect(4, 0, 4, 4)).setTo(cv::Scalar(0, 255, 0));
  mesh.texture(cv::Rect(0, 4, 4, 4)).setTo(cv::Scalar(0, 0, 255));
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i)
    mesh.uvs[i] = mesh.positions[i].head<2>() / 0.4f + Eigen::Vector2f(0.5f, 0.5f);
  scene.objects = {make_body(1, mesh, axes, Motion())};
  const cv::Mat rgba =
      Renderer(scene).render({Pose(), {{Eigen::Quaterniond::Identity(), {0, 0, 1.01}}}}).rgba;
  EXPECT_EQ(rgba.at<cv::Vec4b>(35, 45), cv::Vec4b(0, 0, 255, 255));
  EXPECT_EQ(rgba.at<cv::Vec4b>(35, 54), cv::Vec4b(0, 255, 0, 255));
  EXPECT_EQ(rgba.at<cv::Vec4b>(44, 45), cv::Vec4b(255, 0, 0, 255));
  EXPECT_EQ(rgba.at<cv::Vec4b>(44, 54), cv::Vec4b(0, 0, 0, 255));
}

// A white square of 40 px before black; unshifted, its edges run between pixels.
Scene white_square() {
  const Eigen::Vector3d axes(0.2, 0.2, 0.01);
  Scene scene;
  scene.camera = {100, 80, 100, 100, 49.5, 39.5, {}};
  scene.ambient = 1;
  Mesh mesh = box_mesh(axes);
  mesh.texture = cv::Mat();
  scene.objects = {make_body(1, mesh, axes, Motion())};
  return scene;
}

ScenePoses shifted(double x_px, double y_px) {
  return {Pose(), {{Eigen::Quaterniond::Identity(), {x_px / 100, y_px / 100, 1.01}}}};
}

TEST(Renderer, EdgesShowTheShareOfThePixelThatTheyCover) {
  Renderer renderer(white_square());
  constexpr int kRounding = 1;  // grey level
  int cases = 0;
  for (const double shift_px : {0.25, 0.5, 0.75}) {  // four samples stand in four columns and four rows
    const cv::Mat along = renderer.render(shifted(shift_px, 0)).rgba.clone();
    EXPECT_NEAR(along.at<cv::Vec4b>(40, 30)[0], 255 * (1 - shift_px), kRounding);
    EXPECT_NEAR(along.at<cv::Vec4b>(40, 70)[1], 255 * shift_px, kRounding);
    const cv::Mat across = renderer.render(shifted(0, shift_px)).rgba;
    EXPECT_NEAR(across.at<cv::Vec4b>(20, 50)[2], 255 * (1 - shift_px), kRounding);
    EXPECT_NEAR(across.at<cv::Vec4b>(60, 50)[0], 255 * shift_px, kRounding);
    EXPECT_EQ(across.at<cv::Vec4b>(40, 50)[0], 255);
    ++cases;
  }
  EXPECT_EQ(cases, 3);
}

TEST(Renderer, SamplesChangeColorAtEdgesAlone) {
  Scene scene = two_boxes();
  scene.imaging.samples = 1;
  const RenderedFrame one = Renderer(scene).render(poses_at(scene, 0.4));
  scene.imaging.samples = 4;
  const RenderedFrame four = Renderer(scene).render(poses_at(scene, 0.4));
  EXPECT_TRUE(same(one.ids, four.ids));
  EXPECT_TRUE(same(one.depth_m, four.depth_m));
  int edge_pixels = 0;
  for (int v = 1; v + 1 < one.ids.rows; ++v)
    for (int u = 1; u + 1 < one.ids.cols; ++u) {
      const bool differs = one.rgba.at<cv::Vec4b>(v, u) != four.rgba.at<cv::Vec4b>(v, u);
      if (differs) ++edge_pixels;
    }
  EXPECT_GT(edge_pixels, 100);
  EXPECT_LT(edge_pixels, 1000);  // of 160 x 120: outlines, and edges between faces
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(one.objects[i].silhouette_px, four.objects[i].silhouette_px);
}

TEST(Renderer, ExposureIsTheMeanOverTheTimeTheShutterIsOpen) {
  // An edge that sweeps w pixels leaves a ramp w pixels wide; ids are those of its middle.
  Scene scene = white_square();
  scene.imaging.samples = 1;
  scene.imaging.exposure_s = 0.01;
  Renderer renderer(scene);
  constexpr int kSteps = 40, kWidth_px = 10;
  std::vector<ColorStep> exposure;
  for (int i = 0; i < kSteps; ++i)
    exposure.push_back({shifted(kWidth_px * ((i + 0.5) / kSteps - 0.5), 0), 0, scene.camera.height});
  const RenderedFrame& frame = renderer.render(shifted(0, 0), exposure);
  int ramp = 0;
  for (int u = 20; u < 45; ++u) {  // the edge's middle stands between columns 29 and 30
    const double share = std::clamp((u + 0.5 - (30 - kWidth_px / 2)) / kWidth_px, 0.0, 1.0);
    EXPECT_NEAR(frame.rgba.at<cv::Vec4b>(40, u)[0], 255 * share, 255.0 / kSteps) << u;
    ramp += share > 0 && share < 1;
    EXPECT_EQ(frame.ids.at<std::uint16_t>(40, u), u >= 30 ? 1 : 0);
  }
  EXPECT_EQ(ramp, kWidth_px);
}

// Where the second of two_boxes() is: a clock, at 1.2 m/s from -0.6 m on.
double time_of(const ColorStep& step) {
  return (step.poses.world_from_object.at(1).translation.x() + 0.6) / 1.2;
}

TEST(ColorSteps, AreTheMiddlesOfTheExposureAboutTheStamp) {
  Scene scene = two_boxes();
  EXPECT_TRUE(color_steps(scene, 0.5).empty());
  scene.imaging.exposure_s = 0.03;
  scene.imaging.exposure_steps = 3;
  const auto steps = color_steps(scene, 0.5);
  ASSERT_EQ(steps.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(time_of(steps[i]), 0.49 + 0.01 * i, 1e-12);
    EXPECT_EQ(steps[i].first_row, 0);
    EXPECT_EQ(steps[i].rows, scene.camera.height);
  }
}

TEST(ColorSteps, RollDownTheRowsAboutTheStamp) {
  Scene scene = two_boxes();
  scene.imaging.rolling_shutter_s = 0.03;
  scene.imaging.rolling_shutter_bands = 7;  // does not divide the 120 rows
  scene.imaging.exposure_s = 0.01;
  scene.imaging.exposure_steps = 2;
  const auto steps = color_steps(scene, 0.5);
  ASSERT_EQ(steps.size(), 14u);
  int next_row = 0;
  for (std::size_t i = 0; i < steps.size(); i += 2) {
    EXPECT_EQ(steps[i].first_row, next_row);
    EXPECT_EQ(steps[i + 1].first_row, next_row);
    EXPECT_EQ(steps[i + 1].rows, steps[i].rows);
    const double middle_row = next_row + steps[i].rows / 2.0;
    EXPECT_NEAR((time_of(steps[i]) + time_of(steps[i + 1])) / 2, 0.5 + 0.03 * (middle_row / 120 - 0.5),
                1e-12);
    EXPECT_NEAR(time_of(steps[i + 1]) - time_of(steps[i]), 0.005, 1e-12);
    next_row += steps[i].rows;
  }
  EXPECT_EQ(next_row, 120);
}

// A motion along x at a constant speed [m/s] that passes shifted(0, 0) at 1 s.
Motion across(double speed_mps) {
  return line_motion({Eigen::Quaterniond::Identity(), {-speed_mps, 0, 1.01}}, {speed_mps, 0, 0});
}

TEST(Renderer, RollingShutterLeansAMovingEdgeByItsSpeedTimesTheRowsDelay) {
  constexpr double kSpeed_pxps = 400, kReadout_s = 0.02;  // 8 px from the first row to the last
  Scene scene = white_square();
  scene.objects[0].motion = across(kSpeed_pxps / 100);
  const int height = scene.camera.height;
  scene.imaging.rolling_shutter_s = kReadout_s;
  scene.imaging.rolling_shutter_bands = height;  // each row at its own time
  Renderer renderer(scene);
  const RenderedFrame& frame = renderer.render(poses_at(scene, 1), color_steps(scene, 1));
  constexpr double kSample_px = 0.25;  // an edge is met by four samples a pixel
  int rows = 0;
  for (int v = 22; v < 58; ++v, ++rows) {
    double white_px = 0;  // left of the square's middle, so that the left edge alone counts
    for (int u = 10; u < 50; ++u) white_px += frame.rgba.at<cv::Vec4b>(v, u)[0] / 255.0;
    const double delay_s = kReadout_s * ((v + 0.5) / height - 0.5);
    EXPECT_NEAR(50 - white_px, 30 + kSpeed_pxps * delay_s, kSample_px) << "row " << v;
    for (const int u : {29, 30}) {  // ids and depth stay those of the stamp
      EXPECT_EQ(frame.ids.at<std::uint16_t>(v, u), u < 30 ? 0 : 1);
      EXPECT_EQ(frame.depth_m.at<float>(v, u) > 0, u >= 30);
    }
  }
  EXPECT_EQ(rows, 36);
}

TEST(Renderer, RollingShutterOfAWorldAtRestChangesNothing) {
  for (const int samples : {1, 4}) {
    Scene scene = white_square();
    scene.objects[0].motion = across(0);
    scene.imaging.samples = samples;
    const RenderedFrame at_once = Renderer(scene).render(poses_at(scene, 1));
    scene.imaging.rolling_shutter_s = 0.02;
    scene.imaging.rolling_shutter_bands = 9;
    const RenderedFrame rolling = Renderer(scene).render(poses_at(scene, 1), color_steps(scene, 1));
    EXPECT_TRUE(same(at_once.rgba, rolling.rgba)) << samples;
    EXPECT_TRUE(same(at_once.ids, rolling.ids)) << samples;
  }
}

TEST(Renderer, GainBrightensUpToWhite) {
  Scene scene = white_square();
  scene.objects[0].meshes[0].color = {0.2f, 0.4f, 0.8f};
  scene.sky_color = {0.1, 0.6, 0};
  scene.imaging.gain = 2;
  const cv::Mat rgba = Renderer(scene).render(shifted(0, 0)).rgba;
  EXPECT_EQ(rgba.at<cv::Vec4b>(40, 50), cv::Vec4b(102, 204, 255, 255));
  EXPECT_EQ(rgba.at<cv::Vec4b>(5, 5)[0], 51);
  EXPECT_EQ(rgba.at<cv::Vec4b>(5, 5)[1], 255);
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
  std::unique_ptr<Renderer> egl;
  try {
    egl = std::make_unique<Renderer>(scene, GlLibrary::egl);
  } catch (const std::runtime_error& e) {
    GTEST_SKIP() << e.what();
  }
  if (!egl->device().starts_with("llvmpipe")) GTEST_SKIP() << "EGL draws with " << egl->device();
  Renderer osmesa(scene);
  EXPECT_EQ(osmesa.device(), egl->device());
  for (const double time_s : {0.0, 0.4, 0.9}) {
    const ScenePoses poses = poses_at(scene, time_s);
    const RenderedFrame &a = osmesa.render(poses), &b = egl->render(poses);
    EXPECT_TRUE(same(a.rgba, b.rgba)) << time_s;
    EXPECT_TRUE(same(a.ids, b.ids)) << time_s;
    EXPECT_TRUE(same(a.depth_m, b.depth_m)) << time_s;
    EXPECT_EQ(a.objects[1].silhouette_px, b.objects[1].silhouette_px);
  }
}

TEST(Renderer, RefusesWhatItCannotDraw) {
  Scene scene = two_boxes();
  scene.camera.distortion[0] = 0.1;
  EXPECT_NE(input_error([&] { check_can_render(scene); }).find("camera.distortion"), std::string::npos);
  scene = two_boxes();
  scene.objects[1].id = 7;
  EXPECT_NE(input_error([&] { check_can_render(scene); }).find("body300: id 7"), std::string::npos);
  scene.objects[1].id = 65536;
  EXPECT_NE(input_error([&] { check_can_render(scene); }).find("65536"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
