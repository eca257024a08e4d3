#include "evaluation/iou/box_iou.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

namespace uniquadric {
namespace {

using Polygon = std::vector<Eigen::Vector3d>;

// Points with normal . p <= offset.
struct HalfSpace {
  Eigen::Vector3d normal;  // unit, outward
  double offset = 0;
};

// A face with its plane.
struct Face {
  HalfSpace plane;
  Polygon corners;
};

// Of a box whose coordinates are relative to `origin`.
std::vector<Face> faces_of(const Ellipsoid& box, const Eigen::Vector3d& origin) {
  const Eigen::Matrix3d axes = box.world_from_object.rotation.toRotationMatrix();
  const Eigen::Vector3d centre = box.world_from_object.translation - origin;
  std::vector<Face> faces;
  for (int i = 0; i < 3; ++i)
    for (const double side : {-1.0, 1.0}) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const Eigen::Vector3d normal = side * axes.col(i);
      const Eigen::Vector3d middle = centre + box.semi_axes_m[i] * normal;
      const Eigen::Vector3d u = box.semi_axes_m[j] * axes.col(j), v = box.semi_axes_m[k] * axes.col(k);
      faces.push_back(
          {{normal, normal.dot(middle)}, {middle - u - v, middle + u - v, middle + u + v, middle - u + v}});
    }
  return faces;
}

// Sutherland and Hodgman, 1974.
Polygon clipped(const Polygon& polygon, const HalfSpace& side) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double out_p = side.normal.dot(p) - side.offset, out_q = side.normal.dot(q) - side.offset;
    if (out_p <= 0) result.push_back(p);
    if ((out_p < 0 && out_q > 0) || (out_p > 0 && out_q < 0))
      result.push_back(p + out_p / (out_p - out_q) * (q - p));
  }
  return result;
}

double area(const Polygon& polygon, const Eigen::Vector3d& normal) {
  double twice = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    twice += normal.dot((polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]));
  return std::abs(twice) / 2;
}

bool same_plane(const HalfSpace& a, const HalfSpace& b, double rounding_m) {
  return (a.normal - b.normal).norm() < 1e-12 && std::abs(a.offset - b.offset) <= rounding_m;
}

// Three times the volume that the faces of one box contribute to the common body. A face that lies in a plane
// of the other box is that box's, where `leaves_shared` says so.
double flux(const std::vector<Face>& faces, const std::vector<Face>& others, double rounding_m,
            bool leaves_shared) {
  double sum = 0;
  for (const Face& face : faces) {
    Polygon part = face.corners;
    for (const Face& other : others) {
      const bool is_shared = same_plane(face.plane, other.plane, rounding_m);
      if (is_shared && leaves_shared) part.clear();
      if (!is_shared) part = clipped(part, other.plane);
    }
    sum += face.plane.offset * area(part, face.plane.normal);
  }
  return sum;
}

double volume(const Ellipsoid& box) {
  return 8 * box.semi_axes_m.prod();
}

}  // namespace

double box_iou(const Ellipsoid& a, const Ellipsoid& b) {
  const Eigen::Vector3d origin = a.world_from_object.translation;  // far from it digits would be lost
  const std::vector<Face> of_a = faces_of(a, origin), of_b = faces_of(b, origin);
  const double rounding_m = 1e-12 * (a.semi_axes_m.maxCoeff() + b.semi_axes_m.maxCoeff());
  const double common = (flux(of_a, of_b, rounding_m, false) + flux(of_b, of_a, rounding_m, true)) / 3;
  const double least = std::min(volume(a), volume(b));
  const double inside = std::clamp(common, 0.0, least);
  return inside / (volume(a) + volume(b) - inside);
}

}  // namespace uniquadric
