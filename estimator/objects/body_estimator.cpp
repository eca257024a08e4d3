#include "estimator/objects/body_estimator.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/seconds.h"
#include "estimator/objects/assumed_surface.h"

namespace uniquadric {
namespace {

constexpr PoseSigmas kSettleSigmas{0.01, 0.03};  // of a pose by features against the surface
constexpr PoseSigmas kAnySigmas{1, 1.8};         // of what a frame does not tell: any turn is as likely
constexpr PoseSigmas kStraySigmas{0.03, 0.1};    // of a pose that goes by a new face
constexpr PoseSigmas kAgainSigmas{0.03, 0.1};    // of a trajectory where its poses were guessed
constexpr double kBack = 0.7;                    // share of the points on the surface of before
constexpr double kSlid = 1.5,
                 kSlidBy = 1e-3;  // mean distance off the surface, against the best one's; [m] more
constexpr double kStill = 1e-6;   // [m], [rad] of a body that is held in its place
constexpr int kPatience = 6;      // times the frames of a restart, until a part of the body in view will do

// What goes beyond the image on all sides, as a mask of everything does, shows no end of a body.
bool can_start(const BodyObservation& body) {
  if (!body.silhouette || body.points.cols() == 0) return false;
  const auto& support = body.silhouette->support;
  return std::any_of(support.begin(), support.end(), [](const SupportLine& line) { return line.free; });
}

BodyObservation features_of(const BodyObservation& body) {
  BodyObservation result;
  result.id = body.id;
  result.features = body.features;
  result.motion = body.motion;
  return result;
}

// Of the points of a body of which nothing hides a part, in the world.
std::optional<Eigen::Vector3d> middle_of(const PerceivedFrame& frame, const BodyObservation& body) {
  if (!body.silhouette || !is_whole(*body.silhouette) || body.points.cols() == 0) return std::nullopt;
  return *frame.world_from_camera * Eigen::Vector3d(body.points.rowwise().mean());
}

Matrix6d covariance_of(Matrix6d information) {
  information.diagonal().head<3>().array() += std::pow(kAnySigmas.translation_m, -2);
  information.diagonal().tail<3>().array() += std::pow(kAnySigmas.rotation_rad, -2);
  return information.inverse();
}

Pose in_world(const PerceivedFrame& frame, const Pose& camera_from_body) {
  Pose pose = *frame.world_from_camera * camera_from_body;
  pose.rotation.normalize();
  return pose;
}

}  // namespace

bool is_placed(const Matrix6d& covariance, const Shape& shape) {
  const Eigen::Matrix3d to_radii = shape.semi_axes_m.cwiseInverse().asDiagonal() *
                                   shape.body_from_object.rotation.conjugate().toRotationMatrix();
  const Eigen::Matrix3d in_radii = to_radii * covariance.topLeftCorner<3, 3>() * to_radii.transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(in_radii, Eigen::EigenvaluesOnly)
             .eigenvalues()
             .maxCoeff() < 1;
}

BodyEstimator::BodyEstimator(int id, const Camera& camera, const BodyOptions& options, std::uint64_t seed)
    : id_(id),
      camera_(camera),
      options_(options),
      seed_(seed),
      short_window_(camera, options.short_window),
      shape_(id, camera, options.shape, seed),
      motion_(options.motion) {}

std::optional<BodyState> BodyEstimator::step(const PerceivedFrame& frame, const BodyObservation* body,
                                             std::vector<StageTime>* times) {
  shape_.note_times(times);
  if (frame.depth_changed && !recent_.empty()) begin_anew();
  if (!frame.world_from_camera) return std::nullopt;
  shape_.receive(frame.frame);  // silhouettes that came late
  if (recent_.empty()) {
    if (!body || !start(frame, *body)) return std::nullopt;
    return state_at(frame, recent_.back().world_from_body, recent_.back().covariance);
  }
  std::optional<BodyObservation> own;  // without outlines that are not this body's alone
  if (body && !has_own_outline(frame, *body)) body = &own.emplace(features_of(*body));
  std::optional<BodyPose> pose;
  if (body) pose = is_global() ? stand_still(frame) : track(frame, *body);
  const bool by_points = pose.has_value();
  if (pose && pose->keyframe && !is_global()) settle(frame, *body, *pose);
  if (!pose && body && body->silhouette) pose = align(frame, *body);
  if (pose && !by_points && !pose->keyframe && is_stale(frame)) return guessed(frame, *pose);
  if (pose) {
    frames_unfound_ = by_points || pose->keyframe ? 0 : frames_unfound_ + 1;
    return found(frame, *body, !own.has_value(), *pose);
  }
  const double hidden_s = seconds(recent_.back().stamp_ns, frame.stamp_ns);
  if (body && can_start(*body) && (was_a_glimpse(hidden_s) || has_wrong_model(frame, *body))) {
    begin_anew();
    return step(frame, body, times);
  }
  return unseen(frame, body);
}

// Back in view, and by its surface alone: until more of it is in view.
BodyState BodyEstimator::guessed(const PerceivedFrame& frame, const BodyPose& pose) {
  const Matrix6d covariance = covariance_of(pose.information);
  ++frames_unfound_;
  remember(frame, pose.world_from_body, covariance);
  BodyState state = state_at(frame, pose.world_from_body, covariance);
  state.status = ObjectStatus::occluded;
  state.evidence = PoseEvidence::guess;
  return state;
}

// `own_outline`: nothing speaks against its being this body's.
BodyState BodyEstimator::found(const PerceivedFrame& frame, const BodyObservation& body, bool own_outline,
                               const BodyPose& pose) {
  const Matrix6d covariance = covariance_of(pose.information);
  frames_misfit_ = 0;
  const bool placed = is_placed(covariance, shape_.shape());
  frames_placed_ += placed ? 1 : 0;
  if (frame.frame > sure_frame_ + 1 && seconds(sure_ns_, frame.stamp_ns) > options_.motion.window_s)
    motion_.forget();
  if (!is_global())
    motion_.add(frame.stamp_ns, *frame.world_from_camera, pose.sighted, covariance,
                std::cbrt(shape_.shape().semi_axes_m.prod()));
  sure_ns_ = frame.stamp_ns;
  sure_frame_ = frame.frame;
  remember(frame, pose.world_from_body, covariance);
  recent_.back().middle = middle_of(frame, body);
  if (own_outline && body.silhouette)
    outlines_.trust(camera_, *body.silhouette, frame.stamp_ns,
                    frame.world_from_camera->inverse() * pose.world_from_body, body_center());
  if (pose.keyframe) {
    ++keyframes_;
    if (!is_global()) shape_.follow(short_window_.keyframes());
    if (placed)
      shape_.add_keyframe({frame.frame, frame.stamp_ns, *frame.world_from_camera, pose.world_from_body, {}},
                          body);
  }
  return state_at(frame, pose.world_from_body, covariance);
}

void BodyEstimator::begin_anew() {
  const int beginnings = beginnings_ + 1;
  *this = BodyEstimator(id_, camera_, options_, seed_);
  beginnings_ = beginnings;
}

bool BodyEstimator::start(const PerceivedFrame& frame, const BodyObservation& body) {
  const auto center = can_start(body) ? shape_.start(frame, body) : std::nullopt;
  if (!center) return false;
  Pose world_from_body;
  world_from_body.translation = *center;
  short_window_.start(frame, body, world_from_body);
  shape_.add_keyframe(short_window_.keyframes().back(), body);
  remember(frame, world_from_body, Matrix6d::Zero());
  keyframes_ = 1;
  sure_ns_ = frame.stamp_ns;
  sure_frame_ = frame.frame;
  return true;
}

// Whether each outline may be the body's, as it has been seen up to now.
bool BodyEstimator::has_own_outline(const PerceivedFrame& frame, const BodyObservation& body) const {
  if (keyframes_ < options_.lifecycle.confirm_keyframes) return true;
  const Pose camera_from_body = frame.world_from_camera->inverse() * predict(frame, &body);
  const auto is_own = [&](const std::optional<Silhouette>& outline) {
    return !outline || outlines_.may_be(camera_, *outline, frame.stamp_ns, camera_from_body, body_center());
  };
  return is_own(body.silhouette) && is_own(body.segmented);
}

// Of a body that has not been found again since its first sights no more is known than of a new one.
bool BodyEstimator::was_a_glimpse(double hidden_s) const {
  const LifecycleOptions& o = options_.lifecycle;
  return keyframes_ == 1 || (keyframes_ < o.confirm_keyframes && hidden_s > o.search_after_s);
}

// Of a body in view whose model fits nowhere, for longer than it ever did.
bool BodyEstimator::has_wrong_model(const PerceivedFrame& frame, const BodyObservation& body) {
  if (!options_.lifecycle.drops_models || !is_stale(frame) || !is_whole(*body.silhouette)) return false;
  return ++frames_misfit_ > frames_placed_;
}

std::optional<BodyPose> BodyEstimator::track(const PerceivedFrame& frame, const BodyObservation& body) {
  RandomStream random(seed_, "find_pose", frame.frame, id_);
  const auto solution = short_window_.find(frame, body, predict(frame, &body), is_stale(frame), random);
  if (!solution || gives_way(frame, body, solution->camera_from_body)) return std::nullopt;
  BodyPose pose = short_window_.take(frame, body, *solution);
  const Shape shape = shape_.shape();
  pose.information +=
      surface_information(camera_, body, frame.world_from_camera->inverse() * pose.world_from_body,
                          shape.body_from_object, shape.superellipsoid(), options_.alignment);
  return pose;
}

// Where the surface that is known says that the features have slid off it, it counts.
void BodyEstimator::settle(const PerceivedFrame& frame, const BodyObservation& body, BodyPose& pose) {
  if (come_back(frame, body, pose.world_from_body)) {
    pose.sighted = pose.world_from_body;
    short_window_.start(frame, body, pose.world_from_body);
    return;
  }
  const auto found = align_to_cloud(camera_, body, shape_.surface(),
                                    frame.world_from_camera->inverse() * pose.world_from_body, kSettleSigmas,
                                    false, options_.alignment);
  if (!found || found->new_face) return;
  if (found->predicted_distance_m < kSlid * found->distance_m + kSlidBy) return;
  pose.world_from_body = pose.sighted = in_world(frame, found->camera_from_body);
  pose.information = found->information;
  short_window_.start(frame, body, pose.world_from_body);
}

// What was seen of the body before it strayed; on the sides that were not seen its shape, where that is
// known.
SurfaceModel BodyEstimator::surface_of_before() const {
  SurfaceModel surface = strayed_->surface();
  const Shape shape = strayed_->shape();
  if (!options_.alignment.impacts || surface.points.cols() == 0 || !is_known_all_around(shape))
    return surface;
  surface.body_from_object = shape.body_from_object;
  surface.shape = shape.superellipsoid();
  assume_unseen(surface);
  return surface;
}

// Over a new face the body went on by its outline alone. On the surface of before again, that is where it is,
// and what was seen in between is where nobody knows exactly.
bool BodyEstimator::come_back(const PerceivedFrame& frame, const BodyObservation& body,
                              Pose& world_from_body) {
  if (!strayed_) return false;
  const auto found =
      align_to_cloud(camera_, body, surface_of_before(), frame.world_from_camera->inverse() * world_from_body,
                     kStraySigmas, false, options_.alignment);
  if (!found || found->matched < kBack) return false;
  world_from_body = in_world(frame, found->camera_from_body);
  shape_.go_back_to(*strayed_);
  strayed_.reset();
  return true;
}

BodyPose BodyEstimator::stand_still(const PerceivedFrame& frame) const {
  BodyPose pose;
  pose.world_from_body = recent_.back().world_from_body;
  pose.information = Matrix6d::Identity() / (kStill * kStill);
  const std::int64_t gap_ns = nanoseconds(options_.short_window.keyframe_gap_s);
  pose.keyframe = frame.stamp_ns / gap_ns != recent_.back().stamp_ns / gap_ns;
  return pose;
}

bool BodyEstimator::is_stale(const PerceivedFrame& frame) const {
  return frame.frame > sure_frame_ + 1 &&
         seconds(sure_ns_, frame.stamp_ns) > options_.lifecycle.search_after_s;
}

void BodyEstimator::place_center(Pose& world_from_body, const Eigen::Vector3d& at) const {
  world_from_body.translation = at - world_from_body.rotation * body_center();
}

// Where it is by how far the middle of its points moved, of a body of which nothing is hidden: one that flies
// or bounces does not keep its velocity.
std::optional<Eigen::Vector3d> BodyEstimator::center_by_points(const PerceivedFrame& frame,
                                                               const BodyObservation& body) const {
  const Tracked& last = recent_.back();
  const auto middle = options_.lifecycle.follows_points ? middle_of(frame, body) : std::nullopt;
  if (!middle || !last.middle) return std::nullopt;
  return Eigen::Vector3d(last.world_from_body * body_center() + *middle - *last.middle);
}

// The body is in view and too few of its points are found again: its surface places it. When that goes on,
// the short window starts anew from there.
std::optional<BodyPose> BodyEstimator::align(const PerceivedFrame& frame, const BodyObservation& body) {
  const auto found = aligned(frame, body);
  if (!found) return std::nullopt;
  BodyPose pose;
  pose.world_from_body = pose.sighted = in_world(frame, found->camera_from_body);
  if (options_.lifecycle.weighs_evidence && !is_stale(frame) && is_out_of_reach(frame, pose.world_from_body))
    return std::nullopt;
  pose.information = found->information;
  const int unfound = frames_unfound_ + 1, enough = options_.lifecycle.restart_frames;
  const bool sure = (is_whole(*body.silhouette) && found->matched > LifecycleOptions::sure_share) ||
                    unfound >= kPatience * enough;
  const bool young = keyframes_ < options_.lifecycle.confirm_keyframes;  // each view is needed
  pose.keyframe = is_stale(frame) ? unfound >= enough && sure : young || found->new_face || unfound >= enough;
  if (!pose.keyframe) return pose;
  if (found->new_face && !strayed_)
    strayed_ = shape_;
  else
    come_back(frame, body, pose.world_from_body);
  pose.sighted = pose.world_from_body;
  short_window_.start(frame, body, pose.world_from_body);
  return pose;
}

void BodyEstimator::look_again(const PerceivedFrame& frame, const BodyObservation& body, const Pose& expected,
                               BodyState& state) const {
  if (!is_present(state)) return;  // in another frame
  const Pose camera_from_body = frame.world_from_camera->inverse() * expected;
  const auto found = align_to_cloud(camera_, body, shape_.surface(), camera_from_body, kAgainSigmas, false,
                                    options_.alignment);
  if (!found || found->matched < LifecycleOptions::sure_share) return;
  state.world_from_body = in_world(frame, found->camera_from_body);
  state.covariance = covariance_of(found->information);
}

BodyState BodyEstimator::state_at(const PerceivedFrame& frame, const Pose& world_from_body,
                                  const Matrix6d& covariance) const {
  const bool confirmed = keyframes_ >= options_.lifecycle.confirm_keyframes;
  return {frame.frame,
          frame.stamp_ns,
          world_from_body,
          covariance,
          shape_.box(),
          confirmed ? ObjectStatus::active : ObjectStatus::tentative,
          strayed_ ? PoseEvidence::relative : PoseEvidence::absolute,
          beginnings_,
          motion_.now()};
}

}  // namespace uniquadric
