#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/features/patch_alignment.h"
#include "estimator/features/surface_descriptor.h"
#include "estimator/images/plane_depth.h"

namespace uniquadric {

/// A point of a body as its sightings agree on it.
struct TrackLandmark {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();        ///< frame of the body's map [m]
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of the mean [1/m^2]
  Eigen::Vector3d normal_sum = Eigen::Vector3d::Zero();   ///< of its surface's normals, outward, weighted
  int sightings = 0;
  SurfaceElement surface() const { return {point, normal_sum.normalized()}; }
};

/// A feature that is being followed, or was.
struct PointTrack {
  std::int64_t id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();        ///< raw image
  Eigen::Vector2d at_stamp = Eigen::Vector2d::Zero();     ///< raw: where it would be seen at the stamp
  Eigen::Vector2d undistorted = Eigen::Vector2d::Zero();  ///< the same
  std::optional<PlaneDepth> depth;                        ///< of the present frame
  std::optional<TrackLandmark> landmark;
  std::optional<PatchAnchor> anchor;
  std::vector<SurfaceDescriptor> descriptors;  ///< when it was found
  int map = 0;                                 ///< of its body, that the landmark belongs to
  int missed = 0;                              ///< frames in a row off its mask
  int failures = 0;                            ///< times that it moved otherwise than its body
  int tries = 0;                               ///< times that a lost track was looked for in vain
};

/// What is known of one rigid body, or of the background (label 0). A map is a set of landmarks with known
/// places to each other, in the frame of the camera when it was begun; after a time of blindness a new one is
/// begun, until both turn out to show the same.
struct TrackedBody {
  int label = 0;
  std::vector<PointTrack> tracks;
  std::vector<PointTrack> gallery;      ///< lost tracks with landmarks, the first lost first
  int map = 0, maps = 1;                ///< the present map, and how many were begun
  std::optional<Pose> camera_from_map;  ///< at the last frame
  std::map<int, Pose> left;             ///< camera_from_map of maps that were lost, as if at rest since
  std::optional<Pose> motion;           ///< in the camera's frames, over the last step
  std::int64_t motion_ns = 0;           ///< how long that step was
  Vector6d twist = Vector6d::Zero();    ///< by which its tracks were moved to the stamp (rolling_shutter.h)
  bool twist_known = false;             ///< false: presumed, and all landmarks with it
};

/// Where the map is expected after another `step_ns`, at constant velocity in the camera's frame.
std::optional<Pose> predicted_pose(const TrackedBody& body, std::int64_t step_ns);

/// A point's place in the camera frame and the information of it, from pixel and depth.
struct SeenPoint {
  Eigen::Vector3d point;
  Eigen::Matrix3d information;
};
SeenPoint seen_point(const Camera& camera, const PointTrack& track, double pixel_sigma);

/// Adds the present sighting to a track's landmark, up to `most` of them: a mean that follows for ever would
/// drift along with the pose.
void add_sighting(PointTrack& track, const Camera& camera, const Pose& camera_from_map, double pixel_sigma,
                  int most);

/// Puts a lost track into the gallery, if it has the sightings to be worth it; drops the first ones when it
/// is full.
void retire(TrackedBody& body, PointTrack track, int min_sightings, int most_tracks);

/// Takes the present map for a part of another one: map_from_present carries its points over.
void join_map(TrackedBody& body, int map, const Pose& map_from_present);

}  // namespace uniquadric
