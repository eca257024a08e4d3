#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/ego/ego_map.h"
#include "estimator/images/rigid_motion.h"

namespace uniquadric {

/// A frame's place: known at once, mended by what becomes of its keyframe and, as long as its features are
/// kept, of the points it saw.
struct FramePose {
  std::int64_t frame = 0, stamp_ns = 0;
  int keyframe = 0;  ///< index in the map
  Pose camera_from_keyframe;
  std::vector<Feature> features;
  std::optional<Pose> motion{};  ///< of the background since the frame before
  std::optional<Vector6d>
      presumed_twist{};     ///< of the background, where the features are still at their rows
  bool is_bridged = false;  ///< placed by `motion` alone
};

/// The features of a frame whose points the map has.
std::vector<PointSighting> sightings_of(const EgoMap& map, const std::vector<Feature>& features);

/// Finds camera_from_world of frames in a map. `seed`: of RANSAC's stream, which is the frame's own.
struct MapLocator {
  Camera camera;  ///< without distortion
  RigidMotionOptions pose;
  std::uint64_t seed = 0;
  double rolling_shutter_s = 0;

  /// Nothing where too few features agree.
  std::optional<RigidMotion> locate(const EgoMap& map, const std::vector<Feature>& features,
                                    const std::optional<Pose>& prior, std::int64_t frame) const;
  /// The same of a frame, whose features may still be at their rows.
  std::optional<Pose> locate(const EgoMap& map, const FramePose& frame, const Pose& prior) const;
  /// By what the map has become, of a frame that was placed by it.
  Pose found_again(const EgoMap& map, const FramePose& frame) const;

 private:
  std::optional<Pose> locate_rows(const EgoMap& map, const FramePose& frame, const Pose& prior) const;
};

}  // namespace uniquadric
