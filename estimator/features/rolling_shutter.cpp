#include "estimator/features/rolling_shutter.h"

#include <Eigen/Cholesky>

namespace uniquadric {
namespace {

using Matrix12d = Eigen::Matrix<double, 12, 12>;
using Vector12d = Eigen::Matrix<double, 12, 1>;
constexpr int kSteps = 5;
constexpr double kConverged_px = 1e-4;
constexpr double kCauchySigmas = 2;  // where a residual's weight halves

// Adds one sighting's equations: the twist's Jacobian of the pixel is the pose's, times the delay.
void add_equations(const PointSighting& sighting, double delay_s, const Camera& camera, const Pose& pose,
                   const Vector6d& twist_change, double pixel_sigma, Matrix12d& H, Vector12d& g) {
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, 6> by_pose;
  if (!sighting_residual(sighting, camera, pose, pixel_sigma, &r, &by_pose)) return;
  Eigen::Matrix<double, 3, 12> J = Eigen::Matrix<double, 3, 12>::Zero();
  J.leftCols<6>() = by_pose;
  J.topRightCorner<2, 6>() = delay_s * by_pose.topRows<2>();
  r.head<2>() += J.topRightCorner<2, 6>() * twist_change;
  constexpr double kSquare = kCauchySigmas * kCauchySigmas;
  const double pixel_weight = 1 / (1 + r.head<2>().squaredNorm() / kSquare);
  const Eigen::Vector3d w(pixel_weight, pixel_weight, 1 / (1 + r[2] * r[2] / kSquare));
  H += J.transpose() * w.asDiagonal() * J;
  g += J.transpose() * w.cwiseProduct(r);
}

}  // namespace

double RollingShutter::delay_s(double row) const {
  return readout_s_ * ((row + 0.5) / lens_.height - 0.5);
}

std::optional<Eigen::Vector2d> RollingShutter::seen_at(const Eigen::Vector3d& point,
                                                       const Vector6d& twist) const {
  auto pixel = lens_.project(point);
  for (int i = 0; pixel && is_on() && i < kSteps; ++i) {
    const auto next = lens_.project(exp_se3(delay_s(pixel->y()) * twist) * point);
    const bool is_settled = next && (*next - *pixel).norm() < kConverged_px;
    pixel = next;
    if (is_settled) break;
  }
  return pixel;
}

std::optional<Eigen::Vector2d> RollingShutter::at_stamp(const Eigen::Vector2d& pixel, double depth_m,
                                                        const Vector6d& twist) const {
  const Pose at_exposure = exp_se3(delay_s(pixel.y()) * twist);
  Eigen::Vector2d place = pixel;
  for (int i = 0; is_on() && i < kSteps; ++i) {
    const auto ray = lens_.unproject(place);
    const auto seen = ray ? lens_.project(at_exposure * Eigen::Vector3d(depth_m * *ray)) : std::nullopt;
    if (!seen) return std::nullopt;
    const Eigen::Vector2d step = pixel - *seen;
    place += step;
    if (step.norm() < kConverged_px) break;
  }
  return place;
}

std::optional<MovingPose> fit_moving_pose(const std::vector<PointSighting>& sightings,
                                          const std::vector<double>& delays_s, const Camera& camera,
                                          const MovingPose& start, const Vector6d& expected,
                                          double pixel_sigma, const RollingShutterOptions& options) {
  Vector6d information;
  information << Eigen::Vector3d::Constant(1 / (options.velocity_sigma_mps * options.velocity_sigma_mps)),
      Eigen::Vector3d::Constant(1 / (options.turn_sigma_radps * options.turn_sigma_radps));
  MovingPose fit = start;
  for (int step = 0; step < kSteps; ++step) {
    Matrix12d H = Matrix12d::Zero();
    Vector12d g = Vector12d::Zero();
    H.diagonal().tail<6>() = information;
    g.tail<6>() = information.cwiseProduct(fit.twist - expected);
    for (std::size_t i = 0; i < sightings.size(); ++i)
      add_equations(sightings[i], delays_s[i], camera, fit.camera_from_body, fit.twist - start.twist,
                    pixel_sigma, H, g);
    const Eigen::LDLT<Matrix12d> solver(H);
    if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return std::nullopt;
    const Vector12d change = -solver.solve(g);
    if (!change.allFinite()) return std::nullopt;
    fit.camera_from_body = exp_se3(change.head<6>()) * fit.camera_from_body;
    fit.camera_from_body.rotation.normalize();
    fit.twist += change.tail<6>();
  }
  return fit;
}

}  // namespace uniquadric
