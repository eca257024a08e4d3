#include "simulator/scene/painter.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace uniquadric {

Color Painter::shade(const Eigen::Vector3d& rgb, double gain) {
  const auto level = [&](double v) { return std::clamp(255 * v * gain, 0.0, 255.0); };
  return {level(rgb.z()), level(rgb.y()), level(rgb.x())};
}

Color Painter::tone() {
  const Eigen::Vector3d& base = random.uniform() < 0.6 ? material.color : material.accent;
  const Eigen::Vector3d mixed = material.color + material.contrast * (base - material.color);
  return shade(mixed, 1 + material.contrast * random.uniform(-0.75, 0.75));
}

Color Painter::ink() {
  const double gain = random.uniform() < 0.5 ? 1 - 0.8 * material.contrast : 1 + 0.9 * material.contrast;
  return shade(random.uniform() < 0.6 ? material.color : material.accent, gain);
}

cv::Point Painter::place() {
  return {static_cast<int>(random.below(static_cast<std::uint32_t>(image.cols))),
          static_cast<int>(random.below(static_cast<std::uint32_t>(image.rows)))};
}

int Painter::length(double low, double high) {
  return std::max(1, static_cast<int>(std::lround(unit * low * std::pow(high / low, random.uniform()))));
}

int Painter::count(double per_square_unit) const {
  return static_cast<int>(per_square_unit * image.cols * image.rows / (unit * unit));
}

// OpenCV's 8-bit exact resize gives the same bytes on every machine.
void add_value_noise(Painter& p) {
  constexpr int kOctaves = 5;
  cv::Mat sum(p.image.size(), CV_16SC1, cv::Scalar(0));
  double strength = 60 * p.material.contrast;
  for (int octave = 0, cell = 4 * p.unit; octave < kOctaves && cell >= 2;
       ++octave, cell /= 2, strength /= 1.6) {
    cv::Mat lattice(p.image.rows / cell + 2, p.image.cols / cell + 2, CV_8UC1), smooth, scaled;
    for (int i = 0; i < lattice.rows; ++i)
      for (int j = 0; j < lattice.cols; ++j)
        lattice.at<unsigned char>(i, j) = static_cast<unsigned char>(p.random.bits() >> 24);
    cv::resize(lattice, smooth, {lattice.cols * cell, lattice.rows * cell}, 0, 0, cv::INTER_LINEAR_EXACT);
    smooth(cv::Rect({0, 0}, p.image.size())).convertTo(scaled, CV_16SC1, strength / 128, -strength);
    sum += scaled;
  }
  for (int v = 0; v < p.image.rows; ++v) {
    auto* pixel = p.image.ptr<cv::Vec3b>(v);
    const auto* noise = sum.ptr<std::int16_t>(v);
    for (int u = 0; u < p.image.cols; ++u)
      for (int c = 0; c < 3; ++c) pixel[u][c] = cv::saturate_cast<unsigned char>(pixel[u][c] + noise[u]);
  }
}

}  // namespace uniquadric
