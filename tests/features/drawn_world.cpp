#include "drawn_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/random.h"

namespace uniquadric {
namespace {

struct Hit {
  double depth_m = 0, gray = 0;
  int label = 0;
};

double sampled(const cv::Mat& texture, double x, double y) {
  const double u = std::clamp(x * (texture.cols - 1), 0.0, texture.cols - 1.001);
  const double v = std::clamp(y * (texture.rows - 1), 0.0, texture.rows - 1.001);
  const int i = static_cast<int>(u), j = static_cast<int>(v);
  const double a = u - i, b = v - j;
  const auto at = [&](int row, int column) { return double(texture.at<float>(row, column)); };
  return (1 - b) * ((1 - a) * at(j, i) + a * at(j, i + 1)) +
         b * ((1 - a) * at(j + 1, i) + a * at(j + 1, i + 1));
}

Hit cast(const std::vector<DrawnCard>& cards, const Eigen::Vector3d& ray) {
  Hit nearest;
  for (const auto& card : cards) {
    const Eigen::Vector3d normal = card.camera_from_card.rotation * Eigen::Vector3d::UnitZ();
    const double slant = normal.dot(ray);
    if (std::abs(slant) < 1e-9) continue;
    const double z = normal.dot(card.camera_from_card.translation) / slant;
    if (!(z > 0.05) || (nearest.depth_m > 0 && z >= nearest.depth_m)) continue;
    const Eigen::Vector3d p =
        card.camera_from_card.rotation.conjugate() * (z * ray - card.camera_from_card.translation);
    const double x = p.x() / card.size_m.x() + 0.5, y = p.y() / card.size_m.y() + 0.5;
    if (x < 0 || y < 0 || x > 1 || y > 1) continue;
    nearest = {z, sampled(card.texture, x, y), card.label};
  }
  return nearest;
}

}  // namespace

cv::Mat block_texture(int side_px, std::uint64_t seed) {
  cv::Mat texture(side_px, side_px, CV_32FC1, cv::Scalar(120));
  RandomStream random(seed, "block_texture");
  for (const int block : {side_px / 8, side_px / 20, side_px / 40})
    for (int i = 0; i < side_px * side_px / (3 * block * block); ++i) {
      const int w = block / 2 + random.below(block), h = block / 2 + random.below(block);
      const cv::Rect place(random.below(side_px), random.below(side_px), w, h);
      texture(place & cv::Rect(0, 0, side_px, side_px)).setTo(random.uniform(20, 235));
    }
  cv::GaussianBlur(texture, texture, cv::Size(3, 3), 0.7);
  return texture;
}

std::vector<DrawnCard> box_cards(int label, const Eigen::Vector3d& size_m, std::uint64_t seed) {
  std::vector<DrawnCard> cards;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      Eigen::Matrix3d R;
      R.col(2) = side * Eigen::Vector3d::Unit(axis);
      R.col(0) = Eigen::Vector3d::Unit((axis + 1) % 3);
      R.col(1) = R.col(2).cross(R.col(0));
      DrawnCard card;
      card.label = label;
      card.size_m = {size_m[(axis + 1) % 3], size_m[(axis + 2) % 3]};
      card.texture = block_texture(240, seed + 10 * axis + (side > 0));
      card.camera_from_card = {Eigen::Quaterniond(R), 0.5 * size_m[axis] * R.col(2)};
      cards.push_back(card);
    }
  return cards;
}

std::vector<DrawnCard> moved(std::vector<DrawnCard> cards, const Pose& camera_from_body) {
  for (auto& card : cards) card.camera_from_card = camera_from_body * card.camera_from_card;
  return cards;
}

DrawnFrame draw(const Camera& camera, const std::vector<DrawnCard>& cards, const DrawnNoise& noise,
                std::uint64_t frame) {
  const cv::Size size(camera.width, camera.height);
  DrawnFrame result{cv::Mat(size, CV_8UC1), cv::Mat(size, CV_32FC1), cv::Mat(size, CV_32FC1),
                    cv::Mat(size, CV_16UC1)};
  RandomStream random(7, "drawn_noise", frame);
  const auto ray = [&](double u, double v) {
    return Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
  };
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Hit centre = cast(cards, ray(u, v));
      double gray = 0;
      for (const double dv : {-0.25, 0.25})
        for (const double du : {-0.25, 0.25}) gray += cast(cards, ray(u + du, v + dv)).gray / 4;
      gray += noise.gray_levels * random.normal();
      result.gray.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(gray);
      result.true_depth.at<float>(v, u) = static_cast<float>(centre.depth_m);
      result.depth.at<float>(v, u) = static_cast<float>(centre.depth_m * (1 + noise.depth * random.normal()));
      result.masks.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(centre.label);
    }
  return result;
}

Camera small_camera() {
  return {320, 240, 280, 280, 159.5, 119.5, {}};
}

}  // namespace uniquadric
