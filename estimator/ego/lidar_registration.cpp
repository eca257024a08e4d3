#include "estimator/ego/lidar_registration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace uniquadric {
namespace {

double square(double x) {
  return x * x;
}

constexpr int kNoiseStep = 8;  // every eighth point tells how much of what is told errors of normals make
constexpr double kLeastSigma_m = 0.005, kLeastSigma_rad = 0.0005;
constexpr int kOpenIterations = 2;  // in which the prediction's own error widens the gate

}  // namespace

PointSigmas point_sigmas(const LidarSightOptions& options, const LidarDataSheet& sensor) {
  return {std::max(options.range_sigma_m.value_or(sensor.range_sigma_m), kLeastSigma_m),
          std::max(options.beam_sigma_rad.value_or(sensor.beam_sigma_rad()), kLeastSigma_rad)};
}

LidarRegistration::LidarRegistration(const LidarMap& map, const std::vector<TimedPoint>& points,
                                     const SweepPath& path, const Pose& body_from_lidar, double voxel_m,
                                     const Matrix18d& prior, const PointSigmas& sigmas,
                                     const LidarSightOptions& options)
    : map_(map),
      points_(points),
      path_(path),
      body_from_lidar_(body_from_lidar),
      prior_(prior.topLeftCorner<6, 6>()),
      sigmas_(sigmas),
      options_(options),
      choice_(choose_points(points, voxel_m)) {
  for (const int i : choice_.point_of) {
    const TimedPoint& p = points[static_cast<std::size_t>(i)];
    const Eigen::Vector3d lidar = p.lidar.cast<double>();
    Sight sight;
    sight.point = path.place(p.stamp_ns, body_from_lidar * lidar);
    sight.range_m = lidar.norm();
    sight.beam_at_end = sight.point.end_from_then * (body_from_lidar.rotation * (lidar / sight.range_m));
    sights_.push_back(sight);
  }
}

// What a plane's own points are off it by, others are too: noise, and what is not flat.
double LidarRegistration::variance_of(const Sight& sight, const Eigen::Matrix3d& R) const {
  const double cosine2 = square(sight.plane->normal.dot(R * sight.beam_at_end));
  const double noise = square(sigmas_.range_m) * cosine2 +
                       square(sigmas_.beam_rad * sight.range_m) * (1 - cosine2) +
                       square(options_.plane_sigma_m);
  return std::max(noise, square(sight.plane->thickness_m)) + square(sight.plane->sigma_m);
}

void LidarRegistration::look(Sight& sight, const LidarState& state, const Eigen::Matrix3d& R,
                             int iteration) const {
  const Eigen::Vector3d& bias = path_.end().gyroscope_bias_radps;
  if (iteration < options_.searches) {
    const double noise = std::hypot(sigmas_.range_m, sigmas_.beam_rad * sight.range_m);
    const Eigen::Vector3d world = world_point(state, bias, sight.point);
    if (iteration == 0 || (world - sight.sought_at).norm() > options_.search_again_m) {
      sight.plane = map_.plane_near(world, {options_.max_thickness * noise, options_.min_breadth * noise});
      sight.sought_at = world;
    }
  }
  sight.is_off = false;
  if (!sight.plane) return;
  Row12d& J = sight.jacobian;
  sight.distance_m = plane_distance(state, bias, sight.point, *sight.plane, &J);
  sight.variance = variance_of(sight, R);
  const double predicted =
      iteration < kOpenIterations ? (J.head<6>() * prior_ * J.head<6>().transpose()).value() : 0;
  const double gate = std::clamp(options_.gate_sigmas * std::sqrt(sight.variance + predicted),
                                 options_.gate_m, std::max(options_.gate_m, options_.open_gate_m));
  sight.is_off = !(std::abs(sight.distance_m) <= gate);
}

int LidarRegistration::side_of(const Sight& sight) const {
  int side = 0;
  (sides_.transpose() * sight.plane->normal).cwiseAbs().maxCoeff(&side);
  return side;
}

// What a point facing each way counts.
std::array<double, 3> LidarRegistration::shares() const {
  std::array<double, 3> points{};
  for (const Sight& sight : sights_)
    if (counts(sight)) ++points[static_cast<std::size_t>(side_of(sight))];
  for (double& share : points) share = std::min(1.0, options_.side_points / std::max(share, 1.0));
  return points;
}

// The Jacobian's row is linear in the normal.
void LidarRegistration::add_noise(const Sight& sight, const LidarState& state, double weight,
                                  SightingSquare& noise) const {
  for (int k = 0; k < 2; ++k) {
    Row12d row = Row12d::Zero();
    plane_distance(state, path_.end().gyroscope_bias_radps, sight.point, {sight.plane->normal_error.col(k)},
                   &row);
    noise.noalias() += (weight * row.transpose()) * row;
  }
}

LidarNormal LidarRegistration::normal_at(const LidarState& state, int iteration) {
  const Eigen::Matrix3d R = state.world_from_body.rotation.toRotationMatrix();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (Sight& sight : sights_) {
    look(sight, state, R, iteration);
    if (counts(sight)) spread += sight.plane->normal * sight.plane->normal.transpose();
  }
  sides_ = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
  const auto share = shares();
  LidarNormal normal;
  SightingSquare noise = SightingSquare::Zero();
  std::vector<Eigen::Vector3d> plane_normals;
  double squares = 0;
  for (const Sight& sight : sights_) {
    if (!counts(sight)) continue;
    const Row12d& J = sight.jacobian;
    const double off = std::abs(sight.distance_m) / (options_.huber_sigmas * std::sqrt(sight.variance));
    const double weight =
        share[static_cast<std::size_t>(side_of(sight))] / (sight.variance * std::max(off, 1.0));
    normal.square.noalias() += (weight * J.transpose()) * J;
    normal.side += (weight * sight.distance_m) * J.transpose();
    plane_normals.push_back(sight.plane->normal);
    if (normal.points++ % kNoiseStep == 0) add_noise(sight, state, kNoiseStep * weight, noise);
    squares += sight.distance_m * sight.distance_m;
  }
  if (normal.points < options_.min_points) return {};
  on_planes_ = normal.points;
  rms_m_ = std::sqrt(squares / normal.points);
  return without_feigned(normal, noise, plane_normals, options_.observability);
}

std::vector<Eigen::Vector3d> LidarRegistration::map_points(const LidarState& end) const {
  std::vector<Eigen::Vector3d> result;
  result.reserve(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (!sights_[static_cast<std::size_t>(choice_.voxel_of[i])].is_off)
      result.push_back(
          world_point(end, path_.end().gyroscope_bias_radps,
                      path_.place(points_[i].stamp_ns, body_from_lidar_ * points_[i].lidar.cast<double>())));
  return result;
}

}  // namespace uniquadric
