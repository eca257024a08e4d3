#include "estimator/plausibility/self_calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr int kIterations = 15;
constexpr double kPixelSigma = 0.4;    // of a followed corner [px]
constexpr double kDepthFloor = 0.002;  // of a depth, relative, besides its own sigma
constexpr double kGateSigmas = 4;      // of the residuals' own scatter
constexpr double kStep = 1e-5;         // of numeric derivatives

using Vector4d = Eigen::Vector4d;
using Row10 = Eigen::Matrix<double, 3, 10>;

struct Intrinsics {
  double fx, fy, cx, cy;
};

Intrinsics changed(const Camera& camera, const Vector4d& change) {
  return {camera.fx * std::exp(change[0]), camera.fy * std::exp(change[1]), camera.cx + change[2],
          camera.cy + change[3]};
}

// Pixel and depth of the point in b less those that were seen, in sigmas.
Eigen::Vector3d residual(const PointPair& point, const Intrinsics& k, const Pose& b_from_a) {
  const Eigen::Vector3d ray((point.a.x() - k.cx) / k.fx, (point.a.y() - k.cy) / k.fy, 1);
  const Eigen::Vector3d p = b_from_a * (point.depth_a_m * ray);
  const double z = std::max(p.z(), 0.01);
  const double sigma_m = std::hypot(point.sigma_a_m, point.sigma_b_m) + kDepthFloor * point.depth_b_m;
  return {(k.fx * p.x() / z + k.cx - point.b.x()) / kPixelSigma,
          (k.fy * p.y() / z + k.cy - point.b.y()) / kPixelSigma, (p.z() - point.depth_b_m) / sigma_m};
}

// By the intrinsics, then by a left perturbation of the pose.
Row10 jacobian(const Camera& camera, const PointPair& point, const Vector4d& change, const Pose& pose) {
  Row10 J;
  for (int i = 0; i < 10; ++i) {
    const auto at = [&](double step) {
      Vector4d moved = change;
      Vector6d xi = Vector6d::Zero();
      if (i < 4)
        moved[i] += i < 2 ? step : 100 * step;
      else
        xi[i - 4] = step;
      return residual(point, changed(camera, moved), exp_se3(xi) * pose);
    };
    J.col(i) = (at(kStep) - at(-kStep)) / (2 * (i == 2 || i == 3 ? 100 : 1) * kStep);
  }
  return J;
}

struct PairState {
  std::vector<const PointPair*> points;
  Pose b_from_a;
};

// The points that lie within the scatter of most.
std::vector<const PointPair*> gated(const Camera& camera, const PairState& pair, const Vector4d& change) {
  std::vector<double> norms;
  for (const PointPair* point : pair.points)
    norms.push_back(residual(*point, changed(camera, change), pair.b_from_a).norm());
  const double gate = kGateSigmas * std::max(1.0, quantile(norms, 0.5));
  std::vector<const PointPair*> kept;
  for (std::size_t i = 0; i < norms.size(); ++i)
    if (norms[i] <= gate) kept.push_back(pair.points[i]);
  return kept;
}

struct Sums {
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
  Vector4d g = Vector4d::Zero();
  double cost = 0;
  double count = 0;
};

struct PairSums {
  Eigen::Matrix<double, 10, 10> H = Eigen::Matrix<double, 10, 10>::Zero();
  Eigen::Matrix<double, 10, 1> g = Eigen::Matrix<double, 10, 1>::Zero();
};

PairSums sums_of(const Camera& camera, const PairState& pair, const Vector4d& change, Sums& all) {
  PairSums sums;
  for (const PointPair* point : gated(camera, pair, change)) {
    const Eigen::Vector3d r = residual(*point, changed(camera, change), pair.b_from_a);
    const double weight = 1 / (1 + r.squaredNorm() / 9);
    const Row10 J = jacobian(camera, *point, change, pair.b_from_a);
    sums.H += weight * J.transpose() * J;
    sums.g += weight * J.transpose() * r;
    all.cost += weight * r.squaredNorm();
    all.count += 3;
  }
  return sums;
}

}  // namespace

std::optional<SelfCalibration> self_calibrate(const Camera& camera,
                                              const std::vector<const FramePair*>& pairs) {
  std::vector<PairState> states;
  for (const FramePair* pair : pairs) {
    PairState& state = states.emplace_back();
    state.b_from_a = *pair->b_from_a;
    for (const PointPair& point : pair->points)
      if (point.depth_a_m > 0 && point.depth_b_m > 0) state.points.push_back(&point);
  }
  Vector4d change = Vector4d::Zero();
  Sums all;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    all = {};
    std::vector<PairSums> sums;
    for (const PairState& state : states) {
      const PairSums& s = sums.emplace_back(sums_of(camera, state, change, all));
      const Eigen::Matrix<double, 6, 4> by_pose = s.H.block<6, 6>(4, 4).ldlt().solve(s.H.block<6, 4>(4, 0));
      all.H += s.H.topLeftCorner<4, 4>() - s.H.block<4, 6>(0, 4) * by_pose;
      all.g += s.g.head<4>() - by_pose.transpose() * s.g.tail<6>();
    }
    Vector4d step = -all.H.ldlt().solve(all.g);
    if (!step.allFinite()) return std::nullopt;
    step.head<2>() = step.head<2>().cwiseMax(-0.2).cwiseMin(0.2);
    change += step;
    for (std::size_t i = 0; i < states.size(); ++i) {
      const Vector6d xi =
          -sums[i].H.block<6, 6>(4, 4).ldlt().solve(sums[i].g.tail<6>() + sums[i].H.block<6, 4>(4, 0) * step);
      if (!xi.allFinite()) return std::nullopt;
      states[i].b_from_a = exp_se3(xi) * states[i].b_from_a;
      states[i].b_from_a.rotation.normalize();
    }
  }
  if (all.count < 1) return std::nullopt;
  const Eigen::Matrix4d covariance = all.H.inverse() * std::max(1.0, all.cost / all.count);
  if (!covariance.allFinite()) return std::nullopt;
  return SelfCalibration{change[0], change[1], change[2], change[3],
                         covariance.diagonal().cwiseAbs().cwiseSqrt()};
}

}  // namespace uniquadric
