#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "estimator/base/point_tree.h"
#include "estimator/window/cloud_alignment.h"

namespace uniquadric {

/// A point of a frame's cloud.
struct CloudPoint {
  Eigen::Vector3d position, normal;  ///< camera frame
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
};

/// At most so many points of a body's cloud, evenly chosen; none without normals.
std::vector<CloudPoint> evenly_drawn(const BodyObservation& body, int most);

inline constexpr double kNeighbourEvidence = 0.1;  ///< of each residual: neighbours err together
inline constexpr double kLeastDepth_m = 0.1;       ///< of a body that has an outline

/// By a right-hand perturbation of the body's pose: of the distance of a point, in the body's frame, from a
/// plane of the surface with normal n.
Vector6d point_row(const Eigen::Vector3d& p, const Eigen::Vector3d& n);

/// And of how far a point of the body, p in the camera's frame, lies beyond a tangent.
Vector6d line_row(const Camera& camera, const SupportLine& line, const Pose& camera_from_body,
                  const Eigen::Vector3d& p);

/// Of a pose away from where it was expected: half the sum of squared sigmas.
double way_cost(const Pose& expected, const Pose& pose, const PoseSigmas& sigmas);

/// One fit of a cloud and an outline to a surface.
struct CloudFit {
  Pose pose;
  Matrix6d information = Matrix6d::Zero();
  double cost = std::numeric_limits<double>::infinity();
  double matched = 0, distance_m = 0;
  double outline_px = 0, beyond_px = 0;  ///< mean distance off the tangents; of it what lies outside
};

/// How much work a fit may be.
struct FitEffort {
  int iterations;
  std::size_t stride;  ///< of the points that are used
};

/// Fits a frame's cloud and outline to one surface, from as many starts as wanted. Camera, model and options
/// have to outlive it.
class CloudAligner {
 public:
  CloudAligner(const Camera& camera, const BodyObservation& body, const SurfaceModel& model,
               const Pose& predicted, const PoseSigmas& sigmas, const CloudAlignmentOptions& options);

  /// Of tangents that nothing cuts.
  std::ptrdiff_t lines() const { return std::ssize(lines_); }

  /// Mean distance of the points off the surface.
  double distance_at(const Pose& pose) const;

  /// Of infinite cost where the body comes behind the camera.
  CloudFit fit_from(const Pose& start, const FitEffort& effort) const;

  /// Of cloud and outline; infinite where the body is not in front of the camera.
  double surface_disagreement(const Pose& pose) const;

  /// Whether most of the points are where the body is: an outline alone fits a small body far away as well.
  bool holds_points(const Pose& pose) const;

  /// Of how the points' colours differ from the model's there. Where it has none they may be any.
  double color_cost(const Pose& pose, std::size_t stride) const;

 private:
  // A point of the body that is furthest along a tangent's normal, and how far it lies beyond the tangent.
  struct OutlineEnd {
    Eigen::Vector3d position;  // camera frame
    double beyond_px = 0;
  };

  struct CauchyEquations;

  std::optional<int> partner_of(const CloudPoint& seen, const Pose& body_from_camera, double reach_m) const;
  void add_points(CloudFit& fit, double reach_m, std::size_t stride, CauchyEquations& equations) const;
  OutlineEnd end_of(const SupportLine& line, const Eigen::Vector3d& p) const;
  std::optional<OutlineEnd> end_along(const SupportLine& line, const Pose& camera_from_body,
                                      const OutlineEnd& seen) const;
  bool add_outline(CloudFit& fit, CauchyEquations& equations) const;
  double add_prior(const Pose& pose, CauchyEquations& equations) const;

  const Camera& camera_;
  const SurfaceModel& model_;
  Pose predicted_;
  PoseSigmas sigmas_;
  const CloudAlignmentOptions& options_;
  std::vector<CloudPoint> seen_;
  std::vector<SupportLine> lines_;
  bool is_colored_;
  Eigen::Matrix3Xd points_, normals_;  // of the model: seen ones first, then assumed ones
  Eigen::AlignedBox3d bounds_;
  PointTree tree_;  // of all these
};

}  // namespace uniquadric
