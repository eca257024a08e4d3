#include "estimator/perception/pixel_grid.h"

#include <algorithm>
#include <cstdlib>

#include "estimator/shape/even_choice.h"

namespace uniquadric {
namespace {

constexpr int kSquares = 8;         // from a point to its reach
constexpr std::size_t kCrowd = 64;  // points of a square: several times those of a plane

std::int64_t key(const Eigen::Vector2i& square) {
  return (std::int64_t{square.y()} << 32) + square.x();
}

void thin_out(std::vector<std::size_t>& members, std::size_t most) {
  if (members.size() <= most) return;
  std::size_t kept = 0;
  for (const auto i : even_choice(std::ssize(members), static_cast<std::ptrdiff_t>(most)))
    members[kept++] = members[static_cast<std::size_t>(i)];
  members.resize(kept);
}

}  // namespace

PixelGrid::PixelGrid(const std::vector<ImagePoint>& points, double reach_px, std::size_t neighbours)
    : points_(points), reach_px_(reach_px), side_px_(reach_px / kSquares) {
  for (std::size_t i = 0; i < points.size(); ++i) squares_[key(square_of(points[i].pixel))].push_back(i);
  for (auto& [square, members] : squares_) thin_out(members, std::max(kCrowd, neighbours));
}

// Ring by ring of squares, until what is found is nearer than all of the next one.
std::vector<std::size_t> PixelGrid::nearest(const Eigen::Vector2d& pixel, std::size_t k) const {
  Found found;
  const Eigen::Vector2i middle = square_of(pixel);
  for (int ring = 0; ring <= kSquares + 1; ++ring) {
    const double next_px = std::max(0, ring - 1) * side_px_;
    if (k > 0 && found.size() >= k) {
      const auto last = found.begin() + static_cast<std::ptrdiff_t>(k) - 1;
      std::nth_element(found.begin(), last, found.end());
      if (last->first < next_px * next_px) break;
    }
    for (int y = -ring; y <= ring; ++y)
      for (int x = -ring; x <= ring; x += std::abs(y) == ring ? 1 : 2 * ring)
        add(middle + Eigen::Vector2i(x, y), pixel, found);
  }
  const auto n = static_cast<std::ptrdiff_t>(std::min(k, found.size()));
  std::partial_sort(found.begin(), found.begin() + n, found.end());
  std::vector<std::size_t> result;
  for (std::ptrdiff_t i = 0; i < n; ++i) result.push_back(found[static_cast<std::size_t>(i)].second);
  return result;
}

void PixelGrid::add(const Eigen::Vector2i& square, const Eigen::Vector2d& pixel, Found& found) const {
  const auto in = squares_.find(key(square));
  if (in == squares_.end()) return;
  for (const std::size_t i : in->second)
    if (const double d = (points_[i].pixel - pixel).squaredNorm(); d <= reach_px_ * reach_px_)
      found.emplace_back(d, i);
}

Eigen::Vector2i PixelGrid::square_of(const Eigen::Vector2d& pixel) const {
  return (pixel / side_px_).array().floor().cast<int>();
}

}  // namespace uniquadric
