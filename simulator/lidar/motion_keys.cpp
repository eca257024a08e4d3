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

// The motion at every sixteenth of the window: looking it up is what takes the time.
struct Probes {
  static constexpr int kCount = 16;
  std::array<Pose, kCount + 1> poses;
  double radius_m;

  explicit Probes(const Window& window) : radius_m(window.radius_m) {
    for (int i = 0; i <= kCount; ++i) poses[i] = window.at(double{1} * i / kCount);
  }
};

// The distance of a point at the radius from where it belongs, taken at the middle between two keys, where it
// is largest, and at the quarters for motions that are odd about the middle.
double chord_error(const Probes& probes, int from, int to, bool slerp) {
  const Pose &a = probes.poses[from], &b = probes.poses[to];
  double worst = 0;
  for (int quarter = 1; quarter < 4; ++quarter) {
    const double u = quarter / 4.0;
    const Pose& is = probes.poses[from + quarter * (to - from) / 4];
    const Eigen::Matrix3d meant =
        slerp ? interpolate(a, b, u).rotation.toRotationMatrix()
              : Eigen::Matrix3d((1 - u) * a.rotation.toRotationMatrix() + u * b.rotation.toRotationMatrix());
    const Eigen::Vector3d shift = a.translation + u * (b.translation - a.translation) - is.translation;
    // The Frobenius norm over sqrt 2 of a small turn's matrix is its angle.
    const double turn = (meant - is.rotation.toRotationMatrix()).norm() / std::sqrt(2);
    worst = std::max(worst, shift.norm() + turn * probes.radius_m);
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
int pieces_for(const Probes& probes, double tolerance_m, bool slerp) {
  constexpr int kChords = 4, kStep = Probes::kCount / kChords;
  if (chord_error(probes, 0, Probes::kCount, slerp) <= tolerance_m) return 1;
  double worst = 0;
  for (int i = 0; i < kChords; ++i)
    worst = std::max(worst, chord_error(probes, i * kStep, (i + 1) * kStep, slerp));
  return static_cast<int>(
      std::clamp(std::ceil(kChords * std::sqrt(worst / tolerance_m)), 2.0, double{kMostPieces}));
}

}  // namespace

MotionKeys motion_keys_for(const Motion& motion, std::int64_t start_ns, std::int64_t end_ns, double radius_m,
                           double tolerance_m) {
  constexpr int kCostOfSlerp = 10;  // times that of a matrix, to place
  const Window window{motion, static_cast<double>(start_ns) * 1e-9,
                      static_cast<double>(end_ns - start_ns) * 1e-9, radius_m};
  if (is_at_rest(window)) return {1, true};
  const Probes probes(window);
  const int slerps = pieces_for(probes, tolerance_m, true), matrices = pieces_for(probes, tolerance_m, false);
  const bool slerp = slerps * kCostOfSlerp <= matrices || (matrices == kMostPieces && slerps < matrices);
  return {1 + (slerp ? slerps : matrices), slerp};
}

}  // namespace uniquadric
