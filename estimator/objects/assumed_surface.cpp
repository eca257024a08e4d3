#include "estimator/objects/assumed_surface.h"

#include <array>
#include <cmath>

#include "core/geometry/sphere_direction.h"
#include "estimator/base/point_tree.h"
#include "estimator/shape/to_matrix.h"

namespace uniquadric {
namespace {

constexpr int kDirections = 600;  // on the whole surface: the model's voxels are about as many
constexpr double kNear = 0.25;    // of the mean radius, within which a seen point stands for an assumed one
constexpr int kNeighbours = 6;    // among which one that faces the same way is looked for
constexpr double kSameWay = 0.5;  // cosine of their normals

double near_m(const Eigen::Vector3d& semi_axes_m) {
  return kNear * std::cbrt(semi_axes_m.prod());
}

}  // namespace

bool is_known_all_around(const Shape& shape) {
  const double most_m = near_m(shape.semi_axes_m) / 2;
  return (shape.variances.head<3>().array() < most_m * most_m).all();
}

void assume_unseen(SurfaceModel& model) {
  const PointTree tree(model.points);
  const double reach_m = near_m(model.shape->semi_axes_m);
  std::vector<Eigen::Vector3d> points, normals;
  std::array<PointTree::Neighbour, kNeighbours> places;
  for (int k = 0; k < kDirections; ++k) {
    const Eigen::Vector3d out = sphere_direction(k, kDirections).cwiseProduct(model.shape->semi_axes_m);
    const Eigen::Vector3d on = out / gauge(*model.shape, out);
    const Eigen::Vector3d point = *model.body_from_object * on,
                          normal = model.body_from_object->rotation * normal_at(*model.shape, on);
    bool seen = false;
    for (const auto& near : tree.nearest(point, reach_m, places))
      seen = seen || model.normals.col(near.index).dot(normal) > kSameWay;
    if (!seen) points.push_back(point), normals.push_back(normal);
  }
  model.assumed_points = to_matrix(points), model.assumed_normals = to_matrix(normals);
}

}  // namespace uniquadric
