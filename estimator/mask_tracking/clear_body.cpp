#include "estimator/mask_tracking/clear_body.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "estimator/observation/outline.h"

namespace uniquadric {
namespace {

constexpr double kMost = 0.5;  // of a mask's pixels with depth lie on the piece that becomes the mask, and
                               // of a smaller piece's in the mask: the body beyond a pole

struct Piece {
  std::vector<cv::Point> pixels;
  std::size_t in_mask = 0;
  bool is_whole = true;  // false: it goes on, or touches another body
};

// What a pixel covers at 1 m, across the line of sight.
double pixel_m2(const Camera& camera) {
  return 1 / (camera.fx * camera.fy);
}

// The piece of depth that a pixel lies on, up to an area.
Piece piece_at(const cv::Point& start, int id, const cv::Mat& masks, const cv::Mat& depth, double jump,
               double most_px_m2, cv::Mat& visited) {
  Piece piece{{start}, 0, true};
  visited.at<unsigned char>(start) = 1;
  double area_px_m2 = 0;
  for (std::size_t i = 0; i < piece.pixels.size(); ++i) {
    const cv::Point from = piece.pixels[i];
    const float z = depth.at<float>(from);
    piece.in_mask += masks.at<std::uint16_t>(from) == id ? 1 : 0;
    area_px_m2 += z * z;
    if (area_px_m2 > most_px_m2) {
      piece.is_whole = false;
      continue;  // what is queued still counts
    }
    for (const cv::Point& step : {cv::Point(1, 0), cv::Point(-1, 0), cv::Point(0, 1), cv::Point(0, -1)}) {
      const cv::Point to = from + step;
      if (!cv::Rect({0, 0}, depth.size()).contains(to) || visited.at<unsigned char>(to)) continue;
      const float next = depth.at<float>(to);
      const int other = masks.at<std::uint16_t>(to);
      if (!(next > 0) || std::abs(next - z) >= jump * std::min(next, z)) continue;
      if (other != 0 && other != id) {
        piece.is_whole = false;  // a hand that holds it
        continue;
      }
      visited.at<unsigned char>(to) = 1;
      piece.pixels.push_back(to);
    }
  }
  return piece;
}

}  // namespace

std::map<int, double> mask_areas_m2(const cv::Mat& masks, const cv::Mat& depth, const Camera& camera) {
  struct Sums {
    double squares_m2 = 0, measured = 0, all = 0;
  };
  std::map<int, Sums> sums;
  for (int v = 0; v < masks.rows; ++v)
    for (int u = 0; u < masks.cols; ++u) {
      const int id = masks.at<std::uint16_t>(v, u);
      if (id == 0) continue;
      Sums& of = sums[id];
      const double z = depth.at<float>(v, u);
      ++of.all;
      if (z > 0) of.squares_m2 += z * z, ++of.measured;
    }
  std::map<int, double> areas;
  for (const auto& [id, of] : sums)
    if (of.measured > 0) areas[id] = pixel_m2(camera) * of.squares_m2 * of.all / of.measured;
  return areas;
}

cv::Mat fit_to_clear_bodies(const cv::Mat& masks, const cv::Mat& depth, const Camera& camera,
                            const std::map<int, double>& areas_m2, double jump, double growth) {
  cv::Mat fitted = masks.clone();
  if (depth.empty()) return fitted;
  for (const auto& [id, box] : id_boxes(masks)) {
    const auto area_m2 = areas_m2.find(id);
    if (area_m2 == areas_m2.end()) continue;
    const double most_px_m2 = growth * area_m2->second / pixel_m2(camera);
    cv::Mat visited = cv::Mat::zeros(depth.size(), CV_8UC1);
    std::size_t measured = 0;
    std::vector<Piece> pieces;
    for (int v = box.y; v < box.br().y; ++v)
      for (int u = box.x; u < box.br().x; ++u) {
        if (masks.at<std::uint16_t>(v, u) != id || !(depth.at<float>(v, u) > 0)) continue;
        ++measured;
        if (visited.at<unsigned char>(v, u)) continue;
        pieces.push_back(piece_at({u, v}, id, masks, depth, jump, most_px_m2, visited));
      }
    if (pieces.empty()) continue;
    const auto best = std::ranges::max_element(pieces, {}, &Piece::in_mask);
    if (!best->is_whole || static_cast<double>(best->in_mask) <= kMost * static_cast<double>(measured))
      continue;
    fitted.setTo(0, (masks == id) & (depth > 0));
    for (const Piece& piece : pieces) {
      const bool is_part =
          static_cast<double>(piece.in_mask) > kMost * static_cast<double>(piece.pixels.size());
      if (&piece != &*best && !(piece.is_whole && is_part)) continue;
      for (const cv::Point& pixel : piece.pixels)
        fitted.at<std::uint16_t>(pixel) = static_cast<std::uint16_t>(id);
    }
  }
  return fitted;
}

}  // namespace uniquadric
