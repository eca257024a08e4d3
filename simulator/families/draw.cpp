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

std::string drawn_material(RandomStream& random, double difficulty) {
  const auto color = [&] {
    return Eigen::Vector3d{random.uniform(0.1, 0.9), random.uniform(0.1, 0.9), random.uniform(0.1, 0.9)};
  };
  const std::string style = one_of<std::string>(random, {"panels", "checks", "speckle", "strokes"});
  const double contrast = graded(difficulty, 0.6, 0.1) * random.uniform(0.7, 1.3);
  const double marks = graded(difficulty, 8, 1) * random.uniform(0.7, 1.3);
  const Eigen::Vector3d base = color(), accent = color();
  return fmt::format("{{style: {}, color: {}, accent: {}, contrast: {}, marks: {}}}", style,
                     yaml_vector(base, 2), yaml_vector(accent, 2), yaml_number(contrast, 2),
                     std::max(1, static_cast<int>(std::lround(marks))));
}

}  // namespace uniquadric
