#include "estimator/lidar/pixel_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace uniquadric {
namespace {

constexpr double kSquares = 8;           // from a point to its reach
constexpr std::size_t kCrowd = 64;       // points of a square: several times those of a plane
constexpr double kMostPixels = 1 << 14;  // from the image's corner: larger than any image
constexpr double kMostSquares = 1 << 20;

}  // namespace

// The k nearest of all that it was shown, in order.
class PixelGrid::Nearest {
 public:
  Nearest(const Eigen::Vector2d& pixel, std::size_t k, double reach_px)
      : pixel_(pixel), k_(k), limit_(reach_px * reach_px) {
    found_.reserve(k + 1);
  }

  void show(const Member& member) {
    const double d = (member.pixel - pixel_).squaredNorm();
    if (!(d <= limit_)) return;
    const std::pair<double, std::size_t> one(d, member.point);
    if (is_full() && found_.back() < one) return;
    found_.insert(std::upper_bound(found_.begin(), found_.end(), one), one);
    if (found_.size() > k_) found_.pop_back();
    if (is_full()) limit_ = found_.back().first;
  }

  bool is_full() const { return found_.size() == k_; }
  double limit_px2() const { return limit_; }
  const std::vector<std::pair<double, std::size_t>>& found() const { return found_; }

 private:
  Eigen::Vector2d pixel_;
  std::size_t k_;
  double limit_;
  std::vector<std::pair<double, std::size_t>> found_;  // squared distance, point
};

PixelGrid::PixelGrid(const std::vector<ImagePoint>& points, double reach_px, std::size_t neighbours)
    : reach_px_(reach_px), side_px_(reach_px / kSquares) {
  if (points.empty()) return;
  Eigen::Vector2d most = Eigen::Vector2d::Constant(-kMostPixels);
  corner_ = -most;
  for (const ImagePoint& point : points) {
    corner_ = corner_.cwiseMin(point.pixel.cwiseMax(-kMostPixels));
    most = most.cwiseMax(point.pixel.cwiseMin(kMostPixels));
  }
  side_px_ = std::max(side_px_, std::sqrt((most - corner_).prod() / kMostSquares));
  size_ = ((most - corner_) / side_px_).array().floor().cast<int>() + 1;
  fill(points);
  thin_out(std::max(kCrowd, neighbours));
}

// Sorted by squares, in each by number.
void PixelGrid::fill(const std::vector<ImagePoint>& points) {
  std::vector<std::size_t> squares;
  for (const ImagePoint& point : points) squares.push_back(index(square_of(point.pixel)));
  begins_.assign(index(size_ - Eigen::Vector2i::Ones()) + 2, 0);
  for (const std::size_t square : squares) ++begins_[square + 1];
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  members_.resize(points.size());
  std::vector<std::uint32_t> next = begins_;
  for (std::size_t i = 0; i < points.size(); ++i) members_[next[squares[i]]++] = {points[i].pixel, i};
}

void PixelGrid::thin_out(std::size_t most) {
  std::uint32_t kept = 0;
  for (std::size_t square = 0; square + 1 < begins_.size(); ++square) {
    const std::uint32_t begin = std::exchange(begins_[square], kept), end = begins_[square + 1];
    const std::size_t count = end - begin, chosen = std::min(count, most);
    for (std::size_t i = 0; i < chosen; ++i) members_[kept++] = members_[begin + i * count / chosen];
  }
  begins_.back() = kept;
}

// Ring by ring of squares, until what is found is nearer than all of the next one.
std::vector<std::size_t> PixelGrid::nearest(const Eigen::Vector2d& pixel, std::size_t k) const {
  if (members_.empty() || k == 0) return {};
  Nearest nearest(pixel, std::min(k, members_.size()), reach_px_);
  const Eigen::Vector2i middle = square_of(pixel);
  for (int ring = 0;; ++ring) {
    const double next_px = std::max(0, ring - 1) * side_px_;
    if (nearest.limit_px2() < next_px * next_px) break;
    const int left = middle.x() - ring, right = middle.x() + ring;
    look(middle.y() - ring, left, right, nearest);
    for (int y = middle.y() - ring + 1; y < middle.y() + ring; ++y) {
      look(y, left, left, nearest);
      look(y, right, right, nearest);
    }
    if (ring > 0) look(middle.y() + ring, left, right, nearest);
  }
  std::vector<std::size_t> result;
  result.reserve(nearest.found().size());
  for (const auto& [d, point] : nearest.found()) result.push_back(point);
  return result;
}

void PixelGrid::look(int row, int left, int right, Nearest& nearest) const {
  left = std::max(left, 0), right = std::min(right, size_.x() - 1);
  if (row < 0 || row >= size_.y() || left > right) return;
  const std::uint32_t end = begins_[index({right, row}) + 1];
  for (std::uint32_t i = begins_[index({left, row})]; i < end; ++i) nearest.show(members_[i]);
}

// What is farther off than the grid's rim counts to it: no square is farther from it than the point is.
Eigen::Vector2i PixelGrid::square_of(const Eigen::Vector2d& pixel) const {
  const Eigen::Array2d at = ((pixel - corner_) / side_px_).array().floor();
  return at.max(0.0).min((size_ - Eigen::Vector2i::Ones()).cast<double>().array()).cast<int>();
}

}  // namespace uniquadric
