#include "simulator/families/draw.h"

#include <fmt/format.h>

#include <cmath>

namespace uniquadric {

double graded(double difficulty, double easy, double hard) {
  return easy + difficulty * (hard - easy);
}

std::string yaml_number(double value, int digits) {
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::string yaml_vector(const Eigen::Vector3d& value, int digits) {
  return fmt::format("[{}, {}, {}]", yaml_number(value.x(), digits), yaml_number(value.y(), digits),
                     yaml_number(value.z(), digits));
}

Eigen::Vector3d drawn_color(RandomStream& random) {
  constexpr double kChroma = 0.18;  // ours: as things about a house, not as a box of crayons
  const double tone = random.uniform(0.2, 0.75);
  const Eigen::Vector3d tint{random.uniform(-kChroma, kChroma), random.uniform(-kChroma, kChroma),
                             random.uniform(-kChroma, kChroma)};
  return (tint.array() + tone).cwiseMax(0.05).cwiseMin(0.95);
}

std::string drawn_material(RandomStream& random, double difficulty) {
  const std::string style = one_of<std::string>(random, {"panels", "checks", "speckle", "strokes"});
  const double contrast = graded(difficulty, 0.6, 0.1) * random.uniform(0.7, 1.3);
  const double marks = graded(difficulty, 8, 1) * random.uniform(0.7, 1.3);
  const bool is_plain = random.uniform() < graded(difficulty, 0, 0.5);
  const Eigen::Vector3d color = drawn_color(random), accent = drawn_color(random);
  const double shine = random.uniform() < 0.3 ? random.uniform(0.2, 0.8) : 0;
  constexpr double kMirrored = 0.5;  // of a depth sensor's light, by what shines most
  return fmt::format(
      "{{style: {}, color: {}, accent: {}, contrast: {}, marks: {}, shine: {}{}{}}}", style,
      yaml_vector(color, 2), yaml_vector(accent, 2), yaml_number(contrast, 2),
      std::max(1, static_cast<int>(std::lround(marks))), yaml_number(shine, 2),
      shine > 0 ? fmt::format(", depth_return: {}", yaml_number(1 - kMirrored * shine, 2)) : "",
      is_plain ? ", texture: none" : "");
}

std::string drawn_room(RandomStream& random) {
  return fmt::format(
      "  - {{name: room, primitive: room, size_m: [6, 6, 3], furniture: 8, material: {{seed: {}}}}}\n",
      random.below(100'000));
}

std::string drawn_camera_tremor(RandomStream& random) {
  return fmt::format("      - {{kind: tremor, position_m: 0.001, rotation_deg: 0.15, seed: {}}}\n",
                     random.below(100'000));
}

std::string drawn_lens(RandomStream& random) {
  if (random.below(2)) return "";
  const double k1 = random.uniform(-0.15, 0.25), k2 = -k1 * random.uniform(0.5, 1.2);
  const double p1 = random.uniform(-0.003, 0.003), p2 = random.uniform(-0.003, 0.003);
  return fmt::format(
      "  calibration: {{width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5, distortion: "
      "[{}, {}, {}, {}, 0]}}\n",
      yaml_number(k1), yaml_number(k2), yaml_number(p1), yaml_number(p2));
}

}  // namespace uniquadric
