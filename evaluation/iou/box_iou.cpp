#include "evaluation/iou/box_iou.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace uniquadric {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

// The second box in the first one's frame.
struct Pair {
  Eigen::Vector3d half_a_m;
  Eigen::Matrix3d axes_b;  // columns
  Eigen::Vector3d centre_b_m, half_b_m;
};

std::array<Eigen::Vector3d, 8> corners_of_b(const Pair& pair) {
  std::array<Eigen::Vector3d, 8> corners;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d signs(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    corners[i] = pair.centre_b_m + pair.axes_b * signs.cwiseProduct(pair.half_b_m);
  }
  return corners;
}

// Where edges of the second box cross the side planes of the first.
void add_edge_crossings(const Pair& pair, std::vector<double>& heights_m) {
  const auto corners = corners_of_b(pair);
  for (int i = 0; i < 8; ++i)
    for (const int bit : {1, 2, 4}) {
      if (i & bit) continue;
      const Eigen::Vector3d &p = corners[i], &q = corners[i | bit];
      for (int axis = 0; axis < 2; ++axis)
        for (const double plane_m : {-pair.half_a_m[axis], pair.half_a_m[axis]})
          if ((p[axis] < plane_m) != (q[axis] < plane_m))
            heights_m.push_back(p.z() + (plane_m - p[axis]) / (q[axis] - p[axis]) * (q.z() - p.z()));
    }
}

// Where upright edges of the first box pierce the faces of the second.
void add_pierced_faces(const Pair& pair, std::vector<double>& heights_m) {
  for (int i = 0; i < 3; ++i)
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d normal = side * pair.axes_b.col(i);
      const double offset_m = normal.dot(pair.centre_b_m) + pair.half_b_m[i];
      if (normal.z() == 0) continue;
      for (const double x : {-pair.half_a_m.x(), pair.half_a_m.x()})
        for (const double y : {-pair.half_a_m.y(), pair.half_a_m.y()})
          heights_m.push_back((offset_m - normal.x() * x - normal.y() * y) / normal.z());
    }
}

// Heights at which the common body may have a corner, increasing, within both boxes.
std::vector<double> corner_heights(const Pair& pair) {
  std::vector<double> heights_m = {-pair.half_a_m.z(), pair.half_a_m.z()};
  for (const Eigen::Vector3d& corner : corners_of_b(pair)) heights_m.push_back(corner.z());
  add_edge_crossings(pair, heights_m);
  add_pierced_faces(pair, heights_m);
  for (double& height_m : heights_m) height_m = std::clamp(height_m, -pair.half_a_m.z(), pair.half_a_m.z());
  std::sort(heights_m.begin(), heights_m.end());
  return heights_m;
}

// Sutherland and Hodgman, 1974: what lies where normal . p <= offset.
Polygon clipped(const Polygon& polygon, const Eigen::Vector2d& normal, double offset) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double out_p = normal.dot(p) - offset, out_q = normal.dot(q) - offset;
    if (out_p <= 0) result.push_back(p);
    if ((out_p < 0 && out_q > 0) || (out_p > 0 && out_q < 0))
      result.push_back(p + out_p / (out_p - out_q) * (q - p));
  }
  return result;
}

// Of the common body's cross-section.
double area_at(const Pair& pair, double height_m) {
  const double x = pair.half_a_m.x(), y = pair.half_a_m.y();
  Polygon section = {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
  for (int i = 0; i < 3; ++i)
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d normal = side * pair.axes_b.col(i);
      const double offset = normal.dot(pair.centre_b_m) + pair.half_b_m[i] - normal.z() * height_m;
      section = clipped(section, normal.head<2>(), offset);
    }
  double twice = 0;
  for (std::size_t i = 0; i < section.size(); ++i) {
    const Eigen::Vector2d &p = section[i], &q = section[(i + 1) % section.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return std::max(0.0, twice / 2);
}

double common_volume(const Pair& pair) {
  const std::vector<double> heights_m = corner_heights(pair);
  const double node = 1 / std::sqrt(3.0);  // of Gauss and Legendre, on [-1, 1]
  double volume = 0;
  for (std::size_t i = 1; i < heights_m.size(); ++i) {
    const double half_m = (heights_m[i] - heights_m[i - 1]) / 2, middle_m = heights_m[i - 1] + half_m;
    if (half_m > 0)
      volume += half_m * (area_at(pair, middle_m - node * half_m) + area_at(pair, middle_m + node * half_m));
  }
  return volume;
}

double volume(const Ellipsoid& box) {
  return 8 * box.semi_axes_m.prod();
}

bool is_same(const Ellipsoid& a, const Ellipsoid& b) {
  return a.semi_axes_m == b.semi_axes_m &&
         a.world_from_object.translation == b.world_from_object.translation &&
         a.world_from_object.rotation.coeffs() == b.world_from_object.rotation.coeffs();
}

}  // namespace

double box_iou(const Ellipsoid& a, const Ellipsoid& b) {
  if (is_same(a, b)) return 1;
  const Eigen::Quaterniond a_from_world = a.world_from_object.rotation.conjugate();
  const Pair pair{a.semi_axes_m, (a_from_world * b.world_from_object.rotation).toRotationMatrix(),
                  a_from_world * (b.world_from_object.translation - a.world_from_object.translation),
                  b.semi_axes_m};
  const double common = std::min({common_volume(pair), volume(a), volume(b)});
  return common / (volume(a) + volume(b) - common);
}

}  // namespace uniquadric
