#include <algorithm>
#include <array>
#include <cmath>

#include "simulator/lidar/ray_caster.h"

namespace uniquadric {
namespace {

struct Window {
  const Motion& motion;
  double start_s, length_s, radius_m;

  Pose at(double share) const { return motion.at(start_s + share * length_s); }
};

// The distance of a point at the radius from where it belongs, taken at the middle between two keys, where it
// is largest, and at the quarters for motions that are odd about the middle.
double chord_error(const Window& window, double from, double to, bool slerp) {
  const Pose a = window.at(from), b = window.at(to);
  double worst = 0;
  for (const double u : {0.25, 0.5, 0.75}) {
    const Pose is = window.at(from + u * (to - from));
    const Eigen::Matrix3d meant =
        slerp ? interpolate(a, b, u).rotation.toRotationMatrix()
              : Eigen::Matrix3d((1 - u) * a.rotation.toRotationMatrix() + u * b.rotation.toRotationMatrix());
    const Eigen::Vector3d shift = a.translation + u * (b.translation - a.translation) - is.translation;
    // The Frobenius norm over sqrt 2 of a small turn's matrix is its angle.
    const double turn = (meant - is.rotation.toRotationMatrix()).norm() / std::sqrt(2);
    worst = std::max(worst, shift.norm() + turn * window.radius_m);
  }
  return worst;
}

bool is_at_rest(const Window& window) {
  constexpr double kRest_m = 1e-12;
  const Pose first = window.at(0);
  const std::array<double, 4> places = {0.21, 0.5, 0.83, 1};
  return std::all_of(places.begin(), places.end(), [&](double u) {
    const Pose pose = window.at(u);
    return (pose.translation - first.translation).norm() +
               log_so3(first.rotation.conjugate() * pose.rotation).norm() * window.radius_m <
           kRest_m;
  });
}

constexpr int kMostPieces = 128;

// The error of a chord falls with the square of its length: measured on a few, extrapolated to as many as it
// takes.
int pieces_for(const Window& window, double tolerance_m, bool slerp) {
  constexpr int kProbes = 4;
  if (chord_error(window, 0, 1, slerp) <= tolerance_m) return 1;
  double worst = 0;
  for (int i = 0; i < kProbes; ++i)
    worst =
        std::max(worst, chord_error(window, double{1} * i / kProbes, double{1} * (i + 1) / kProbes, slerp));
  return static_cast<int>(
      std::clamp(std::ceil(kProbes * std::sqrt(worst / tolerance_m)), 2.0, double{kMostPieces}));
}

}  // namespace

MotionKeys motion_keys_for(const Motion& motion, std::int64_t start_ns, std::int64_t end_ns, double radius_m,
                           double tolerance_m) {
  constexpr int kCostOfSlerp = 10;  // times that of a matrix, to place
  const Window window{motion, static_cast<double>(start_ns) * 1e-9,
                      static_cast<double>(end_ns - start_ns) * 1e-9, radius_m};
  if (is_at_rest(window)) return {1, true};
  const int slerps = pieces_for(window, tolerance_m, true), matrices = pieces_for(window, tolerance_m, false);
  const bool slerp = slerps * kCostOfSlerp <= matrices || (matrices == kMostPieces && slerps < matrices);
  return {1 + (slerp ? slerps : matrices), slerp};
}

}  // namespace uniquadric
