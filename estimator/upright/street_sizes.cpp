#include "estimator/upright/street_sizes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace uniquadric {
namespace {

constexpr double kRestSpeed = 0.5;  // [m/s], sigma of that of a user who waits or parks
constexpr double kSpread = 0.15;    // of a class's sizes, share of the mean

struct StreetUser {
  Eigen::Vector3d size_m;
  double share, speed_mps, speed_sigma_mps;
};

const std::array<StreetUser, 6>& street_users() {
  static const std::array<StreetUser, 6> users = {{{{3.88, 1.63, 1.53}, 0.6, 9, 6},
                                                   {{5.07, 1.90, 2.21}, 0.1, 9, 6},
                                                   {{10.14, 2.59, 3.25}, 0.05, 9, 6},
                                                   {{16.17, 2.53, 3.53}, 0.02, 8, 6},
                                                   {{1.76, 0.60, 1.74}, 0.08, 4.5, 2},
                                                   {{0.84, 0.66, 1.76}, 0.15, 1.3, 0.6}}};
  return users;
}

// How badly that was seen of such a one, in squared sigmas.
double misfit(const StreetUser& user, const SeenSize& seen) {
  double sum = std::min(std::pow((seen.speed_mps - user.speed_mps) / user.speed_sigma_mps, 2),
                        std::pow(seen.speed_mps / kRestSpeed, 2));
  for (int axis = 0; axis < 3; ++axis) {
    double more_m = seen.size_m[axis] - user.size_m[axis];
    if (more_m < 0 && !seen.is_whole[axis]) continue;
    if (more_m < 0) more_m = std::min(0.0, more_m + seen.beyond_m[axis]);
    sum += more_m * more_m /
           (std::pow(kSpread * user.size_m[axis], 2) + seen.sigma_m[axis] * seen.sigma_m[axis]);
  }
  return sum;
}

}  // namespace

SizeBelief street_size(const SeenSize& seen) {
  std::array<double, 6> misfits{};
  for (std::size_t i = 0; i < misfits.size(); ++i) misfits[i] = misfit(street_users()[i], seen);
  const double least = *std::min_element(misfits.begin(), misfits.end());
  double all = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), square = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < misfits.size(); ++i) {
    const StreetUser& user = street_users()[i];
    const double weight =
        user.share * std::exp((least - misfits[i]) / 2) / user.size_m.prod() / user.speed_sigma_mps;
    all += weight;
    mean += weight * user.size_m;
    square += weight * (1 + kSpread * kSpread) * user.size_m.cwiseAbs2();
  }
  mean /= all;
  return {mean, (square / all - mean.cwiseAbs2()).cwiseSqrt(), least - 2 * std::log(all)};
}

}  // namespace uniquadric
