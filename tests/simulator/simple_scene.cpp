#include "tests/simulator/simple_scene.h"

#include <cmath>
#include <numbers>

#include "simulator/scene/curve.h"

namespace uniquadric {
namespace {

class FixedCurve : public Motion::Curve {
 public:
  explicit FixedCurve(const Pose& pose) : pose_(pose) {}
  Kinematics kinematics(double) const override { return at_rest(pose_); }

 private:
  Pose pose_;
};

class AcrossCurve : public Motion::Curve {
 public:
  Kinematics kinematics(double time_s) const override {
    const auto way = shifting({1.2, 0, 0}, {time_s, 1, 0});
    return at_rest({exp_so3(Eigen::Vector3d::Zero()), {-0.6, 0.05, 2.6}}) * way *
           at_rest({exp_so3({0.3, 0, 0.1}), Eigen::Vector3d::Zero()}) * turning({0, 0.8, 0}, {time_s, 1, 0});
  }
};

void add_corner(Mesh& mesh, const Eigen::Vector3d& position, const Eigen::Vector3d& normal, double u,
                double v) {
  mesh.positions.push_back(position.cast<float>());
  mesh.normals.push_back(normal.cast<float>());
  mesh.uvs.push_back(Eigen::Vector2d(u, v).cast<float>());
}

cv::Mat checks() {
  cv::Mat image(64, 64, CV_8UC3);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u)
      image.at<cv::Vec3b>(v, u) = (u / 8 + v / 8) % 2 ? cv::Vec3b(40, 90, 200) : cv::Vec3b(220, 200, 60);
  return image;
}

}  // namespace

Mesh sphere_mesh(double radius_m, int rings) {
  Mesh mesh;
  const int sectors = 2 * rings;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j <= sectors; ++j) {
      const double theta = std::numbers::pi * i / rings, phi = std::numbers::pi * j / rings;
      const Eigen::Vector3d n(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                              std::cos(theta));
      add_corner(mesh, radius_m * n, n, j / double(sectors), i / double(rings));
    }
  for (unsigned i = 0; i < unsigned(rings); ++i)
    for (unsigned j = 0; j < unsigned(sectors); ++j) {
      const unsigned a = i * (sectors + 1) + j, b = a + sectors + 1;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  return mesh;
}

Mesh box_mesh(const Eigen::Vector3d& semi_axes_m) {
  Mesh mesh;
  mesh.texture = checks();
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d n = side * Eigen::Vector3d::Unit(axis);
      const Eigen::Vector3d x = Eigen::Vector3d::Unit((axis + 1) % 3), y = n.cross(x);
      const auto first = static_cast<unsigned>(mesh.positions.size());
      for (const auto& [u, v] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
        add_corner(mesh, (n + u * x + v * y).cwiseProduct(semi_axes_m), n, (u + 1) / 2.0, (v + 1) / 2.0);
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  return mesh;
}

Motion fixed(const Pose& world_from_body) {
  return Motion(std::make_shared<FixedCurve>(world_from_body));
}

Body make_body(int id, const Mesh& mesh, const Eigen::Vector3d& semi_axes_m, const Motion& motion) {
  Body body;
  body.id = id;
  body.name = "body" + std::to_string(id);
  body.shape = "box";
  body.meshes = {mesh};
  body.semi_axes_m = semi_axes_m;
  body.motion = motion;
  return body;
}

Scene two_boxes() {
  const Eigen::Vector3d near_axes(0.2, 0.15, 0.1), far_axes(0.25, 0.3, 0.2), wall_axes(3, 3, 0.05);
  Scene scene;
  scene.name = "two_boxes";
  scene.hash = "0123456789abcdef";
  scene.frames = 12;
  scene.rate_hz = 10;
  scene.camera = {160, 120, 140, 142, 78.3, 60.9, {}};
  scene.sun_direction = {0.3, 0.4, 0.8};
  scene.camera_motion = fixed(Pose());
  scene.world = {make_body(0, box_mesh(wall_axes), wall_axes, fixed({exp_so3({0.1, 0.2, 0}), {0, 0, 4}}))};
  scene.objects = {
      make_body(7, box_mesh(near_axes), near_axes, fixed({exp_so3({0.4, 0.5, 0.2}), {0.1, 0, 1.6}})),
      make_body(300, box_mesh(far_axes), far_axes, Motion(std::make_shared<AcrossCurve>()))};
  return scene;
}

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

}  // namespace uniquadric
