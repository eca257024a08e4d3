#include "estimator/shape/body_carving.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/core.hpp>

#include "estimator/base/point_tree.h"

namespace uniquadric {
namespace {

constexpr int kNeighbours = 8;           // points that say on which side of the surface a cell is
constexpr double kLeastExponent = 1.01;  // the gauge of a box has no derivative

// The sides of cells that border on none, as two triangles each, seen from outside anticlockwise.
class CellMesh {
 public:
  CellMesh(const std::array<int, 3>& size, const Eigen::Vector3d& corner, const Eigen::Vector3d& cell_m)
      : size_(size),
        corner_(corner),
        cell_m_(cell_m),
        is_full_(static_cast<std::size_t>(size[0]) * size[1] * size[2]) {}

  void fill(const std::array<int, 3>& place) { is_full_[index(place)] = true; }

  SurfaceFile mesh() {
    for (int x = 0; x < size_[0]; ++x)
      for (int y = 0; y < size_[1]; ++y)
        for (int z = 0; z < size_[2]; ++z)
          if (is_full({x, y, z})) add_sides({x, y, z});
    return std::move(mesh_);
  }

 private:
  std::size_t index(const std::array<int, 3>& p) const {
    return (static_cast<std::size_t>(p[0]) * size_[1] + p[1]) * size_[2] + p[2];
  }

  bool is_full(const std::array<int, 3>& p) const {
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] < 0 || p[axis] >= size_[axis]) return false;
    return is_full_[index(p)];
  }

  std::uint32_t corner(const std::array<int, 3>& p) {
    const auto [known, is_new] = corners_.try_emplace(p, static_cast<std::uint32_t>(mesh_.points.size()));
    if (is_new)
      mesh_.points.push_back(
          (corner_ + Eigen::Vector3d(p[0], p[1], p[2]).cwiseProduct(cell_m_)).cast<float>());
    return known->second;
  }

  void add_sides(const std::array<int, 3>& place) {
    for (int axis = 0; axis < 3; ++axis)
      for (const int way : {0, 1}) {
        std::array<int, 3> beside = place;
        beside[axis] += way == 1 ? 1 : -1;
        if (is_full(beside)) continue;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        std::array<int, 3> a = place;
        a[axis] += way;
        std::array<int, 3> b = a, c = a, d = a;
        ++b[u], ++c[u], ++c[v], ++d[v];
        if (way == 0) std::swap(b, d);
        const std::uint32_t ia = corner(a), ib = corner(b), ic = corner(c), id = corner(d);
        mesh_.triangles.push_back({ia, ib, ic});
        mesh_.triangles.push_back({ia, ic, id});
      }
  }

  std::array<int, 3> size_;
  Eigen::Vector3d corner_, cell_m_;
  std::vector<bool> is_full_;
  std::map<std::array<int, 3>, std::uint32_t> corners_;
  SurfaceFile mesh_;
};

// On which side of the points seen a place is.
class SeenSide {
 public:
  explicit SeenSide(const SurfaceFile& seen) : seen_(seen), tree_(points_of(seen)) {}

  // Whether it lies no farther than `within_m` from a point, and outside of most around it.
  bool is_just_outside(const Eigen::Vector3d& place, double within_m) const {
    if (!is_usable()) return false;
    const Eigen::Vector3f p = place.cast<float>();
    std::array<PointTree::Neighbour, kNeighbours> near;
    tree_.nearest(place, std::numeric_limits<double>::infinity(), near);
    if (near.front().squared_m2 > within_m * within_m) return false;
    std::array<float, kNeighbours> above{};
    for (std::size_t i = 0; i < above.size(); ++i) {
      const auto at = static_cast<std::size_t>(near[i].index);
      above[i] = (p - seen_.points[at]).dot(seen_.normals[at]);
    }
    std::ranges::sort(above);
    return above[kNeighbours / 2 - 1] + above[kNeighbours / 2] > 0;
  }

 private:
  bool is_usable() const {
    return seen_.points.size() >= kNeighbours && seen_.normals.size() == seen_.points.size();
  }

  static Eigen::Matrix3Xd points_of(const SurfaceFile& seen) {
    Eigen::Matrix3Xd points(3, std::ssize(seen.points));
    for (Eigen::Index i = 0; i < points.cols(); ++i)
      points.col(i) = seen.points[static_cast<std::size_t>(i)].cast<double>();
    return points;
  }

  const SurfaceFile& seen_;
  PointTree tree_;
};

}  // namespace

BodyCarving::BodyCarving(const Superellipsoid& body, double noise_per_range, const CarvingOptions& options)
    : options_(options), noise_per_range_(noise_per_range), corner_(-body.semi_axes_m) {
  const double side_m = 2 * std::cbrt(body.semi_axes_m.prod()) / options.cells;
  for (int axis = 0; axis < 3; ++axis) {
    size_[axis] = std::max(1, static_cast<int>(std::ceil(2 * body.semi_axes_m[axis] / side_m)));
    cell_m_[axis] = 2 * body.semi_axes_m[axis] / size_[axis];
  }
  Superellipsoid solid = body;
  for (double* q : {&solid.exponents.outline, &solid.exponents.upper, &solid.exponents.lower})
    *q = std::max(*q, kLeastExponent);
  for (int x = 0; x < size_[0]; ++x)
    for (int y = 0; y < size_[1]; ++y)
      for (int z = 0; z < size_[2]; ++z) {
        const Eigen::Vector3d middle =
            corner_ + Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5).cwiseProduct(cell_m_);
        if (gauge(solid, middle) <= 1) cells_.push_back({{x, y, z}, middle});
      }
}

void BodyCarving::add(const cv::Mat& depth_m, const Camera& camera, const Pose& camera_from_object) {
  const Eigen::Matrix3d rotation = camera_from_object.rotation.toRotationMatrix();
  for (Cell& cell : cells_) {
    const Eigen::Vector3d p = rotation * cell.middle + camera_from_object.translation;
    const auto pixel = camera.project(p);
    if (!pixel || !camera.contains(*pixel)) continue;
    const int u = std::min(static_cast<int>(pixel->x() + 0.5), depth_m.cols - 1),
              v = std::min(static_cast<int>(pixel->y() + 0.5), depth_m.rows - 1);
    const double depth = depth_m.at<float>(v, u);
    const double reach_m = options_.sigmas * noise_per_range_ * p.z();
    if (!(depth > 0) || depth < p.z() - reach_m) continue;  // something is before it
    ++cell.seen;
    cell.free += depth > p.z() + reach_m;
  }
  range_sum_m_ += camera_from_object.translation.z();
  ++views_;
}

bool BodyCarving::is_free(const Cell& cell) const {
  return cell.free >= options_.min_views && cell.free >= options_.min_share * cell.seen;
}

std::optional<SurfaceFile> BodyCarving::carved(const SurfaceFile& seen) const {
  const auto free = std::ranges::count_if(cells_, [&](const Cell& cell) { return is_free(cell); });
  if (static_cast<double>(free) <= options_.least_free * static_cast<double>(cells_.size()))
    return std::nullopt;
  const SeenSide side(seen);
  const double near_m = options_.sigmas * noise_per_range_ * range_sum_m_ / views_;
  CellMesh mesh(size_, corner_, cell_m_);
  for (const Cell& cell : cells_)
    if (!is_free(cell) && !side.is_just_outside(cell.middle, near_m)) mesh.fill(cell.place);
  SurfaceFile left = mesh.mesh();
  return left.triangles.empty() ? std::nullopt : std::optional(std::move(left));
}

}  // namespace uniquadric
