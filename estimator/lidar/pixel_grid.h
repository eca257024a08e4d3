#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "estimator/lidar/point_planes.h"

namespace uniquadric {

/// Finds the neighbours of pixels among points. Points are kept in squares that are small beside the reach,
/// row by row, so that few are looked at for each neighbour. Of a crowd in one square (a wall seen from far
/// off, returns of a beam that stands still) an even choice stands for all, so that the time does not grow
/// with the square of their number.
class PixelGrid {
 public:
  /// `neighbours`: the most that will be asked for; as many of a square are kept, and no fewer than 64.
  PixelGrid(const std::vector<ImagePoint>& points, double reach_px, std::size_t neighbours);

  /// Numbers of the k nearest points within the reach, nearest first, then by number: all that are kept where
  /// there are not as many.
  std::vector<std::size_t> nearest(const Eigen::Vector2d& pixel, std::size_t k) const;

 private:
  struct Member {
    Eigen::Vector2d pixel;
    std::size_t point;
  };
  class Nearest;
  void fill(const std::vector<ImagePoint>& points);
  void thin_out(std::size_t most);
  void look(int row, int left, int right, Nearest& nearest) const;  // at squares left..right
  std::size_t index(const Eigen::Vector2i& square) const {
    return static_cast<std::size_t>(square.y()) * static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(square.x());
  }
  Eigen::Vector2i square_of(const Eigen::Vector2d& pixel) const;

  double reach_px_, side_px_;
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();
  Eigen::Vector2i size_ = Eigen::Vector2i::Ones();  // columns, rows
  std::vector<Member> members_;                     // square by square
  std::vector<std::uint32_t> begins_;               // of each square's members, and their end
};

}  // namespace uniquadric
