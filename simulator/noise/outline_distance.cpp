#include "simulator/noise/outline_distance.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/vector_clones.h"

namespace uniquadric {
namespace {

using Row = std::vector<std::int16_t>;

// Distance along the column to the nearest pixel of the other side, `most` where none is so near (16SC1).
cv::Mat column_distance(const cv::Mat& inside, std::int16_t most) {
  cv::Mat distance(inside.size(), CV_16SC1, cv::Scalar(most));
  const auto sweep = [&](int v, int from) {
    const auto *side = inside.ptr<std::uint8_t>(v), *other = inside.ptr<std::uint8_t>(from);
    auto* here = distance.ptr<std::int16_t>(v);
    const auto* there = distance.ptr<std::int16_t>(from);
    for (int u = 0; u < inside.cols; ++u) {
      const auto far = std::min<std::int16_t>(here[u], static_cast<std::int16_t>(there[u] + 1));
      here[u] = side[u] != other[u] ? std::int16_t{1} : far;
    }
  };
  for (int v = 1; v < inside.rows; ++v) sweep(v, v - 1);
  for (int v = inside.rows - 2; v >= 0; --v) sweep(v, v + 1);
  return distance;
}

// Squares of the distances to the nearest pixel of the other side, of which the pixels [margin, ...) have
// `squares` in their own columns: min over du of du^2 + squares[u + du].
UNIQUADRIC_VECTOR_CLONES
void row_squares(const Row& squares, int margin, Row& nearest) {
  const std::size_t count = nearest.size();
  std::fill(nearest.begin(), nearest.end(), std::int16_t{INT16_MAX});
  for (int du = -margin; du <= margin; ++du) {
    const auto along = static_cast<std::int16_t>(du * du);
    const std::int16_t* shifted = squares.data() + margin + du;
    for (std::size_t u = 0; u < count; ++u)
      nearest[u] = std::min<std::int16_t>(nearest[u], static_cast<std::int16_t>(shifted[u] + along));
  }
}

std::vector<float> distances_of_squares(int most) {
  std::vector<float> distances(static_cast<std::size_t>(most * most) + 1);
  for (std::size_t i = 0; i < distances.size(); ++i) distances[i] = std::sqrt(static_cast<float>(i)) - 0.5f;
  return distances;
}

}  // namespace

cv::Mat outline_distance(const cv::Mat& ids, int id, int reach_px) {
  assert(0 < reach_px && reach_px <= kMostOutlineReach_px);
  const auto most = static_cast<std::int16_t>(reach_px + 1),
             most_square = static_cast<std::int16_t>(most * most);
  cv::Mat inside;
  cv::compare(ids, id, inside, cv::CMP_EQ);
  const cv::Mat column = column_distance(inside, most);
  const std::vector<float> distances = distances_of_squares(most);
  const auto columns = static_cast<std::size_t>(ids.cols);
  // seen from either side, a pixel of the other one is at its own place; beyond the image there is nothing
  Row from_inside(columns + 2 * most, most_square), from_outside = from_inside;
  Row nearest_inside(columns), nearest_outside(columns);
  cv::Mat distance(ids.size(), CV_32FC1);
  for (int v = 0; v < ids.rows; ++v) {
    const auto* side = inside.ptr<std::uint8_t>(v);
    const auto* along = column.ptr<std::int16_t>(v);
    for (std::size_t u = 0; u < columns; ++u) {
      const auto square = static_cast<std::int16_t>(along[u] * along[u]);
      from_inside[u + most] = side[u] ? square : std::int16_t{0};
      from_outside[u + most] = side[u] ? std::int16_t{0} : square;
    }
    row_squares(from_inside, most, nearest_inside);
    row_squares(from_outside, most, nearest_outside);
    auto* out = distance.ptr<float>(v);
    for (std::size_t u = 0; u < columns; ++u)
      out[u] = side[u] ? distances[std::min(nearest_inside[u], most_square)]
                       : -distances[std::min(nearest_outside[u], most_square)];
  }
  return distance;
}

}  // namespace uniquadric
