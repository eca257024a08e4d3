#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/perception/plane_depth.h"

namespace uniquadric {

/// A point of a body as its sightings agree on it.
struct Landmark {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();        ///< frame of the body's map [m]
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of the mean [1/m^2]
  int sightings = 0;
};

/// A feature that is being followed.
struct PointTrack {
  std::int64_t id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();        ///< raw image
  Eigen::Vector2d undistorted = Eigen::Vector2d::Zero();  ///< the same
  std::optional<PlaneDepth> depth;                        ///< of the present frame
  std::optional<Landmark> landmark;
  int missed = 0;  ///< frames in a row off its mask
};

/// What is known of one rigid body, or of the background (label 0). Its map has the frame of the camera when
/// it was begun.
struct TrackedBody {
  int label = 0;
  std::vector<PointTrack> tracks;
  std::optional<Pose> camera_from_map;  ///< at the last frame
  std::optional<Pose> motion;           ///< in the camera's frames, over the last step
  std::int64_t motion_ns = 0;           ///< how long that step was
};

/// Where the map is expected after another `step_ns`, at constant velocity in the camera's frame.
std::optional<Pose> predicted_pose(const TrackedBody& body, std::int64_t step_ns);

/// A point's place in the camera frame and the information of it, from pixel and depth.
struct SeenPoint {
  Eigen::Vector3d point;
  Eigen::Matrix3d information;
};
SeenPoint seen_point(const Camera& camera, const PointTrack& track, double pixel_sigma);

/// Adds a sighting to a landmark, up to `most` of them: a mean that follows for ever would drift along with
/// the pose.
void add_sighting(std::optional<Landmark>& landmark, const SeenPoint& seen, const Pose& camera_from_map,
                  int most);

}  // namespace uniquadric
