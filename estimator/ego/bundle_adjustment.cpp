#include "estimator/ego/bundle_adjustment.h"

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "estimator/factors/pose_block.h"
#include "estimator/factors/reprojection.h"

namespace uniquadric {
namespace {

constexpr std::size_t kMostFixed = 12;  // keyframes that hold still: those that share most points

struct Sighting {
  int keyframe;
  const Feature* feature;
  MapPoint* point;
};

std::set<std::int64_t> tracks_of(const EgoMap& map, const std::set<int>& keyframes) {
  std::set<std::int64_t> tracks;
  for (const int k : keyframes)
    for (const Feature& feature : map.keyframes[k].features) tracks.insert(feature.track);
  return tracks;
}

// Keyframes outside `moving` that see points which `moving` sees, those with most of them.
std::set<int> fixed_neighbours(const EgoMap& map, const std::set<int>& moving,
                               const std::set<std::int64_t>& tracks) {
  std::map<int, int> shared;
  for (const std::int64_t track : tracks)
    for (const int k : map.points.at(track).keyframes)
      if (!moving.contains(k)) ++shared[k];
  std::vector<std::pair<int, int>> order;
  for (const auto& [keyframe, count] : shared) order.emplace_back(-count, keyframe);
  std::sort(order.begin(), order.end());
  std::set<int> fixed;
  for (std::size_t i = 0; i < std::min(order.size(), kMostFixed); ++i) fixed.insert(order[i].second);
  return fixed;
}

std::vector<Sighting> sightings_in(EgoMap& map, const std::set<int>& moving, const std::set<int>& fixed,
                                   const std::set<std::int64_t>& tracks) {
  std::vector<Sighting> sightings;
  for (const auto* group : {&moving, &fixed})
    for (const int k : *group)
      for (const Feature& feature : map.keyframes[k].features)
        if (tracks.contains(feature.track)) sightings.push_back({k, &feature, &map.points.at(feature.track)});
  return sightings;
}

void take_out_outliers(EgoMap& map, const Camera& camera, const std::vector<Sighting>& sightings,
                       const BundleOptions& options) {
  std::map<int, std::vector<std::int64_t>> removed;
  for (const auto& [k, feature, point] : sightings) {
    const Eigen::Vector3d p = map.keyframes[k].camera_from_world * point->position;
    const auto pixel = camera.project(p);
    const bool pixel_fits =
        pixel && (*pixel - feature->pixel).norm() <= options.outlier_sigmas * options.pixel_sigma;
    const bool depth_fits = feature->depth_m <= 0 || std::abs(p.z() - feature->depth_m) <=
                                                         options.outlier_sigmas * feature->depth_sigma_m;
    if (!pixel_fits || !depth_fits) removed[k].push_back(feature->track);
  }
  for (const auto& [k, tracks] : removed) remove_sightings(map, k, tracks);
}

}  // namespace

void adjust_bundle(EgoMap& map, const Camera& camera, const std::vector<int>& moving_keyframes,
                   const BundleOptions& options) {
  const std::set<int> moving(moving_keyframes.begin(), moving_keyframes.end());
  if (moving.empty()) return;
  const std::set<std::int64_t> tracks = tracks_of(map, moving);
  const std::set<int> fixed = fixed_neighbours(map, moving, tracks);
  const auto sightings = sightings_in(map, moving, fixed, tracks);
  if (sightings.empty()) return;
  // In one piece: Ceres sorts what is eliminated first by address, and the sums' last bits are of that order.
  std::vector<PoseBlock> blocks;
  std::vector<Eigen::Vector3d> points;
  blocks.reserve(moving.size() + fixed.size());
  points.reserve(sightings.size());
  std::map<int, double*> block_of;
  std::map<MapPoint*, double*> point_of;
  ceres::HuberLoss loss(options.huber_sigmas);
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  const auto manifold = pose_manifold();
  ceres::Problem problem(ownership);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (const auto* group : {&moving, &fixed})
    for (const int k : *group) {
      double* block = blocks.emplace_back(pose_block(map.keyframes[k].camera_from_world)).data();
      block_of[k] = block;
      problem.AddParameterBlock(block, 7, manifold.get());
      ordering->AddElementToGroup(block, 1);
      if (fixed.contains(k) || (fixed.empty() && k == *moving.begin()))
        problem.SetParameterBlockConstant(block);
    }
  for (const auto& s : sightings) {
    double*& point = point_of[s.point];
    if (!point) {
      point = points.emplace_back(s.point->position).data();
      ordering->AddElementToGroup(point, 0);
    }
    // The world is the body here, and the camera stands still.
    problem.AddResidualBlock(reprojection_factor(camera, Pose{}, *s.feature, options.pixel_sigma).release(),
                             &loss, block_of.at(s.keyframe), point);
  }
  ceres::Solver::Options solver;
  // Where the camera stays in one room the Schur complement of many keyframes is full: it is not formed then.
  solver.linear_solver_type = moving.size() > 50 ? ceres::ITERATIVE_SCHUR : ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = options.iterations;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  for (const auto& [map_point, point] : point_of) map_point->position = Eigen::Map<Eigen::Vector3d>(point);
  for (const int k : moving) {
    map.keyframes[k].camera_from_world = pose_from_block(block_of.at(k));
    map.keyframes[k].camera_from_world.rotation.normalize();
  }
  take_out_outliers(map, camera, sightings, options);
}

}  // namespace uniquadric
