#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/geometry/superquadric.h"
#include "core/sequence/tracks.h"
#include "estimator/factors/pose_prior.h"
#include "estimator/observation/perception.h"

namespace uniquadric {

/// How the outline of a body enters.
enum class SemanticFactor {
  none,
  literal,  ///< Eq. 14 as printed: sqrt(2 e_B)
  vector,   ///< Eq. 14, our 5-vector
  tangent,  ///< the outline's tangents touch the body (SPEC 3 in short: h(n) + n . t + d = 0)
};
/// Which outline.
enum class Outline {
  bbox,      ///< the upright box's four sides
  rot_bbox,  ///< the RotBbox's four sides: the paper's
  hull,      ///< the convex hull's tangents in K directions
};
/// Where the axes' prior comes from (Eq. 15).
enum class AxisPrior { none, mean, inverse_variance, renyi, literal };
/// What is fused to it, of each keyframe.
enum class AxisSamples {
  boxes,    ///< the axes of Alg. 1's box: the paper's
  extents,  ///< those of its points along the body's axes, each with what a view may hide of it
};
/// What an ellipse's outline is uncertain by.
enum class OutlineNoise {
  given,     ///< outline_sigma_px
  measured,  ///< what the outlines are off the priors' ellipsoid or the last shape by, and no less
             ///< than outline_sigma_px
};
/// What holds the body's poses to the short window's (Eq. 16).
enum class RigidPrior {
  none,
  soft,  ///< a factor a pose
  hard,  ///< the poses are the short window's
};

struct LongWindowOptions {
  int keyframes = 25;  // paper: 20-25
  SemanticFactor semantic = SemanticFactor::tangent;
  Outline outline = Outline::hull;
  // ours: 0 is the ellipsoid (q = 2), 1 the superellipsoid, 3 the one whose outline and profiles along z have
  // exponents of their own
  int exponents = 3;
  std::optional<SuperExponents> held_exponents;  // of a body that is known to be of this kind
  double profile_sigma = 0.02;    // ours: of three, by which the profiles above and below z = 0 differ
  double outline_sigma_px = 1.0;  // ours: of one tangent, docs/estimator/perception.md
  OutlineNoise outline_noise = OutlineNoise::given;
  // ours: outlines that a mask tracker carried no longer count once segmented ones have come: without depth
  // edges to hold them they are pixels off on the side where a body uncovers what is behind it
  bool segmented_outlines = false;
  AxisPrior axis_prior = AxisPrior::none;  // ours: depth points say more, where they are seen
  AxisSamples axis_samples = AxisSamples::boxes;
  RigidPrior rigid_prior = RigidPrior::hard;
  PoseSigmas rigid_sigmas{0.003, 0.006};  // ours: what short windows reach on the simulated scenes
  bool surface_points = true;             // ours: depth says where the surface is along the view
  double surface_sigma_m = 0.01;          // ours: of an averaged point of the cloud against a superellipsoid
  // ours: and no less than so many radii of the body: what is large has panes, doors and wheels off the
  // surface
  static constexpr double surface_sigma_radii = 0.02;
  bool extents = true;        // ours: where the body ends along its axes is what its points say, where seen
  bool box_by_points = true;  // ours: of a body that is not convex, the points tell the box's axes
  bool contacts = true;       // ours: what stands on a plane ends there, and stands on a face
  // ours: of the offset about its start, a solve: a ball has no axes to be found, what nothing holds stays
  PoseSigmas offset_sigmas{0.1, 0.05};
  // ours: in their place where covariances are made: a start is no evidence, so as good as none
  PoseSigmas covariance_offset_sigmas{1, 1.8};
  int max_iterations = 15;
};

/// What the long window finds: 3 + 6 + 1 (or 3) numbers that belong to the body, not to a frame.
struct Shape {
  Pose body_from_object;  ///< the common offset: centre and axes in the short window's frame of the body
  Eigen::Vector3d semi_axes_m = Eigen::Vector3d::Ones();
  SuperExponents exponents;  ///< all equal unless the options say three
  int profile_axis = 2;      ///< otherwise than z only where its axes were named anew
  /// Variances: semi-axes, translation, rotation vector, as in ObjectState.
  Vector9d variances = Vector9d::Constant(std::numeric_limits<double>::quiet_NaN());

  Superellipsoid superellipsoid() const { return {semi_axes_m, exponents, profile_axis}; }
};

/// One keyframe as the long window keeps it.
struct ShapeView {
  std::int64_t frame = 0;
  Pose world_from_camera, world_from_body;  ///< as the short window left them
  Silhouette silhouette;
  Eigen::Matrix3Xd points, normals;  ///< of depth (3 x n), camera frame [m], if their noise was taken off
  std::optional<ContactPlane> contact{};  ///< what the body stood on, camera frame
};

/// A prior on the semi-axes (Eq. 15), each with its own sigma.
struct AxisBelief {
  Eigen::Vector3d semi_axes_m, sigma_m;
};

/// A side on which a body stood: a plane that touches it from outside, in its frame.
struct ContactSide {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< outward, unit
  double position_m = 0, sigma_m = 0;                    ///< along it, from the frame's origin
  double sigma_rad = 0;                                  ///< of the direction
};

/// What depth says of the shape, in the body's frame.
struct DepthEvidence {
  Eigen::Matrix3Xd surface_points;  ///< (3 x n) [m]
  std::vector<ContactSide> contacts;
};

struct ShapeSolution {
  Shape shape;
  double cost = 0;
  double outline_px = 0;  ///< where it is measured: how far tangents are off it, 1.48 medians; 0: none
};

/// Sigma of a surface point of a body whose first sphere has this radius [m].
inline double surface_sigma_m(const LongWindowOptions& options, double radius_m) {
  return std::max(options.surface_sigma_m, options.surface_sigma_radii * radius_m);
}

// Both ours.
inline constexpr double kHeldTurn = 1e-4;  ///< [rad] rotation sigma of an offset whose axes are to stay
inline constexpr double kTurnGain = 4;  ///< of the cost, for which axes turn: 8 of chi-square for 3 numbers

/// Solves for the shape from views, depth and priors on the axes, from
/// `start`.
ShapeSolution solve_shape(const Camera& camera, const std::vector<ShapeView>& views,
                          const DepthEvidence& depth, const std::vector<AxisBelief>& axes, const Shape& start,
                          const LongWindowOptions& options);

/// How far the observed outlines are off those of a shape, as the sigma of one [px]: root mean square over
/// the views that a conic is made of, times the root of their number, since all may share one reason. Nothing
/// without such views.
std::optional<double> outline_misfit_px(const Camera& camera, const std::vector<ShapeView>& views,
                                        const Shape& shape, const LongWindowOptions& options);

/// The four sides of a silhouette's RotBbox as lines.
std::array<SupportLine, 4> sides_of(const Silhouette& silhouette);

/// Keeps `most` views: the one that looks most like another goes, the older of the two.
void thin_views(std::vector<ShapeView>& views, int most);

}  // namespace uniquadric
