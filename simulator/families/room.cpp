#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "simulator/families/families.h"

namespace uniquadric {

// A walk around the middle of a furnished room that looks at its walls: nothing in it moves.
std::string room_scene(RandomStream& random, const FamilyOptions& options) {
  const double widest_m = graded(options.difficulty, 5.5, 7);
  const double width_m = random.uniform(4, widest_m), depth_m = random.uniform(4, widest_m);
  const double duration_s = options.camera_s();
  const double turn_deg = graded(options.difficulty, 8, 45) * duration_s * (random.below(2) ? 1 : -1);
  const double begin_deg = random.uniform(-180, 180);
  const int points = 3 + static_cast<int>(std::abs(turn_deg) / 20);
  std::string text =
      "camera:\n" + options.lens + "  motion:\n    kind: spline\n    may_overshoot: true\n    waypoints:\n";
  for (int i = 0; i <= points; ++i) {
    const double share = (i - 0.5) / (points - 1);
    const double angle = (begin_deg + share * turn_deg) * std::numbers::pi / 180;
    const Eigen::Vector3d at{0.15 * width_m * std::cos(angle) * random.uniform(0.8, 1.2),
                             0.15 * depth_m * std::sin(angle) * random.uniform(0.8, 1.2),
                             random.uniform(1.2, 1.6)};
    const Eigen::Vector3d ahead(0.5 * width_m * std::cos(angle), 0.5 * depth_m * std::sin(angle),
                                random.uniform(0.7, 1.3));
    text += fmt::format("      - {{time_s: {}, position_m: {}, look_at_m: {}}}\n",
                        yaml_number(share * duration_s, 2), yaml_vector(at), yaml_vector(ahead));
  }
  const std::uint32_t seed = random.below(100'000), furniture = 4 + random.below(9);
  const double contrast = graded(options.difficulty, 0.6, 0.1) * random.uniform(0.7, 1.3);
  const double marks = graded(options.difficulty, 24, 6) * random.uniform(0.7, 1.3);
  text += fmt::format(
      "world:\n  - {{name: room, primitive: room, size_m: [{}, {}, 3], furniture: {}, material: {{seed: {}, "
      "contrast: {}, marks: {}}}}}\n",
      yaml_number(width_m), yaml_number(depth_m), furniture, seed, yaml_number(contrast, 2),
      std::lround(marks));
  return text;
}

}  // namespace uniquadric
