// What the long window's factors make of a body's outlines from an arc of views: intersection over union with
// the true inscribed ellipsoid, median over trials (docs/shape.md shows the tables).
// usage: outline_arc [TRIALS]
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/estimator/arc_scenario.h"

namespace {

using namespace uniquadric;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

void print_row(const HullBody& body, const ArcOptions& options, const std::string& name, int trials) {
  std::vector<double> iou, rotation, milliseconds;
  ArcResult last;
  for (int trial = 0; trial < trials; ++trial) {
    last = run_arc(body, options, trial);
    iou.push_back(last.iou);
    rotation.push_back(last.rotation_error_rad);
    milliseconds.push_back(last.milliseconds);
  }
  fmt::print(
      "{:12} {:28} iou {:.3f} (least {:.3f}) rotation {:.3f} rad, axes {:.2f} {:.2f} {:.2f} q {:.2f} {:.2f} "
      "{:.2f}, {:.1f} ms\n",
      body.name, name, median(iou), *std::min_element(iou.begin(), iou.end()), median(rotation),
      last.axis_ratio.x(), last.axis_ratio.y(), last.axis_ratio.z(), last.exponents.outline,
      last.exponents.upper, last.exponents.lower, median(milliseconds));
}

}  // namespace

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::atoi(argv[1]) : 9;
  for (const HullBody& body : arc_bodies()) {
    for (const int directions : {4, 8, 16, 32}) {
      ArcOptions options;
      options.directions = directions;
      print_row(body, options, fmt::format("{} tangents, hard", directions), trials);
    }
    ArcOptions soft;
    soft.hard = false;
    print_row(body, soft, "16 tangents, soft", trials);
    for (const int exponents : {1, 3})
      for (const bool sides : {false, true})
        for (const double arc_rad : {0.698, 1.571}) {
          ArcOptions options;
          options.exponents = exponents;
          options.sides = sides;
          options.arc_rad = arc_rad;
          print_row(
              body, options,
              fmt::format("{} exp, {} deg{}", exponents, arc_rad > 1 ? 90 : 40, sides ? ", 3 sides" : ""),
              trials);
        }
    ArcOptions quadric;
    quadric.exponents = 0;
    print_row(body, quadric, "16 tangents, q = 2", trials);
    quadric.directions = 4;
    quadric.conic = true;
    print_row(body, quadric, "conic of the RotBbox", trials);
    quadric.noise_px = 1e-3;
    quadric.drift_m = quadric.drift_rad = 0;
    quadric.arc_rad = 6.03;
    print_row(body, quadric, "the same, no noise, 360 deg", trials);
  }
}
