#pragma once

#include <Eigen/Core>
#include <numbers>
#include <optional>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

/// Where an outline touches one of its tangents, in the camera's frame.
struct OutlineTouch {
  Eigen::Vector3d normal;    ///< unit, outward, of the plane through the camera and the tangent
  Eigen::Vector3d from, to;  ///< along the lines of sight between which it touches
};

/// Points of one view of a body.
struct PointView {
  Pose body_from_camera;
  const Eigen::Matrix3Xd *points = nullptr,
                         *normals = nullptr;  ///< (3 x n) camera frame [m] (smoothed_points)
  Eigen::Matrix3Xd rays{};  ///< (3 x n) unit vectors to the points; empty where `touches` are not looked at
  double rim_m = 0;         ///< by which the points end before the outline of a body with edges
  /// Angle at the middle of an ellipsoid between its foremost point and those that end before its outline
  /// [rad].
  double horizon_rad = std::numbers::pi / 2;
  /// Unit vectors across the image to where something hid a part of the body, or the image ended.
  std::vector<Eigen::Vector2d> cut = {};
  std::vector<OutlineTouch> touches = {};  ///< where nothing hides the body
};

/// How far a body reaches along a direction.
struct Reach {
  double position_m = 0;
  int views = 0;        ///< that show the end itself; none: the body reaches so far at least
  bool is_cut = false;  ///< on this side in every view: how much further is not known
  double spread_m = 0;  ///< standard deviation over those views (from the median deviation)
};

/// All numbers are ours.
struct ReachOptions {
  double top_share = 0.01;      // of a view's points, whose mean is an end that has no surface of its own
  double surface_depth = 0.15;  // share of the body's extent within which its end surface is looked for
  double min_cosine = 0.7;      // of that surface's normals and the direction
  int min_points = 40;          // on it
  double max_scatter = 0.25;    // about it, of that depth
  double stray_share = 0.1;     // of all points that may lie beyond it: what the body stands on, in its mask
  double min_sine = 0.25;       // of the angle between the touching plane and the line to the camera
  double cut_cosine = 0.5;      // of the angle from a cut within which an end may be hidden: 60 degrees
  double cut_off_cosine = 0.8;  // of that angle within which it is beyond the cut
  double least_quantile = 0.9;  // of all views where none shows the end: one view's outliers do not count
};

/// Mean of the share of points (3 x n, at least 3) that is furthest along a direction (unit), along it.
double mean_of_furthest(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& direction, double share);

/// From the points of many views; `direction`: unit, in the body's frame. A body shows its furthest point to
/// every camera beyond the plane that touches it there, unless it is cut on that side: the median of those
/// views counts. Nothing without points.
std::optional<Reach> reach_along(const std::vector<PointView>& views, const Eigen::Vector3d& direction,
                                 const ReachOptions& options = {});

}  // namespace uniquadric
