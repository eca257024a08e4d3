#include "estimator/window/short_window.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/base/seconds.h"
#include "estimator/factors/pose_block.h"
#include "estimator/factors/pose_prior.h"
#include "estimator/factors/reprojection.h"
#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

constexpr double kHuberSigmas = 2;       // residuals beyond pull less
constexpr int kMaxMisses = 3;            // keyframes in a row in which a landmark was an outlier
constexpr double kLeastSigma = 5e-4;     // [m] of a landmark, however often it was seen
constexpr double kMinPriorTrace = 1e-6;  // [1/m^2]; less information is none
constexpr int kMaxIterations = 8;        // of the window's solver: it starts at tracked poses

LandmarkSighting sighting_of(const Feature& feature, const BodyPoint& landmark) {
  return {landmark.position, landmark.sigma_m,      feature.pixel,
          feature.depth_m,   feature.depth_sigma_m, feature.rim};
}

bool add_prior(ceres::Problem& problem, const BodyPoint& landmark, double* point) {
  if (landmark.prior_information.trace() < kMinPriorTrace) return false;
  const Eigen::Matrix3d root = landmark.prior_information.llt().matrixU();
  problem.AddResidualBlock(landmark_prior_factor(landmark.prior_position, root).release(), nullptr, point);
  return true;
}

void add_motion_model(ceres::Problem& problem, const std::deque<BodyKeyframe>& keyframes,
                      std::vector<PoseBlock>& poses, const MotionNoise& noise) {
  for (std::size_t i = 2; i < poses.size(); ++i) {
    const auto step_s = [&](std::size_t k) {
      return 1e-9 * static_cast<double>(keyframes[k].stamp_ns - keyframes[k - 1].stamp_ns);
    };
    problem.AddResidualBlock(motion_model_factor(step_s(i) / step_s(i - 1), MotionModel::straight,
                                                 prediction_sigmas(step_s(i - 1), step_s(i), noise))
                                 .release(),
                             nullptr, poses[i - 2].data(), poses[i - 1].data(), poses[i].data());
  }
}

bool shows_whole(const BodyObservation& body) {
  return body.silhouette && is_whole(*body.silhouette);
}

}  // namespace

void ShortWindow::start(const PerceivedFrame& frame, const BodyObservation& body,
                        const Pose& world_from_body) {
  keyframes_.clear();
  std::vector<Feature> features;
  for (const Feature& feature : body.features) {
    if (feature.depth_m <= 0) continue;
    landmarks_.erase(feature.track);  // it was no help where the body is now
    features.push_back(feature);
  }
  add_keyframe(frame, std::move(features), world_from_body, shows_whole(body));
}

std::vector<LandmarkSighting> ShortWindow::sightings(const BodyObservation& body) const {
  std::vector<LandmarkSighting> sightings;
  for (const Feature& feature : body.features)
    if (const auto landmark = landmarks_.find(feature.track); landmark != landmarks_.end())
      sightings.push_back(sighting_of(feature, landmark->second));
  return sightings;
}

std::optional<PoseSolution> ShortWindow::find(const PerceivedFrame& frame, const BodyObservation& body,
                                              const Pose& predicted_world_from_body, bool search,
                                              RandomStream& random) const {
  const std::vector<LandmarkSighting> seen = sightings(body);
  auto solution =
      search ? std::nullopt
             : solve_pose(camera_, seen, frame.world_from_camera->inverse() * predicted_world_from_body,
                          options_.pose);
  const bool few = !solution || 2 * solution->inlier_count < std::ssize(seen);
  if (few)
    if (auto found = find_pose(camera_, seen, options_.pose, random);
        found && (!solution || found->inlier_count > solution->inlier_count))
      solution = std::move(found);
  return solution;
}

BodyPose ShortWindow::take(const PerceivedFrame& frame, const BodyObservation& body,
                           const PoseSolution& solution) {
  BodyPose result;
  result.world_from_body = *frame.world_from_camera * solution.camera_from_body;
  result.world_from_body.rotation.normalize();
  result.sighted = result.world_from_body;
  result.information = solution.information;
  // what is under a mask that is not known to be the body's may be another's
  result.keyframe = body.silhouette && keyframe_is_due(frame, shows_whole(body), solution.camera_from_body,
                                                       solution.inlier_count);
  std::vector<Feature> kept;
  auto is_inlier_of = solution.inliers.begin();
  for (const Feature& feature : body.features) {
    const auto known = landmarks_.find(feature.track);
    if (known == landmarks_.end()) continue;
    BodyPoint& landmark = known->second;
    const bool agrees = *is_inlier_of++;
    if (agrees) {
      landmark.last_frame = frame.frame;
      kept.push_back(feature);
    }
    if (result.keyframe) landmark.misses = agrees ? 0 : landmark.misses + 1;
  }
  if (!result.keyframe) return result;
  forget_missed();
  for (const Feature& feature : body.features)
    if (feature.depth_m > 0 && !landmarks_.contains(feature.track)) kept.push_back(feature);
  add_keyframe(frame, std::move(kept), result.world_from_body, shows_whole(body));
  optimise();
  drop_outliers();
  if (std::ssize(keyframes_) > options_.keyframes) marginalise_oldest();
  bound_memory();
  result.world_from_body = keyframes_.back().world_from_body;
  return result;
}

// With its sightings: what the track shows from now on is another point.
void ShortWindow::forget_missed() {
  for (BodyKeyframe& keyframe : keyframes_)
    std::erase_if(keyframe.features,
                  [&](const Feature& feature) { return landmarks_.at(feature.track).misses >= kMaxMisses; });
  std::erase_if(landmarks_, [](const auto& entry) { return entry.second.misses >= kMaxMisses; });
}

bool ShortWindow::keyframe_is_due(const PerceivedFrame& frame, bool whole, const Pose& camera_from_body,
                                  int seen) const {
  const BodyKeyframe& last = keyframes_.back();
  const Pose last_camera_from_body = last.world_from_camera.inverse() * last.world_from_body;
  const double turn = camera_from_body.rotation.angularDistance(last_camera_from_body.rotation);
  return seconds(last.stamp_ns, frame.stamp_ns) >= options_.keyframe_gap_s || (whole && !last.whole) ||
         turn > options_.keyframe_turn_deg * EIGEN_PI / 180 ||
         seen < options_.keyframe_share * static_cast<double>(last.features.size());
}

void ShortWindow::add_keyframe(const PerceivedFrame& frame, std::vector<Feature> features,
                               const Pose& world_from_body, bool whole) {
  const Pose body_from_camera = world_from_body.inverse() * *frame.world_from_camera;
  for (const Feature& feature : features) {
    if (landmarks_.contains(feature.track)) continue;
    BodyPoint landmark;
    landmark.position =
        body_from_camera * Eigen::Vector3d(feature.depth_m * ideal_ray(camera_, feature.pixel));
    landmark.sigma_m = feature.depth_sigma_m;
    landmark.last_frame = frame.frame;
    landmarks_.emplace(feature.track, landmark);
  }
  keyframes_.push_back(
      {frame.frame, frame.stamp_ns, *frame.world_from_camera, world_from_body, std::move(features), whole});
}

void ShortWindow::optimise() {
  ceres::Problem problem;
  std::vector<PoseBlock> poses;
  poses.reserve(keyframes_.size());
  struct Block {
    double* point = nullptr;
    double information = 0;  // [1/m^2] of its depths in the window
  };
  std::map<std::int64_t, Block> blocks;  // by landmark
  // In one piece: Ceres sorts what is eliminated first by address, and the sums' last bits are of that order.
  std::vector<Eigen::Vector3d> points;
  std::size_t sightings = 0;
  for (const BodyKeyframe& keyframe : keyframes_) sightings += keyframe.features.size();
  points.reserve(sightings);
  bool anchored = false;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (const BodyKeyframe& keyframe : keyframes_) {
    double* pose = poses.emplace_back(pose_block(keyframe.world_from_body)).data();
    problem.AddParameterBlock(pose, 7, pose_manifold().release());
    ordering->AddElementToGroup(pose, 1);
    for (const Feature& feature : keyframe.features) {
      const BodyPoint& landmark = landmarks_.at(feature.track);
      Block& block = blocks[feature.track];
      if (feature.depth_m > 0) block.information += 1 / (feature.depth_sigma_m * feature.depth_sigma_m);
      if (!block.point) {
        block.point = points.emplace_back(landmark.position).data();
        ordering->AddElementToGroup(block.point, 0);
        anchored |= add_prior(problem, landmark, block.point);
      }
      problem.AddResidualBlock(
          reprojection_factor(camera_, keyframe.world_from_camera, feature, options_.pose.pixel_sigma_px)
              .release(),
          new ceres::HuberLoss(kHuberSigmas), pose, block.point);
    }
  }
  if (options_.motion_model) add_motion_model(problem, keyframes_, poses, options_.motion_noise);
  if (!anchored) problem.SetParameterBlockConstant(poses.front().data());
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = kMaxIterations;
  solver.num_threads = 1;  // several sum in an order of their own
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  for (std::size_t i = 0; i < poses.size(); ++i) keyframes_[i].world_from_body = pose_from_block(poses[i]);
  for (const auto& [track, block] : blocks) {
    BodyPoint& landmark = landmarks_.at(track);
    landmark.position = Eigen::Map<const Eigen::Vector3d>(block.point);
    const double all = block.information + landmark.prior_information.trace() / 3;
    if (all > 0) landmark.sigma_m = std::max(kLeastSigma, 1 / std::sqrt(all));
  }
}

void ShortWindow::drop_outliers() {
  for (BodyKeyframe& keyframe : keyframes_) {
    const Pose camera_from_body = keyframe.world_from_camera.inverse() * keyframe.world_from_body;
    std::erase_if(keyframe.features, [&](const Feature& feature) {
      return !is_inlier(camera_, sighting_of(feature, landmarks_.at(feature.track)), camera_from_body,
                        options_.pose);
    });
  }
}

// Of what the oldest keyframe knows, each landmark keeps its own share: J^T (I + J_T S J_T^T)^-1 J, with S
// the covariance of the keyframe's pose. The correlations between landmarks are left out, so that the
// window's problem keeps its Schur structure.
void ShortWindow::marginalise_oldest() {
  const BodyKeyframe oldest = keyframes_.front();
  keyframes_.pop_front();
  if (!options_.marginal_prior) return;
  const Pose camera_from_body = oldest.world_from_camera.inverse() * oldest.world_from_body;
  std::vector<LinearisedSighting> lines;
  Matrix6d pose_information = Matrix6d::Identity() * 1e-6;
  for (const Feature& feature : oldest.features) {
    LandmarkSighting sighting = sighting_of(feature, landmarks_.at(feature.track));
    sighting.point_sigma_m = 0;
    lines.push_back(linearise(camera_, sighting, camera_from_body, options_.pose.pixel_sigma_px));
    pose_information += lines.back().by_pose.transpose() * lines.back().by_pose;
  }
  const Matrix6d pose_covariance = pose_information.inverse();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const LinearisedSighting& line = lines[i];
    if (!line.valid) continue;
    BodyPoint& landmark = landmarks_.at(oldest.features[i].track);
    const Eigen::Matrix3d spread =
        Eigen::Matrix3d::Identity() + line.by_pose * pose_covariance * line.by_pose.transpose();
    const Eigen::Matrix3d weighted = line.by_point.transpose() * spread.inverse();
    const Eigen::Matrix3d gained = weighted * line.by_point;
    const Eigen::Vector3d right = landmark.prior_information * landmark.prior_position +
                                  gained * landmark.position - weighted * line.residual;
    landmark.prior_information += gained;
    landmark.prior_position = landmark.prior_information.ldlt().solve(right);
  }
}

void ShortWindow::bound_memory() {
  if (std::ssize(landmarks_) <= options_.max_landmarks) return;
  std::vector<std::pair<std::int64_t, std::int64_t>> by_age;  // last frame, track
  for (const auto& [track, landmark] : landmarks_) by_age.emplace_back(landmark.last_frame, track);
  std::sort(by_age.begin(), by_age.end());
  const std::int64_t window_start = keyframes_.front().frame;
  for (const auto& [frame, track] : by_age) {
    if (std::ssize(landmarks_) <= options_.max_landmarks || frame >= window_start) return;
    landmarks_.erase(track);
  }
}

}  // namespace uniquadric
