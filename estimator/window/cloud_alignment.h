#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/geometry/superquadric.h"
#include "estimator/factors/pose_jacobian.h"
#include "estimator/factors/pose_prior.h"
#include "estimator/observation/perception.h"
#include "estimator/window/pose_solver.h"

namespace uniquadric {

/// What has been seen of a body's surface, in the body's frame.
struct SurfaceModel {
  Eigen::Matrix3Xd points, normals;        ///< (3 x n) [m]; unit, outward
  Eigen::Matrix3Xf colors;                 ///< of the points, CIE L*a*b*; (3 x 0) where they are not known
  std::optional<Pose> body_from_object{};  ///< its axes: turned about them by quarters it looks much the same
  std::optional<Superellipsoid>
      shape{};  ///< about body_from_object, where it is known well enough to say more
  Eigen::Matrix3Xd assumed_points{}, assumed_normals{};  ///< of the shape where nothing of it has been seen
};

/// How a body that shows too few of its features is found by its surface. All numbers are ours.
struct CloudAlignmentOptions {
  bool impacts = true;  // what hits something moves on as nothing foretold, and turns up new faces
  static constexpr int max_points = 200;  // of the frame's cloud
  // of a smoothed point off the model's plane: its voxels' roughness
  static constexpr double point_sigma_m = 0.005;
  // of a tangent about the model's points, whose outline is not complete
  static constexpr double outline_sigma_px = 2;
  // within which a point's partner is looked for: at first, and at last
  static constexpr double far_m = 0.08, near_m = 0.015;
  static constexpr double min_normal_cosine = 0.5;  // of a point's normal and its partner's
  // share of the points that lie on the model, or it is a face not seen yet
  static constexpr double min_matched = 0.5;
  static constexpr int min_lines = 10;  // free tangents that will do instead, soon after the last pose
  // their mean distance from its planes beyond which it is not found
  static constexpr double max_distance_m = 0.006;
  static constexpr double max_outline_px = 5;  // the same of the tangents
  // or this, of the outline's width, where it is more: masks of large things err more
  static constexpr double max_outline_share = 0.05;
  // starts turned by so much about each axis, and twice, three times that, where the prediction is stale
  static constexpr double turn_rad = 0.5;
  static constexpr int turns = 3;
  static constexpr double color_sigma =
      12;  // [1] of a point's colour, CIE L*a*b*: texture between voxels, light, noise
};

struct CloudAlignment {
  Pose camera_from_body;
  /// What the frame says, without the prediction: of a right-hand perturbation (translation, rotation
  /// vector). None of the turn of a blank ball.
  Matrix6d information;
  double matched = 0;                               ///< share of the points that lie on the model
  double distance_m = 0, predicted_distance_m = 0;  ///< mean off the model, here and at the predicted pose
  bool new_face = false;                            ///< fewer than there should be
};

/// Of a prediction's sigmas, where an impact changed the motion.
PoseSigmas after_impact(const PoseSigmas& sigmas);

/// Pose of a body of known surface from one outline and depth cloud (3 x n, camera frame, noise taken off)
/// and a predicted camera_from_body with its sigmas: iterated closest points, point to plane; the outline's
/// tangents touch the model's points, or its shape where that agrees with them; one that only what was not
/// seen reaches says nothing. `stale`: tries starts that are turned about the predicted one, and then the
/// object's other sides; of each lot the best by rough fits. Nothing where it does not fit.
std::optional<CloudAlignment> align_to_cloud(const Camera& camera, const BodyObservation& body,
                                             const SurfaceModel& model, const Pose& predicted,
                                             const PoseSigmas& sigmas, bool stale,
                                             const CloudAlignmentOptions& options);

/// What a frame has against a pose, as halves of sums of squared sigmas: its cloud and outline about the
/// known surface, the way from where the body was expected, and the sightings of its points.
struct Disagreement {
  double surface = 0, way = 0, sightings = 0;
  double all() const { return surface + way + sightings; }
};

/// Of each of `poses` (camera_from_body). The body is expected at one of `expected`, with one of those
/// sigmas. A point of the cloud without a partner counts as one at the end of its reach, a sighting off its
/// point no more than one at the gate: those about the outline, which vouch for nothing, not at all.
std::vector<Disagreement> disagreements(const Camera& camera, const BodyObservation& body,
                                        const SurfaceModel& model,
                                        const std::vector<LandmarkSighting>& sightings,
                                        const PoseSolverOptions& solver, const std::vector<Pose>& expected,
                                        const PoseSigmas& sigmas, const std::vector<Pose>& poses,
                                        const CloudAlignmentOptions& options);

/// What a frame's cloud and outline say of the pose of a body of known shape: of a right-hand perturbation of
/// camera_from_body (translation, rotation vector). Normals are the shape's, as noise of measured ones would
/// tell how far a ball has turned.
Matrix6d surface_information(const Camera& camera, const BodyObservation& body, const Pose& camera_from_body,
                             const Pose& body_from_object, const Superellipsoid& shape,
                             const CloudAlignmentOptions& options);

}  // namespace uniquadric
