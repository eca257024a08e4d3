#include "estimator/ego/depth_calibration.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "estimator/factors/pose_block.h"

namespace uniquadric {
namespace {

constexpr std::size_t kKeyframes = 60, kPoints = 500;  // of the adjustment: as many as are needed
constexpr int kLeastSightings = 3;
constexpr int kIterations = 40;
constexpr double kHuberSigmas = 2;
constexpr double kNearest_m = 0.05;
constexpr std::size_t kLeastKeyframes = 4;
constexpr int kGroups = 6;            // of points and of keyframes in a row, each left out once
constexpr double kProfileStep = 0.1;  // of the bias, in sigmas of its prior
constexpr double kNoInformation = 1e-3;
// Priors. Bias: 2 sigmas are 2 % at 2 m, the accuracy that the D435's data sheet promises. Focal length and
// principal point: ours, of a calibration of some care.
constexpr double kBiasSigma_per_m = 0.005, kFocalSigma = 0.005, kCentreSigma_px = 3;

using Calibration = std::array<double, 4>;  // bias, logarithm of the focal length's factor, centre's shift

// The bias is on the side of what is predicted. Were it to change what is measured, a negative one would
// shrink the noise with the depths, and win by that.
struct Sighting {
  Camera camera;
  Feature feature;
  double pixel_sigma;

  template <typename T>
  bool operator()(const T* pose, const T* point, const T* calibration, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> rotation(pose);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> translation(pose + 4), position(point);
    const Eigen::Matrix<T, 3, 1> p = rotation * position + translation;
    const T z = p.z() < kNearest_m ? T(kNearest_m) : p.z();
    const T focal = exp(calibration[1]);
    residual[0] =
        (camera.fx * focal * p.x() / z + camera.cx + calibration[2] - feature.pixel.x()) / pixel_sigma;
    residual[1] =
        (camera.fy * focal * p.y() / z + camera.cy + calibration[3] - feature.pixel.y()) / pixel_sigma;
    residual[2] = T(0);
    if (feature.depth_m > 0 && feature.depth_sigma_m > 0)
      residual[2] = (z / (1.0 + calibration[0] * z) - feature.depth_m) / feature.depth_sigma_m;
    return true;
  }
};

struct Prior {
  template <typename T>
  bool operator()(const T* calibration, T* residual) const {
    residual[0] = calibration[0] / kBiasSigma_per_m;
    residual[1] = calibration[1] / kFocalSigma;
    residual[2] = calibration[2] / kCentreSigma_px;
    residual[3] = calibration[3] / kCentreSigma_px;
    return true;
  }
};

std::vector<const Keyframe*> evenly_chosen(const std::vector<Keyframe>& keyframes) {
  const std::size_t count = std::min(keyframes.size(), kKeyframes);
  std::vector<const Keyframe*> chosen;
  for (std::size_t i = 0; i < count; ++i)
    chosen.push_back(&keyframes[i * (keyframes.size() - 1) / (count - 1)]);
  return chosen;
}

// Positions of the points that the keyframes see most, by track.
std::map<std::int64_t, Eigen::Vector3d> most_seen(const EgoMap& map,
                                                  const std::vector<const Keyframe*>& keyframes) {
  std::map<std::int64_t, int> sightings;
  for (const Keyframe* keyframe : keyframes)
    for (const Feature& feature : keyframe->features)
      if (map.points.contains(feature.track)) ++sightings[feature.track];
  std::vector<std::pair<int, std::int64_t>> order;
  for (const auto& [track, count] : sightings)
    if (count >= kLeastSightings) order.emplace_back(-count, track);
  std::sort(order.begin(), order.end());
  if (order.size() > kPoints) order.resize(kPoints);
  std::map<std::int64_t, Eigen::Vector3d> points;
  for (const auto& [count, track] : order) points[track] = map.points.at(track).position;
  return points;
}

// What an adjustment begins with and ends with.
struct Estimate {
  std::vector<PoseBlock> poses;                    // camera_from_world of the keyframes
  std::map<std::int64_t, Eigen::Vector3d> places;  // of points
  Calibration calibration{};
  double cost = 0;
};

enum class Bias { free, held };

// Groups of what is left out of an adjustment.
constexpr int kNone = -1;
struct LeftOut {
  int points = kNone, keyframes = kNone;
};

// The `i`-th of `count` in a row.
int group_of(std::size_t i, std::size_t count) {
  return static_cast<int>(i * kGroups / count);
}

// The best estimate by what is not left out.
Estimate adjusted(Estimate start, const std::vector<const Keyframe*>& keyframes, const Camera& camera,
                  double pixel_sigma, LeftOut left_out, Bias bias) {
  ceres::HuberLoss loss(kHuberSigmas);
  ceres::SubsetManifold without_bias(4, {0});
  const auto manifold = pose_manifold();
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  // In one piece: Ceres sorts what is eliminated first by address.
  std::vector<Eigen::Vector3d> points;
  std::map<std::int64_t, double*> point_of;
  points.reserve(start.places.size());
  int at = 0;
  for (const auto& [track, place] : start.places)
    if (at++ % kGroups != left_out.points) {
      double* point = point_of[track] = points.emplace_back(place).data();
      problem.AddParameterBlock(point, 3);
      ordering->AddElementToGroup(point, 0);
    }
  double* first = nullptr;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    if (group_of(i, keyframes.size()) == left_out.keyframes) continue;
    double* pose = start.poses[i].data();
    problem.AddParameterBlock(pose, 7, manifold.get());
    if (!first) first = pose;
    ordering->AddElementToGroup(pose, 1);
    for (const Feature& feature : keyframes[i]->features)
      if (const auto point = point_of.find(feature.track); point != point_of.end())
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<Sighting, 3, 7, 3, 4>(new Sighting{camera, feature, pixel_sigma}),
            &loss, pose, point->second, start.calibration.data());
  }
  problem.SetParameterBlockConstant(first);
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Prior, 4, 4>(new Prior), nullptr,
                           start.calibration.data());
  if (bias == Bias::held) problem.SetManifold(start.calibration.data(), &without_bias);
  ordering->AddElementToGroup(start.calibration.data(), 1);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  options.max_num_iterations = kIterations;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  start.cost = summary.final_cost;
  for (const auto& [track, point] : point_of) start.places[track] = Eigen::Map<Eigen::Vector3d>(point);
  return start;
}

}  // namespace

std::optional<DepthBias> calibrate_depth(const EgoMap& map, const Camera& camera, double pixel_sigma,
                                         double most_sigma_per_m) {
  if (map.keyframes.size() < kLeastKeyframes) return std::nullopt;
  const auto keyframes = evenly_chosen(map.keyframes);
  Estimate start;
  start.places = most_seen(map, keyframes);
  for (const Keyframe* keyframe : keyframes) start.poses.push_back(pose_block(keyframe->camera_from_world));
  const auto solve = [&](const Estimate& from, LeftOut left_out, Bias bias) {
    return adjusted(from, keyframes, camera, pixel_sigma, left_out, bias);
  };
  const Estimate all = solve(start, {}, Bias::free);
  // The cost's curvature along the bias, all else at its best, is the information on it, the prior's too.
  const double step = kProfileStep * kBiasSigma_per_m;
  Estimate beside = all;
  beside.calibration[0] += step;
  const double rise = solve(beside, {}, Bias::held).cost - all.cost;
  const double prior = 1 / (kBiasSigma_per_m * kBiasSigma_per_m);
  const double curvature = std::max(2 * rise / (step * step), (1 + kNoInformation) * prior) - prior;
  if (1 / std::sqrt(curvature + prior) > most_sigma_per_m) return std::nullopt;
  const auto variance = [&](int LeftOut::*part) {
    double mean = 0, square = 0;
    for (int group = 0; group < kGroups; ++group) {
      LeftOut left_out;
      left_out.*part = group;
      const double bias = solve(all, left_out, Bias::free).calibration[0];
      mean += bias / kGroups;
      square += bias * bias / kGroups;
    }
    return (kGroups - 1) * std::max(0.0, square - mean * mean);
  };
  const double spread = std::max(variance(&LeftOut::points), variance(&LeftOut::keyframes));
  // Sightings whose errors hang together tell less than the adjustment takes them for.
  const double information = std::min(curvature, 1 / std::max(spread, 1e-12));
  const double share = information / (information + prior) * (curvature + prior) / curvature;
  return DepthBias{share * all.calibration[0], 1 / std::sqrt(information + prior)};
}

void add_bias_variance(const DepthBias& bias, const Pose& world_from_camera, ObjectState& state) {
  const Ellipsoid& body = state.ellipsoid;
  const Eigen::Vector3d ray = body.world_from_object.translation - world_from_camera.translation;
  const double z = (world_from_camera.rotation.inverse() * ray).z();
  const double share = z * bias.sigma_per_m;
  state.covariance_diagonal.head<3>() += (share * body.semi_axes_m).cwiseAbs2();
  state.covariance_diagonal.segment<3>(3) += (share * ray).cwiseAbs2();
}

}  // namespace uniquadric
