#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

namespace uniquadric {

/// A k-d tree over points, in single precision (nanoflann). Searches may run side by side.
class PointTree {
 public:
  struct Neighbour {
    int index = 0;         ///< of the point
    float squared_m2 = 0;  ///< distance
  };

  /// (3 x n) [m]
  explicit PointTree(const Eigen::Matrix3Xd& points);
  ~PointTree();

  /// The points nearest to `p` that are less than `reach_m` away, nearest first, as many as `found` holds.
  /// Returns those that were found.
  std::span<Neighbour> nearest(const Eigen::Vector3d& p, double reach_m, std::span<Neighbour> found) const;

  /// The indices of all points that are less than `reach_m` from `p`, in the tree's order; replaces `found`.
  void within(const Eigen::Vector3d& p, double reach_m, std::vector<int>& found) const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace uniquadric
