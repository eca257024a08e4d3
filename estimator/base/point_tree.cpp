#include "estimator/base/point_tree.h"

#include <algorithm>
#include <limits>
#include <nanoflann.hpp>

namespace uniquadric {
namespace {

constexpr std::size_t kLeafPoints = 15;

struct Points {
  Eigen::Matrix3Xf of;
  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(of.cols()); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return of(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(i));
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;  // the tree finds it
  }
};

using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points, float>, Points, 3, int>;

// Names that nanoflann wants of a set of results.
struct Nearest {
  using DistanceType = float;
  using IndexType = int;
  std::span<PointTree::Neighbour> found;
  float limit;
  std::size_t count = 0;

  std::size_t size() const { return count; }
  bool full() const { return count == found.size(); }
  bool empty() const { return count == 0; }
  float worstDist() const { return full() ? found.back().squared_m2 : limit; }
  bool addPoint(float squared_m2, int index) {
    if (!(squared_m2 < worstDist())) return true;
    std::size_t place = full() ? count - 1 : count++;
    for (; place > 0 && found[place - 1].squared_m2 > squared_m2; --place) found[place] = found[place - 1];
    found[place] = {index, squared_m2};
    return true;
  }
  void sort() {}
};

struct Within {
  using DistanceType = float;
  using IndexType = int;
  std::vector<int>& found;
  float limit;

  std::size_t size() const { return found.size(); }
  bool full() const { return true; }
  bool empty() const { return found.empty(); }
  float worstDist() const { return limit; }
  bool addPoint(float squared_m2, int index) {
    if (squared_m2 < limit) found.push_back(index);
    return true;
  }
  void sort() {}
};

float squared_limit(double reach_m) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return static_cast<float>(std::min(kMost, reach_m * reach_m));
}

}  // namespace

struct PointTree::Index {
  explicit Index(const Eigen::Matrix3Xd& all)
      : points{all.cast<float>()}, tree(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafPoints)) {}

  template <typename Found>
  void search(const Eigen::Vector3d& p, Found& found) const {
    if (points.of.cols() == 0) return;
    const Eigen::Vector3f at = p.cast<float>();
    tree.findNeighbors(found, at.data(), {});
  }

  Points points;
  Tree tree;
};

PointTree::PointTree(const Eigen::Matrix3Xd& points) : index_(std::make_unique<Index>(points)) {}
PointTree::~PointTree() = default;

std::span<PointTree::Neighbour> PointTree::nearest(const Eigen::Vector3d& p, double reach_m,
                                                   std::span<Neighbour> found) const {
  Nearest nearest{found, squared_limit(reach_m)};
  if (!found.empty()) index_->search(p, nearest);
  return found.first(nearest.count);
}

void PointTree::within(const Eigen::Vector3d& p, double reach_m, std::vector<int>& found) const {
  found.clear();
  Within all{found, squared_limit(reach_m)};
  index_->search(p, all);
}

}  // namespace uniquadric
