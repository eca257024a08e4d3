#include <algorithm>
#include <cmath>

#include "simulator/lidar/ray_caster.h"

namespace uniquadric {
namespace {

// The error of constant motion between two poses, seen at the middle where it is largest, and at the quarters
// for motions that are odd about the middle.
double chord_error(const Motion& motion, double from_s, double to_s, double radius_m) {
  const Pose a = motion.at(from_s), b = motion.at(to_s);
  double worst = 0;
  for (const double u : {0.25, 0.5, 0.75}) {
    const Pose meant = interpolate(a, b, u), is = motion.at(from_s + u * (to_s - from_s));
    const double turned = log_so3(meant.rotation.conjugate() * is.rotation).norm();
    worst = std::max(worst, (meant.translation - is.translation).norm() + turned * radius_m);
  }
  return worst;
}

}  // namespace

int motion_keys_for(const Motion& motion, std::int64_t start_ns, std::int64_t end_ns, double radius_m,
                    double tolerance_m) {
  constexpr int kMostPieces = 128;
  constexpr double kRest_m = 1e-12;
  const double start_s = static_cast<double>(start_ns) * 1e-9, end_s = static_cast<double>(end_ns) * 1e-9;
  const Pose first = motion.at(start_s);
  const auto moved_from_first = [&](double u) {
    const Pose pose = motion.at(start_s + u * (end_s - start_s));
    return (pose.translation - first.translation).norm() +
           log_so3(first.rotation.conjugate() * pose.rotation).norm() * radius_m;
  };
  const std::array<double, 4> places = {0.21, 0.5, 0.83, 1};
  if (std::all_of(places.begin(), places.end(), [&](double u) { return moved_from_first(u) < kRest_m; }))
    return 1;
  int pieces = 1;
  for (; pieces < kMostPieces; pieces *= 2) {
    double worst = 0;
    for (int i = 0; i < pieces && worst <= tolerance_m; ++i)
      worst = std::max(worst, chord_error(motion, start_s + (end_s - start_s) * i / pieces,
                                          start_s + (end_s - start_s) * (i + 1) / pieces, radius_m));
    if (worst <= tolerance_m) break;
  }
  return pieces + 1;
}

}  // namespace uniquadric
