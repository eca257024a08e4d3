#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// How a body moves: velocity of its middle [m/s] and turn rate [rad/s], both along the world's axes.
struct BodyTwist {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< world, a place on the body
  Vector6d rate = Vector6d::Zero();
  Matrix6d covariance = Matrix6d::Identity();
};

/// All numbers are ours.
struct BodyTwistOptions {
  double first_velocity_mps = 10, first_turn_radps = 0.7;  // standard deviations of what nothing is known of
  double acceleration_mps2_rthz = 1.5, turn_acceleration_radps2_rthz = 1;
  double reach_px = 20;                  // of a point's neighbours
  static constexpr int neighbours = 12;  // that a plane is laid through
  double max_jump = 0.06;                // relative depth to a neighbour: with what an unknown motion adds
  int max_points = 500;                  // of a body
  double pixel_sigma = 0.3;
  // Points are looked at in several frames and as neighbours of many: so many rows count as one
  static constexpr double rows_as_one = 10;
};

/// A point of a body where the sensor saw it, in the world.
struct AgedPoint {
  Eigen::Vector3d world = Eigen::Vector3d::Zero();
  double age_s = 0;  ///< since it was seen
};

/// A point of a body now, and where the camera saw it in the frame before (undistorted).
struct PointStep {
  Eigen::Vector3d world = Eigen::Vector3d::Zero();
  Eigen::Vector2d last_pixel = Eigen::Vector2d::Zero();
};

/// Of which nothing but a place is known.
BodyTwist unknown_twist(const Eigen::Vector3d& middle, const BodyTwistOptions& options);

/// What the body's points are moved by in some seconds: a screw, as of wheels and thrown bodies in short
/// times.
Pose moved_over(const BodyTwist& twist, double seconds);

/// Some seconds later.
void predict(BodyTwist& twist, double seconds, const BodyTwistOptions& options);

/// The motion that lays points of different ages on one surface: each on the plane through its neighbours in
/// the image, all put where they are now (Eq. 4). A LiDAR's ranges tell speed along the line of sight far
/// better than depth from frame to frame does, whose errors are those of the motion that was undone: undoing
/// it by motions found from it swings up. `camera` is without distortion.
void update_by_points(BodyTwist& twist, const std::vector<AgedPoint>& points, const Pose& camera_from_world,
                      const Camera& camera, const BodyTwistOptions& options);

/// The motion that brings points back to where they were seen `step_s` ago: across the line of sight.
void update_by_pixels(BodyTwist& twist, const std::vector<PointStep>& steps,
                      const Pose& last_camera_from_world, double step_s, const Camera& camera,
                      const BodyTwistOptions& options);

}  // namespace uniquadric
