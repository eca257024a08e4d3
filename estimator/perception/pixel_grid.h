#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "estimator/perception/point_planes.h"

namespace uniquadric {

/// Finds the neighbours of pixels among points, which have to outlive this. Points are kept in squares that
/// are small beside the reach, so that few are looked at for each neighbour. Of a crowd in one square (a wall
/// seen from far off, returns of a beam that stands still) an even choice stands for all, so that the time
/// does not grow with the square of their number.
class PixelGrid {
 public:
  /// `neighbours`: the most that will be asked for; as many of a square are kept, and no fewer than 64.
  PixelGrid(const std::vector<ImagePoint>& points, double reach_px, std::size_t neighbours);

  /// Numbers of the k nearest points within the reach, nearest first, then by number: all that are kept where
  /// there are not as many.
  std::vector<std::size_t> nearest(const Eigen::Vector2d& pixel, std::size_t k) const;

 private:
  using Found = std::vector<std::pair<double, std::size_t>>;  // squared distance, point
  void add(const Eigen::Vector2i& square, const Eigen::Vector2d& pixel, Found& found) const;
  Eigen::Vector2i square_of(const Eigen::Vector2d& pixel) const;

  const std::vector<ImagePoint>& points_;
  double reach_px_, side_px_;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> squares_;
};

}  // namespace uniquadric
