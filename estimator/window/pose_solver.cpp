#include "estimator/window/pose_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "estimator/observation/ideal_ray.h"
#include "estimator/window/normal_equations.h"

namespace uniquadric {
namespace {

constexpr double kConvergedStep = 1e-7;  // [m], [rad]
constexpr double kMinDepth = 1e-3;       // [m]; nearer points have no usable projection
constexpr double kLeastRcond = 1e-10;    // of the normal equations; below, some motion is free
constexpr double kMinTriangle = 1e-2;    // sine of the angle of three points that give a candidate

// Geman-McClure weights: a wrong track has no pull at all, however wrong it is.
NormalEquations accumulate(const Camera& camera, const std::vector<LandmarkSighting>& sightings,
                           const Pose& pose, const PoseSolverOptions& options, double scale) {
  NormalEquations sum;
  for (const LandmarkSighting& s : sightings) {
    const LinearisedSighting l = linearise(camera, s, pose, options.pixel_sigma_px);
    if (!l.valid) continue;
    const double ratio = l.residual.squaredNorm() / (scale * scale);
    const double weight = 1 / ((1 + ratio) * (1 + ratio));
    sum.information += weight * l.by_pose.transpose() * l.by_pose;
    sum.gradient += weight * l.by_pose.transpose() * l.residual;
  }
  return sum;
}

std::vector<bool> inliers_of(const Camera& camera, const std::vector<LandmarkSighting>& sightings,
                             const Pose& pose, const PoseSolverOptions& options) {
  std::vector<bool> inliers;
  for (const LandmarkSighting& s : sightings) inliers.push_back(is_inlier(camera, s, pose, options));
  return inliers;
}

std::optional<Pose> umeyama(const std::vector<LandmarkSighting>& sightings, const Camera& camera,
                            const std::array<std::uint32_t, 3>& picks) {
  Eigen::Matrix3d body, seen;
  for (int i = 0; i < 3; ++i) {
    const LandmarkSighting& s = sightings[picks[i]];
    body.col(i) = s.point_in_body;
    seen.col(i) = s.depth_m * ideal_ray(camera, s.pixel);
  }
  const Eigen::Vector3d a = body.col(1) - body.col(0), b = body.col(2) - body.col(0);
  if (a.cross(b).norm() < kMinTriangle * a.norm() * b.norm()) return std::nullopt;
  const Eigen::Matrix4d T = Eigen::umeyama(body, seen, false);
  Pose pose;
  pose.rotation = Eigen::Quaterniond(Eigen::Matrix3d(T.topLeftCorner<3, 3>())).normalized();
  pose.translation = T.topRightCorner<3, 1>();
  return pose;
}

}  // namespace

LinearisedSighting linearise(const Camera& camera, const LandmarkSighting& s, const Pose& camera_from_body,
                             double pixel_sigma_px) {
  LinearisedSighting result;
  const Eigen::Matrix3d R = camera_from_body.rotation.toRotationMatrix();
  const Eigen::Vector3d p = R * s.point_in_body + camera_from_body.translation;
  if (p.z() < kMinDepth) return result;
  const double inverse_z = 1 / p.z();
  Eigen::Matrix3d by_point;
  by_point << camera.fx * inverse_z, 0, -camera.fx * p.x() * inverse_z * inverse_z,  //
      0, camera.fy * inverse_z, -camera.fy * p.y() * inverse_z * inverse_z,          //
      0, 0, 1;
  result.residual << camera.fx * p.x() * inverse_z + camera.cx - s.pixel.x(),
      camera.fy * p.y() * inverse_z + camera.cy - s.pixel.y(), p.z() - s.depth_m;
  const double pixel_weight = 1 / std::hypot(pixel_sigma_px, camera.fx * inverse_z * s.point_sigma_m);
  const double depth_weight = s.depth_m > 0 ? 1 / std::hypot(s.depth_sigma_m, s.point_sigma_m) : 0;
  const Eigen::Vector3d weights(pixel_weight, pixel_weight, depth_weight);
  result.by_point = weights.asDiagonal() * by_point * R;
  result.by_pose << result.by_point, -result.by_point * skew(s.point_in_body);
  result.residual = weights.cwiseProduct(result.residual);
  result.valid = true;
  return result;
}

bool is_inlier(const Camera& camera, const LandmarkSighting& sighting, const Pose& camera_from_body,
               const PoseSolverOptions& options) {
  const LinearisedSighting l = linearise(camera, sighting, camera_from_body, options.pixel_sigma_px);
  return l.valid && l.residual.cwiseAbs().maxCoeff() < options.gate_sigmas;
}

std::optional<PoseSolution> solve_pose(const Camera& camera, const std::vector<LandmarkSighting>& sightings,
                                       const Pose& predicted, const PoseSolverOptions& options) {
  Pose pose = predicted;
  // The robust scale shrinks from wide, where a prediction some pixels off still pulls, to the gate's width.
  for (const double scale : {8 * options.gate_sigmas, options.gate_sigmas}) {
    for (int i = 0; i < options.iterations; ++i) {
      const NormalEquations equations = accumulate(camera, sightings, pose, options, scale);
      const Eigen::LDLT<Matrix6d> solver(equations.information);
      if (solver.info() != Eigen::Success || !(solver.rcond() > kLeastRcond)) return std::nullopt;
      const Vector6d step = -solver.solve(equations.gradient);
      pose = perturbed(pose, step);
      if (step.norm() < kConvergedStep) break;
    }
  }
  PoseSolution solution;
  solution.camera_from_body = pose;
  solution.inliers = inliers_of(camera, sightings, pose, options);
  solution.inlier_count =
      static_cast<int>(std::count(solution.inliers.begin(), solution.inliers.end(), true));
  if (solution.inlier_count < options.min_inliers) return std::nullopt;
  std::vector<LandmarkSighting> sure;
  std::copy_if(sightings.begin(), sightings.end(), std::back_inserter(sure),
               [](const LandmarkSighting& s) { return !s.rim; });
  solution.information = accumulate(camera, sure, pose, options, options.gate_sigmas).information;
  return solution;
}

std::optional<PoseSolution> find_pose(const Camera& camera, const std::vector<LandmarkSighting>& sightings,
                                      const PoseSolverOptions& options, RandomStream& random) {
  std::vector<LandmarkSighting> measured;
  for (const LandmarkSighting& s : sightings)
    if (s.depth_m > 0) measured.push_back(s);
  const auto n = static_cast<std::uint32_t>(measured.size());
  if (n < 3) return std::nullopt;
  PoseSolverOptions loose = options;  // three noisy points place the others a few sigmas off
  loose.gate_sigmas = 3 * options.gate_sigmas;
  std::optional<Pose> best;
  std::ptrdiff_t most = 0;
  for (int i = 0; i < options.ransac_iterations; ++i) {
    const std::array<std::uint32_t, 3> picks{random.below(n), random.below(n), random.below(n)};
    if (picks[0] == picks[1] || picks[1] == picks[2] || picks[0] == picks[2]) continue;
    const auto pose = umeyama(measured, camera, picks);
    if (!pose) continue;
    const auto inliers = inliers_of(camera, measured, *pose, loose);
    const auto count = std::count(inliers.begin(), inliers.end(), true);
    if (count > most) {
      most = count;
      best = pose;
    }
  }
  if (!best) return std::nullopt;
  return solve_pose(camera, sightings, *best, options);
}

}  // namespace uniquadric
