#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/ellipsoid.h"
#include "core/geometry/superquadric.h"
#include "estimator/factors/pose_prior.h"
#include "estimator/observation/perception.h"

namespace uniquadric {

/// A convex body about the centre of its tight box: the hull of balls, or an ellipsoid (no balls).
struct HullBody {
  struct Ball {
    Eigen::Vector3d center;
    double radius_m = 0;
  };
  std::string name;
  Eigen::Vector3d half_extents_m;
  std::vector<Ball> balls;
};

HullBody hull_box(const std::string& name, const Eigen::Vector3d& half_extents_m, double edge_radius_m = 0);
HullBody hull_ellipsoid(const std::string& name, const Eigen::Vector3d& semi_axes_m);
/// 4.4 x 1.8 x 1.5 m, a cabin on its middle.
HullBody hull_car();
/// The five bodies of the table: cuboid, cube, ellipsoid, rounded box, car.
std::vector<HullBody> arc_bodies();

/// Offset of the support line of the body's image: the largest n . pixel [px].
double support_px(const HullBody& body, const Camera& camera, const Pose& camera_from_body,
                  const Eigen::Vector2d& normal);

/// Views of a body from an arc, and what the short window would give with them.
struct ArcOptions {
  double arc_rad = 0.698;  ///< 40 degrees
  int views = 25;
  double noise_px = 1;                        ///< of each line
  int directions = 16;                        ///< 4: the sides of the RotBbox
  double drift_m = 0.001, drift_rad = 0.001;  ///< of the body's pose from view to view, a random walk
  int exponents = 1;                          ///< 0: the quadric, q = 2
  bool hard = true;                           ///< the poses stay as they drifted; else a prior of `rigid`
  PoseSigmas rigid{0.004, 0.004};
  double first_exponent = 1.3;
  bool sides = false;  ///< the body's +x, +y and +z sides are known too, within 4 mm and 0.01 rad
  bool conic = false;  ///< Eq. 14's vector form on the RotBbox instead of tangents
};

struct ArcResult {
  double iou = 0;                 ///< of the ellipsoid with the true inscribed one, mean over the views
  double rotation_error_rad = 0;  ///< of the offset
  Eigen::Vector3d axis_ratio = Eigen::Vector3d::Zero();  ///< estimated over true semi-axes
  SuperExponents exponents;
  double milliseconds = 0;  ///< of the solve
};

/// Estimates offset, axes and exponents from the views' lines, starting 0.2 rad, 15 % of the size and a
/// factor of 0.7 to 1.4 in each axis off. All draws are of (seed, trial).
ArcResult run_arc(const HullBody& body, const ArcOptions& options, int trial);

}  // namespace uniquadric
