#include "estimator/images/rigid_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
constexpr int kLocalSteps = 3;  // of a new best sample, enough to judge it
constexpr int kFinalSteps = 10;
constexpr double kCauchySigmas = 2;       // where a residual's weight halves
constexpr double kPriorGates = 4;         // a prior is judged this much more leniently before it is refined
constexpr double kMinBaseline_m2 = 1e-6;  // twice the area of a triangle of points worth a hypothesis

bool is_inlier(const PointSighting& s, const Camera& camera, const Pose& pose,
               const RigidMotionOptions& options) {
  Eigen::Vector3d r;
  if (!sighting_residual(s, camera, pose, 1, &r, nullptr)) return false;
  if (r.head<2>().norm() > options.pixel_gate) return false;
  return s.depth_m <= 0 ||
         std::abs(r[2]) * s.depth_sigma_m < options.depth_gate * s.depth_sigma_m + options.depth_slack_m;
}

RigidMotion judged(const std::vector<PointSighting>& sightings, const Camera& camera, const Pose& pose,
                   const RigidMotionOptions& options) {
  RigidMotion result;
  result.camera_from_body = pose;
  result.inlier.reserve(sightings.size());
  for (const auto& s : sightings) {
    result.inlier.push_back(is_inlier(s, camera, pose, options));
    result.inliers += result.inlier.back();
  }
  return result;
}

// Iteratively reweighted Gauss-Newton over the inliers.
void refine(const std::vector<PointSighting>& sightings, const Camera& camera,
            const RigidMotionOptions& options, int steps, RigidMotion& fit) {
  for (int step = 0; step < steps; ++step) {
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      Eigen::Vector3d r;
      Eigen::Matrix<double, 3, 6> J;
      if (!fit.inlier[i] ||
          !sighting_residual(sightings[i], camera, fit.camera_from_body, options.pixel_sigma, &r, &J))
        continue;
      const double pixel_weight = 1 / (1 + r.head<2>().squaredNorm() / (kCauchySigmas * kCauchySigmas));
      const double depth_weight = 1 / (1 + r[2] * r[2] / (kCauchySigmas * kCauchySigmas));
      const Eigen::Vector3d w(pixel_weight, pixel_weight, depth_weight);
      H += J.transpose() * w.asDiagonal() * J;
      g += J.transpose() * w.cwiseProduct(r);
    }
    const Eigen::LDLT<Matrix6d> solver(H);
    if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return;
    const Vector6d xi = -solver.solve(g);
    if (!xi.allFinite()) return;
    fit.camera_from_body = exp_se3(xi) * fit.camera_from_body;
    fit.camera_from_body.rotation.normalize();
    fit.information = H;
    if (xi.norm() < 1e-9) return;
  }
}

std::optional<Pose> through_three(const std::array<PointSighting, 3>& s, const Camera& camera) {
  Eigen::Matrix3d body, seen;
  for (int i = 0; i < 3; ++i) {
    body.col(i) = s[i].point;
    seen.col(i) = s[i].depth_m * ideal_ray(camera, s[i].pixel);
  }
  const Eigen::Vector3d a = body.col(1) - body.col(0), b = body.col(2) - body.col(0);
  if (a.cross(b).norm() < kMinBaseline_m2) return std::nullopt;
  const Eigen::Matrix4d T = Eigen::umeyama(body, seen, false);
  return Pose{Eigen::Quaterniond(Eigen::Matrix3d(T.topLeftCorner<3, 3>())), T.topRightCorner<3, 1>()};
}

}  // namespace

bool sighting_residual(const PointSighting& sighting, const Camera& camera, const Pose& camera_from_body,
                       double pixel_sigma, Eigen::Vector3d* residual, Eigen::Matrix<double, 3, 6>* jacobian) {
  const Eigen::Vector3d p = camera_from_body * sighting.point;
  if (!(p.z() > 0.01)) return false;
  const double iz = 1 / p.z();
  const double depth_weight = sighting.depth_m > 0 ? 1 / sighting.depth_sigma_m : 0;
  *residual << (camera.fx * p.x() * iz + camera.cx - sighting.pixel.x()) / pixel_sigma,
      (camera.fy * p.y() * iz + camera.cy - sighting.pixel.y()) / pixel_sigma,
      (p.z() - sighting.depth_m) * depth_weight;
  if (!jacobian) return true;
  Eigen::Matrix3d by_point;
  by_point << camera.fx * iz / pixel_sigma, 0, -camera.fx * p.x() * iz * iz / pixel_sigma,  //
      0, camera.fy * iz / pixel_sigma, -camera.fy * p.y() * iz * iz / pixel_sigma,          //
      0, 0, depth_weight;
  Eigen::Matrix3d minus_skew;
  minus_skew << 0, p.z(), -p.y(), -p.z(), 0, p.x(), p.y(), -p.x(), 0;
  *jacobian << by_point, by_point * minus_skew;
  return true;
}

std::optional<RigidMotion> fit_rigid_motion(const std::vector<PointSighting>& sightings, const Camera& camera,
                                            const std::optional<Pose>& prior,
                                            const RigidMotionOptions& options, RandomStream& random) {
  RigidMotion best;
  const auto consider = [&](const Pose& pose, const RigidMotionOptions& first) {
    RigidMotion candidate = judged(sightings, camera, pose, first);
    if (candidate.inliers < 3 || candidate.inliers <= best.inliers) return;
    refine(sightings, camera, options, kLocalSteps, candidate);
    candidate = judged(sightings, camera, candidate.camera_from_body, options);
    if (candidate.inliers > best.inliers) best = candidate;
  };
  if (prior) {
    RigidMotionOptions lenient = options;
    lenient.pixel_gate *= kPriorGates;
    lenient.depth_gate *= kPriorGates;
    consider(*prior, lenient);
  }
  std::vector<int> with_depth;
  for (std::size_t i = 0; i < sightings.size(); ++i)
    if (sightings[i].depth_m > 0) with_depth.push_back(static_cast<int>(i));
  const auto n = static_cast<std::uint32_t>(with_depth.size());
  // A prior that nearly all agree with leaves nothing to search for.
  const auto settled = [&] { return best.inliers > 0.9 * static_cast<double>(sightings.size()); };
  for (int i = 0; n >= 3 && i < options.iterations && !settled(); ++i) {
    const std::uint32_t a = random.below(n), b = random.below(n), c = random.below(n);
    if (a == b || b == c || a == c) continue;
    const auto pose =
        through_three({sightings[with_depth[a]], sightings[with_depth[b]], sightings[with_depth[c]]}, camera);
    if (pose) consider(*pose, options);
  }
  const double needed =
      std::max<double>(options.min_inliers, options.min_share * static_cast<double>(sightings.size()));
  if (best.inliers < needed) return std::nullopt;
  refine(sightings, camera, options, kFinalSteps, best);
  const Eigen::Matrix<double, 6, 6> information = best.information;
  best = judged(sightings, camera, best.camera_from_body, options);
  best.information = information;
  return best.inliers < needed ? std::nullopt : std::optional(best);
}

}  // namespace uniquadric
