// What colour a pixel has: light, texture, edges, gain.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simulator/render/renderer.h"
#include "tests/simulator/same_image.h"
#include "tests/simulator/simple_scene.h"

namespace uniquadric {
namespace {

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

}  // namespace
}  // namespace uniquadric
