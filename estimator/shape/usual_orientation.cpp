#include "estimator/shape/usual_orientation.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "core/base/quantile.h"
#include "core/geometry/box_symmetry.h"
#include "core/geometry/pose.h"

namespace uniquadric {
namespace {

constexpr double kFar = 0.3;     // [rad], beyond which a box is another face's
constexpr double kOneBox = 0.1;  // [rad], scatter of boxes of which there are too few to tell

Eigen::Quaterniond named_as(const Eigen::Quaterniond& box, const Eigen::Quaterniond& reference) {
  const Eigen::Matrix3d R = box.toRotationMatrix();
  return Eigen::Quaterniond(R * nearest_box_rotation(R, reference.toRotationMatrix())).normalized();
}

Eigen::Quaterniond medoid(const std::deque<Eigen::Quaterniond>& boxes) {
  Eigen::Quaterniond best = boxes.front();
  double least = std::numeric_limits<double>::infinity();
  for (const auto& a : boxes) {
    double sum = 0;
    for (const auto& b : boxes) sum += std::min(kFar, a.angularDistance(named_as(b, a)));
    if (sum < least) {
      least = sum;
      best = a;
    }
  }
  return best;
}

}  // namespace

std::optional<UsualOrientation> usual_orientation(const std::deque<Eigen::Quaterniond>& boxes) {
  if (boxes.empty()) return std::nullopt;
  const Eigen::Quaterniond center = medoid(boxes);
  std::array<std::vector<double>, 3> turns;
  for (const auto& box : boxes) {
    const Eigen::Vector3d turn = log_so3(center.conjugate() * named_as(box, center));
    for (int k = 0; k < 3; ++k) turns[k].push_back(turn[k]);
  }
  UsualOrientation usual;
  Eigen::Vector3d shift;
  const double few = kOneBox / static_cast<double>(boxes.size());
  for (int k = 0; k < 3; ++k) {
    shift[k] = quantile(turns[k], 0.5);
    for (double& turn : turns[k]) turn = std::abs(turn - shift[k]);
    usual.sigma_rad[k] = kMadToSigma * quantile(turns[k], 0.5) + few;
  }
  usual.rotation = (center * exp_so3(shift)).normalized();
  return usual;
}

UsualOrientation updated_orientation(const Eigen::Quaterniond& before, double sigma_rad,
                                     const UsualOrientation& boxes) {
  const Eigen::Matrix3d R = boxes.rotation.toRotationMatrix();
  const Eigen::Matrix3d P = nearest_box_rotation(R, before.toRotationMatrix());
  const Eigen::Vector3d turn = log_so3(before.conjugate() * Eigen::Quaterniond(R * P));
  const Eigen::Array3d variance = (P.cwiseAbs().transpose() * boxes.sigma_rad).array().square();
  const Eigen::Array3d gain = sigma_rad * sigma_rad / (sigma_rad * sigma_rad + variance);
  return {(before * exp_so3(gain.matrix().cwiseProduct(turn))).normalized(),
          (gain * variance).sqrt().matrix()};
}

}  // namespace uniquadric
