#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/ellipsoid.h"
#include "core/geometry/pose.h"
#include "core/sequence/trajectory.h"

namespace uniquadric {

/// A tangent of a silhouette's convex hull: normal . pixel <= offset_px for every pixel of the mask, whose
/// outline runs half a pixel outside its outer pixel centres. Image axes: x right, y down.
struct SupportLine {
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  ///< unit length, outward
  double offset_px = 0;
  bool free = true;  ///< false: what it touches is the image's border or an occluder's edge, not the body
};

/// The outline of a body in one image, as the long window observes it. Pixels are those of the image as it
/// is; a lens with distortion is undone first, so that lines are lines.
struct Silhouette {
  Ellipse rot_bbox;                   ///< RotBbox: rectangle of least area about the outline
  std::array<bool, 4> side_free{};    ///< of the sides at +major, -major, +minor, -minor
  std::vector<SupportLine> support;   ///< in K directions, the first along +x, counted from x to y
  std::array<SupportLine, 4> bbox{};  ///< upright box: +x, +y, -x, -y
  double area_px = 0;
  bool segmented = false;  ///< from the segmenter's mask of this frame; else from the mask tracker's
  /// The first frame at which an estimator that runs along may know it: a segmenter's result comes late.
  std::int64_t known_at_frame = 0;
};

/// Whether nothing hides a part of the outline.
inline bool is_whole(const Silhouette& silhouette) {
  return std::all_of(silhouette.support.begin(), silhouette.support.end(),
                     [](const SupportLine& line) { return line.free; });
}

/// One sighting of a point of a body (or of the background).
struct Feature {
  std::int64_t track = 0;  ///< the same for all sightings of one point, over the whole sequence
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  double depth_m = 0;                               ///< z of the camera frame; 0: not measured
  double depth_sigma_m = 0;                         ///< its standard deviation, where measured
  /// What is looked at about it shows the outline, too: it may be a place on that, not on the body.
  bool rim = false;
};

/// A plane that a body stands on, in the camera's frame: normal . p + offset_m is a point's height above it.
struct ContactPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, towards the body
  double offset_m = 0;
  double noise_m = 0;  ///< of one pixel's point off it
};

/// What one frame shows of one body.
struct BodyObservation {
  int id = 0;                            ///< of the mask tracker, positive
  std::optional<Silhouette> silhouette;  ///< as known at its frame; nothing: hidden, or too small a mask
  std::optional<Silhouette> segmented;   ///< the segmenter's of the same frame, where it came later
  std::vector<Feature> features;
  Eigen::Matrix3Xd points;   ///< from depth under the mask, camera frame [m]
  Eigen::Matrix3Xd normals;  ///< of the points, unit, towards the camera; (3 x 0) where none were measured
  Eigen::Matrix3Xf colors;   ///< of the points, CIE L*a*b*; (3 x 0) where no image shows them
  /// Of the points of a scan: whether the body may go on beyond it, behind what is nearer or where the
  /// sensor's view ends. Empty: not known.
  std::vector<bool> cut;
  double row_gap_m = 0;                 ///< between a spinning sensor's rows on it; 0: there are none
  double beam_gap_m = 0;                ///< from beam to beam along a row of it; 0: not known
  std::optional<ContactPlane> contact;  ///< what the body stands on
  /// The first frame at which it may be known that this is a body: of a scan's, by how it moves later.
  std::int64_t known_at_frame = 0;
  std::optional<Pose> motion;  ///< p_now = motion * p_before of the body's points in the two camera frames
};

/// The camera's trajectory (world_from_camera) as known at each frame, a fixed lag after it, and at the end.
struct CameraTrajectories {
  Trajectory causal, fixed_lag, final;
};

/// What is known of a frame besides its bodies.
struct FrameInfo {
  std::int64_t frame = 0, stamp_ns = 0;
  /// As known at the frame, or, where it was not known then, at the end. Nothing: the camera was lost.
  std::optional<Pose> world_from_camera;
  bool camera_came_late = false;        ///< world_from_camera was not known at the frame
  std::optional<Pose> lagged_camera{};  ///< world_from_camera as known a fixed lag after the frame
  std::optional<Pose> final_camera{};   ///< world_from_camera as known at the end
  bool has_masks = false;               ///< whether its masks are known: segmented, or carried to it
  bool depth_refused = false;           ///< its depth image is no measurement, or holds none
  bool depth_changed = false;           ///< from here on depth has another scale than all that was known
};

struct PerceivedFrame : FrameInfo {
  std::vector<BodyObservation> bodies;  ///< in order of their ids
};

}  // namespace uniquadric
