// Cameras with lens distortion.
#include "simulator/render/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "simulator/render/renderer.h"
#include "tests/simulator/ray_cast.h"
#include "tests/simulator/same_image.h"
#include "tests/simulator/simple_scene.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

using Distortion = std::array<double, 5>;
constexpr Distortion kBarrel = {-0.28, 0.07, 0.0012, -0.0008, 0.01},
                     kPincushion = {0.2, -0.1, -0.0015, 0.001, 0.05};

Pose at(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), {x, y, z}};
}

Camera distorted(const Distortion& distortion) {
  return {320, 240, 180, 184, 157.1, 121.3, distortion};
}

TEST(Lens, DepthOfAPlaneIsThatOfTheRayOfEachPixel) {
  const Eigen::Vector3d axes(30, 30, 0.1);
  const Pose pose{exp_so3({0.3, -0.4, 0.2}), {0.1, 0.2, 4}};
  const Eigen::Vector3d normal = pose.rotation * Eigen::Vector3d::UnitZ();
  const double offset_m = normal.dot(pose.translation) - axes.z();  // of the face before the camera
  for (const Distortion& distortion : {kBarrel, kPincushion}) {
    Scene scene;
    scene.camera = distorted(distortion);
    scene.world = {make_body(0, box_mesh(axes), axes, fixed(pose))};
    Renderer renderer(scene);
    const cv::Mat depth_m = renderer.render({}).depth_m.clone();
    ASSERT_EQ(depth_m.size(), cv::Size(320, 240));
    for (int v = 0; v < depth_m.rows; ++v)
      for (int u = 0; u < depth_m.cols; ++u) {
        const double z_m = offset_m / normal.dot(*scene.camera.unproject({u, v}));
        ASSERT_NEAR(depth_m.at<float>(v, u) / z_m, 1, 2e-5) << u << ", " << v;
      }
    EXPECT_TRUE(same(depth_m, renderer.depth_m({})));
  }
}

// Whether the pixel and its neighbours are of one surface: there ids and depth are the ray's.
bool is_inner(const Scene& scene, const ScenePoses& poses, int u, int v) {
  const auto middle = cast_ray(scene, poses, u, v);
  for (const int dv : {-1, 1})
    for (const int du : {-1, 1}) {
      const auto other = cast_ray(scene, poses, u + du, v + dv);
      if (!middle || !other || other->id != middle->id) return false;
    }
  return middle->margin > 0.06;  // of a face, whose edges may be creases
}

TEST(Lens, DepthAndIdsAgreeWithARayCast) {
  Scene scene = two_boxes();
  for (const Distortion& distortion : {kBarrel, kPincushion}) {
    scene.camera.distortion = distortion;
    Renderer renderer(scene);
    const ScenePoses poses = poses_at(scene, 0.4);
    const RenderedFrame& frame = renderer.render(poses);
    int compared = 0;
    for (int v = 2; v + 2 < frame.ids.rows; v += 3)
      for (int u = 2; u + 2 < frame.ids.cols; u += 3) {
        if (!is_inner(scene, poses, u, v)) continue;
        const auto hit = cast_ray(scene, poses, u, v);
        ++compared;
        ASSERT_EQ(hit->id, frame.ids.at<std::uint16_t>(v, u)) << u << ", " << v;
        ASSERT_NEAR(frame.depth_m.at<float>(v, u) / hit->z_m, 1, 1e-4) << u << ", " << v;
      }
    EXPECT_GT(compared, 1500);
  }
}

TEST(Lens, NoDepthStandsBetweenTwoSurfaces) {
  Scene scene = two_boxes();
  const Eigen::Vector3d axes(0.3, 0.3, 0.01), wall_axes(9, 9, 0.01);
  scene.camera.distortion = kBarrel;
  scene.objects.clear();  // both are the world's, with id 0
  scene.world = {make_body(0, box_mesh(axes), axes, fixed(at(0.1, 0, 1.01))),
                 make_body(0, box_mesh(wall_axes), wall_axes, fixed(at(0, 0, 3.01)))};
  const cv::Mat depth_m = Renderer(scene).render({}).depth_m;
  int near = 0;
  for (int v = 0; v < depth_m.rows; ++v)
    for (int u = 0; u < depth_m.cols; ++u) {
      const float z_m = depth_m.at<float>(v, u);
      near += z_m < 2;
      EXPECT_TRUE(std::abs(z_m - 3) < 1e-3 || z_m < 1.021) << z_m << " at " << u << ", " << v;
    }
  EXPECT_GT(near, 5000);
}

Eigen::Vector2d centroid(const cv::Mat& ids_or_grey) {
  const cv::Moments m = cv::moments(ids_or_grey);
  return {m.m10 / m.m00, m.m01 / m.m00};
}

// Each pixel's share that a sphere covers, by 8 x 8 rays a pixel in closed form.
cv::Mat covered_shares(const Camera& camera, const Eigen::Vector3d& center_m, double radius_m) {
  constexpr int kRays = 8;
  cv::Mat shares = cv::Mat::zeros(camera.height, camera.width, CV_32FC1);
  const cv::Point middle(static_cast<int>(camera.project(center_m)->x()),
                         static_cast<int>(camera.project(center_m)->y()));
  const cv::Rect near = cv::Rect(middle.x - 25, middle.y - 25, 50, 50) & cv::Rect({0, 0}, shares.size());
  for (int v = kRays * near.y; v < kRays * near.br().y; ++v)
    for (int u = kRays * near.x; u < kRays * near.br().x; ++u) {
      const auto ray = camera.unproject({(u + 0.5) / kRays - 0.5, (v + 0.5) / kRays - 0.5});
      if (ray && center_m.cross(ray->normalized()).norm() < radius_m)
        shares.at<float>(v / kRays, u / kRays) += 1.0f / (kRays * kRays);
    }
  return shares;
}

// White before black, so that grey levels are shares of pixels.
Scene white_ball(const Distortion& distortion, double radius_m) {
  Scene scene;
  scene.camera = distorted(distortion);
  scene.ambient = 1;
  scene.sky_color = Eigen::Vector3d::Zero();
  scene.objects = {make_body(1, sphere_mesh(radius_m, 40), Eigen::Vector3d::Constant(radius_m), Motion())};
  return scene;
}

TEST(Lens, ObjectsStandWhereTheCameraProjectsThem) {
  constexpr double kRadius_m = 0.2;
  for (const Distortion& distortion : {kBarrel, kPincushion}) {
    const Scene scene = white_ball(distortion, kRadius_m);
    Renderer renderer(scene);
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(17, 16), {302, 17}, {18, 223}, {301, 222}, {160, 120}}) {
      const Eigen::Vector3d center_m = 5 * *scene.camera.unproject(pixel);
      const RenderedFrame& frame = renderer.render({Pose(), {{Eigen::Quaterniond::Identity(), center_m}}});
      const cv::Mat shares = covered_shares(scene.camera, center_m, kRadius_m);
      cv::Mat grey;
      cv::extractChannel(frame.rgba, grey, 0);
      EXPECT_LT((centroid(frame.ids) - centroid(shares)).norm(), 0.25) << pixel.transpose();
      EXPECT_LT((centroid(grey) - centroid(shares)).norm(), 0.08) << pixel.transpose();
      EXPECT_NEAR(cv::sum(grey)[0] / 255 / cv::sum(shares)[0], 1, 0.02) << pixel.transpose();
      const ObjectView& view = frame.objects[0];
      EXPECT_EQ(view.visible_px, cv::countNonZero(frame.ids));
      EXPECT_EQ(view.silhouette_px, view.visible_px);
      EXPECT_FALSE(view.touches_border);
    }
  }
}

TEST(Lens, ASmallFarSphereStandsAtItsCentresProjection) {
  constexpr double kRadius_m = 0.06, kAway_m = 5;  // larger ones are seen 0.2 px further out
  for (const Distortion& distortion : {kBarrel, kPincushion}) {
    const Scene scene = white_ball(distortion, kRadius_m);
    Renderer renderer(scene);
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(9.3, 8.1), {310, 9.6}, {9.2, 230}, {309.4, 231}}) {
      const Eigen::Vector3d center_m = kAway_m * *scene.camera.unproject(pixel);
      const auto place = scene.camera.project(center_m);
      const RenderedFrame& frame = renderer.render({Pose(), {{Eigen::Quaterniond::Identity(), center_m}}});
      ASSERT_TRUE(place);
      EXPECT_GT(frame.objects[0].visible_px, 10);
      EXPECT_LT((centroid(frame.ids) - *place).norm(), 0.3) << pixel.transpose();
    }
  }
}

TEST(Lens, BorderIsThatOfTheDistortedImage) {
  constexpr double kRadius_m = 0.2;
  Scene scene;
  scene.camera = distorted(kBarrel);
  scene.objects = {make_body(1, sphere_mesh(kRadius_m, 40), Eigen::Vector3d::Constant(kRadius_m), Motion())};
  Renderer renderer(scene);
  const auto view = [&](const Eigen::Vector2d& pixel) {
    const Eigen::Vector3d center_m = 5 * *scene.camera.unproject(pixel);
    return renderer.render({Pose(), {at(center_m.x(), center_m.y(), center_m.z())}}).objects[0];
  };
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(160, 0), {160, 239}, {0, 120}, {319, 120}, {0, 0}}) {
    EXPECT_TRUE(view(pixel).touches_border) << pixel.transpose();
    EXPECT_GT(view(pixel).silhouette_px, 5) << pixel.transpose();
  }
  // the ideal image, whose sides are bent inwards here, holds this one, the camera's does not
  EXPECT_EQ(view({160, -20}).silhouette_px, 0);
  EXPECT_FALSE(view({160, -20}).touches_border);
}

TEST(Lens, CountsMoreThanEightObjects) {
  const Eigen::Vector3d axes(0.04, 0.04, 0.01);
  Scene scene;
  scene.camera = distorted(kPincushion);
  ScenePoses poses;
  for (int i = 0; i < 10; ++i) {
    scene.objects.push_back(make_body(i + 1, box_mesh(axes), axes, Motion()));
    poses.world_from_object.push_back(at(0.1 * (i - 4.5), 0.03 * i, 1));
  }
  Renderer renderer(scene);
  for (const ObjectView& view : renderer.render(poses).objects) {
    EXPECT_GT(view.visible_px, 25) << view.id;
    EXPECT_EQ(view.silhouette_px, view.visible_px) << view.id;
  }
}

TEST(Lens, ColourIsThatOfTheWorldWithoutALens) {
  Scene scene = two_boxes();
  const ScenePoses poses = poses_at(scene, 0.4);
  const cv::Mat plain = Renderer(scene).render(poses).rgba.clone();
  scene.camera.distortion = {1e-7, 0, 0, 0, 0};  // moves no pixel, but takes the other way
  const cv::Mat seen = Renderer(scene).render(poses).rgba.clone();
  cv::Mat difference;
  cv::absdiff(plain, seen, difference);
  const cv::Scalar mean = cv::mean(difference);
  for (int k = 0; k < 3; ++k) EXPECT_LT(mean[k], 3) << k;  // checks' edges, smoothed in another way
  EXPECT_LT(cv::norm(cv::mean(plain) - cv::mean(seen)), 0.5);
}

TEST(Lens, RollingShutterOfAWorldAtRestChangesNothing) {
  Scene scene = two_boxes();
  scene.objects[1].motion = fixed(scene.objects[1].motion.at(0.4));
  for (const Distortion& distortion : {kBarrel, kPincushion}) {
    scene.camera.distortion = distortion;
    scene.imaging.rolling_shutter_s = scene.imaging.exposure_s = 0;
    const RenderedFrame at_once = Renderer(scene).render(poses_at(scene, 0.4));
    scene.imaging.rolling_shutter_s = 0.02;
    scene.imaging.exposure_s = 0.005;
    const RenderedFrame rolling = Renderer(scene).render(poses_at(scene, 0.4), color_steps(scene, 0.4));
    EXPECT_TRUE(same(at_once.ids, rolling.ids));
    cv::Mat difference;  // of more and smaller triangles
    cv::absdiff(at_once.rgba, rolling.rgba, difference);
    EXPECT_LT(cv::mean(difference)[0], 1e-2);
    EXPECT_LT(cv::norm(at_once.depth_m, rolling.depth_m, cv::NORM_INF), 1e-4);
  }
}

TEST(Lens, ReadBackIsWhatRenderGives) {
  Scene scene = two_boxes();
  scene.camera.distortion = kBarrel;
  Renderer renderer(scene);
  const ScenePoses poses = poses_at(scene, 0.4);
  const RenderedFrame frame = renderer.render(poses);
  cv::Mat rgba, ids, depth_m;
  renderer.draw(poses);
  renderer.read_back(rgba, ids, depth_m);
  EXPECT_TRUE(same(frame.rgba, rgba));
  EXPECT_TRUE(same(frame.ids, ids));
  EXPECT_TRUE(same(frame.depth_m, depth_m));
}

TEST(Lens, IdealCameraSeesEveryPixelWithTwiceTheFocalLength) {
  for (const Distortion& distortion : {kBarrel, kPincushion}) {
    const Camera camera = distorted(distortion);
    const Lens lens = make_lens(camera);
    EXPECT_FALSE(lens.ideal.has_distortion());
    EXPECT_EQ(lens.ideal.fx, 2 * camera.fx);
    EXPECT_EQ(lens.ideal.fy, 2 * camera.fy);
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u) {
        const cv::Point2f place = lens.places.at<cv::Point2f>(v, u);
        const cv::Rect2f inner(2, 2, static_cast<float>(lens.ideal.width - 5),
                               static_cast<float>(lens.ideal.height - 5));
        ASSERT_TRUE(inner.contains(place)) << place;
        const auto ray = lens.ideal.unproject({place.x, place.y});
        ASSERT_LT((*camera.project(*ray) - Eigen::Vector2d(u, v)).norm(), 1e-3);
      }
  }
}

TEST(Lens, RefusesWhatNoPlaneImageHolds) {
  Scene scene = two_boxes();
  const auto fault = [&](const Camera& camera) {
    scene.camera = camera;
    return input_error([&] { check_can_render(scene); });
  };
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos && text.find("camera.calibration.distortion") != text.npos &&
           text.find('\n') == text.npos;
  };
  const std::string folded = fault({320, 240, 180, 184, 157.1, 121.3, {-0.5, 0, 0, 0, 0}});
  EXPECT_TRUE(has(folded, "has no ray")) << folded;
  const std::string wide = fault({320, 240, 12, 12, 157.1, 121.3, {1e-5, 0, 0, 0, 0}});
  EXPECT_TRUE(has(wide, "degrees off the optical axis")) << wide;
  const std::string large = fault({4000, 3000, 4000, 4000, 1999.5, 1499.5, {0.01, 0, 0, 0, 0}});
  EXPECT_TRUE(has(large, "at most 16 Mpx")) << large;
  scene.camera = distorted(kBarrel);
  EXPECT_NO_THROW(check_can_render(scene));
}

}  // namespace
}  // namespace uniquadric
