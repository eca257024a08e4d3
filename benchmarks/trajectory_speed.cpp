// Loading two TUM trajectories and their APE after alignment, processor time, best of five runs.
// usage: trajectory_speed REF EST      prints "rmse_m seconds"; trajectory_speed.py compares it with Python.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <limits>

#include "evaluation/statistics/statistics.h"
#include "evaluation/trajectory_comparison.h"

int main(int argc, char** argv) {
  using namespace uniquadric;
  if (argc != 3) return 2;
  TrajectoryOptions options;
  options.alignment = AlignmentKind::se3;
  options.relations = {PoseRelation::ape};
  options.parts = {ErrorPart::translation};
  double best_s = std::numeric_limits<double>::infinity(), rmse_m = 0;
  for (int run = 0; run < 5; ++run) {
    const std::clock_t start = std::clock();
    const TrajectoryComparison comparison = compare_trajectories(argv[1], argv[2], options);
    rmse_m = statistics(comparison.errors.front().values)->rmse;
    best_s = std::min(best_s, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  fmt::print("{} {}\n", rmse_m, best_s);
}
