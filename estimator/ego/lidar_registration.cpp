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
                                     const Matrix18d& prior, const PointSigmas& sigmas, double row_gap_rad,
                                     const LidarSightOptions& options)
    : map_(map),
      points_(points),
      path_(path),
      body_from_lidar_(body_from_lidar),
      prior_(prior.topLeftCorner<6, 6>()),
      sigmas_(sigmas),
      min_rise_rad_(std::max(row_gap_rad / 2, options.min_rise * sigmas.beam_rad)),
      options_(options),
      choice_(choose_points(points, voxel_m)) {
  sights_.reserve(choice_.point_of.size());
  for (const int i : choice_.point_of) {
    const Eigen::Vector3d lidar = points[static_cast<std::size_t>(i)].lidar.cast<double>();
    Sight& sight = sights_.emplace_back();
    sight.point = place(i);
    sight.range_m = lidar.norm();
    sight.beam_at_end = sight.point.end_from_then * (body_from_lidar.rotation * (lidar / sight.range_m));
  }
}

SweepPoint LidarRegistration::place(int point) const {
  const TimedPoint& p = points_[static_cast<std::size_t>(point)];
  return path_.place(p.stamp_ns, body_from_lidar_ * p.lidar.cast<double>());
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
  const EndPoint at_end = end_point(state, path_.end().gyroscope_bias_radps, sight.point);
  if (iteration < options_.searches) {
    const double noise = std::hypot(sigmas_.range_m, sigmas_.beam_rad * sight.range_m);
    const Eigen::Vector3d world = world_point(state, sight.point, at_end);
    if (iteration == 0 || (world - sight.sought_at).norm() > options_.search_again_m) {
      sight.plane = map_.plane_near(
          world, {options_.max_thickness * noise, options_.min_breadth * noise, min_rise_rad_});
      sight.sought_at = world;
    }
  }
  sight.is_off = false;
  if (!sight.plane) return;
  sight.distance_m = plane_distance(state, sight.point, at_end, *sight.plane);
  const Row12d J = sight.jacobian = distance_jacobian(state, sight.point, at_end, sight.plane->normal);
  sight.variance = variance_of(sight, R);
  const double predicted =
      iteration < kOpenIterations ? (J.head<6>() * prior_ * J.head<6>().transpose()).value() : 0;
  const double gate = std::clamp(options_.gate_sigmas * std::sqrt(sight.variance + predicted),
                                 options_.gate_m, std::max(options_.gate_m, options_.open_gate_m));
  sight.is_off = !(std::abs(sight.distance_m) <= gate);
}

std::size_t LidarRegistration::side_of(const MapPlane& plane) const {
  std::size_t side = 0;
  const Eigen::Vector3d facing = (sides_.transpose() * plane.normal).cwiseAbs();
  facing.maxCoeff(&side);
  return side;
}

// What a point facing each way counts; tells points their sides.
std::array<double, 3> LidarRegistration::shares() {
  std::array<double, 3> points{};
  for (Sight& sight : sights_)
    if (counts(sight)) ++points[sight.side = side_of(*sight.plane)];
  for (double& share : points) share = std::min(1.0, options_.side_points / std::max(share, 1.0));
  return points;
}

void LidarRegistration::add_noise(const Sight& sight, const LidarState& state, double weight,
                                  SightingSquare& noise) const {
  const EndPoint at_end = end_point(state, path_.end().gyroscope_bias_radps, sight.point);
  for (const auto& error : sight.plane->normal_error.colwise()) {
    const Row12d row = distance_jacobian(state, sight.point, at_end, error);
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
  std::vector<Eigen::Vector3d> faced;
  double squares = 0;
  for (const Sight& sight : sights_) {
    if (!counts(sight)) continue;
    const Row12d& J = sight.jacobian;
    const double off = std::abs(sight.distance_m) / (options_.huber_sigmas * std::sqrt(sight.variance));
    const double weight = share[sight.side] / (sight.variance * std::max(off, 1.0));
    normal.square.noalias() += (weight * J.transpose()) * J;
    normal.side += (weight * sight.distance_m) * J.transpose();
    if (sight.plane->cells >= options_.observability.min_cells) faced.push_back(sight.plane->normal);
    if (normal.points++ % kNoiseStep == 0) add_noise(sight, state, kNoiseStep * weight, noise);
    squares += sight.distance_m * sight.distance_m;
  }
  if (normal.points < options_.min_points) return {};
  on_planes_ = normal.points;
  rms_m_ = std::sqrt(squares / normal.points);
  return without_feigned(normal, noise, faced, options_.observability);
}

std::vector<LidarMapPoint> LidarRegistration::map_points(const LidarState& end) const {
  std::vector<LidarMapPoint> result;
  result.reserve(points_.size());
  for (int i = 0; i < std::ssize(points_); ++i) {
    const auto voxel = static_cast<std::size_t>(choice_.voxel_of[static_cast<std::size_t>(i)]);
    const Sight& sight = sights_[voxel];
    if (sight.is_off) continue;
    const SweepPoint point = choice_.point_of[voxel] == i ? sight.point : place(i);
    result.push_back({world_point(end, point, end_point(end, path_.end().gyroscope_bias_radps, point)),
                      elevation_rad(points_[static_cast<std::size_t>(i)].lidar)});
  }
  return result;
}

}  // namespace uniquadric
