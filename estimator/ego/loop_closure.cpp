#include "estimator/ego/loop_closure.h"

#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <map>
#include <memory>

#include "core/base/quantile.h"
#include "estimator/factors/pose_block.h"
#include "estimator/factors/pose_prior.h"

namespace uniquadric {
namespace {

constexpr int kPathNeighbours = 2;               // edges from each keyframe to this many before it
constexpr PoseSigmas kPathSigmas{0.005, 0.003};  // of an edge: only their ratio matters

double median_error_px(const std::vector<PointSighting>& sightings, const Camera& camera, const Pose& pose) {
  std::vector<double> errors;
  for (const auto& s : sightings)
    if (const auto pixel = camera.project(pose * s.point)) errors.push_back((*pixel - s.pixel).norm());
  if (errors.empty()) return 0;
  return upper_median(std::move(errors));
}

}  // namespace

std::optional<Loop> find_loop(const EgoMap& map, const Camera& camera, const std::vector<Feature>& features,
                              const Pose& camera_from_world, const LoopOptions& options,
                              RandomStream& random) {
  const int newest = static_cast<int>(map.keyframes.size()) - 1;
  std::vector<PointSighting> sightings;
  std::map<int, int> seen_by;
  for (const Feature& feature : features) {
    const auto point = map.points.find(feature.track);
    if (point == map.points.end() || newest - point->second.keyframes.back() < options.min_gap_keyframes)
      continue;
    sightings.push_back({point->second.position, feature.pixel, feature.depth_m, feature.depth_sigma_m});
    for (const int keyframe : point->second.keyframes) ++seen_by[keyframe];
  }
  if (std::ssize(sightings) < options.min_points) return std::nullopt;
  if (median_error_px(sightings, camera, camera_from_world) < options.min_disagreement_px)
    return std::nullopt;
  RigidMotionOptions motion = options.motion;
  motion.min_inliers = options.min_points;
  const auto fit = fit_rigid_motion(sightings, camera, camera_from_world, motion, random);
  if (!fit) return std::nullopt;
  const auto best = std::max_element(seen_by.begin(), seen_by.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return Loop{best->first, fit->camera_from_body};
}

void close_loop(EgoMap& map, const Loop& loop, const LoopOptions& options) {
  const int count = static_cast<int>(map.keyframes.size());
  std::vector<PoseBlock> blocks;  // world_from_camera
  for (const Keyframe& keyframe : map.keyframes)
    blocks.push_back(pose_block(keyframe.camera_from_world.inverse()));
  ceres::Problem::Options ownership;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  const auto manifold = pose_manifold();
  ceres::Problem problem(ownership);
  for (PoseBlock& block : blocks) problem.AddParameterBlock(block.data(), 7, manifold.get());
  problem.SetParameterBlockConstant(blocks[0].data());
  const auto add_edge = [&](int a, int b, const Pose& a_from_b, double share) {
    const PoseSigmas sigmas{share * kPathSigmas.translation_m, share * kPathSigmas.rotation_rad};
    problem.AddResidualBlock(relative_pose_factor(a_from_b, sigmas).release(), nullptr, blocks[a].data(),
                             blocks[b].data());
  };
  for (int b = 1; b < count; ++b)
    for (int a = std::max(0, b - kPathNeighbours); a < b; ++a)
      add_edge(a, b, map.keyframes[a].camera_from_world * map.keyframes[b].camera_from_world.inverse(), 1);
  add_edge(loop.old_keyframe, count - 1,
           map.keyframes[loop.old_keyframe].camera_from_world * loop.camera_from_world.inverse(),
           options.loop_sigma);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = 30;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  std::vector<Pose> new_from_old;  // in the world, of what each keyframe sees
  for (int k = 0; k < count; ++k) {
    Pose world_from_camera = pose_from_block(blocks[k]);
    world_from_camera.rotation.normalize();
    new_from_old.push_back(world_from_camera * map.keyframes[k].camera_from_world);
    map.keyframes[k].camera_from_world = world_from_camera.inverse();
  }
  for (auto& [track, point] : map.points) {
    // The newest keyframe sees returned points too: those belong to where they were seen before.
    const auto& seen_by = point.keyframes;
    point.position = new_from_old[seen_by.front()] * point.position;
  }
}

}  // namespace uniquadric
