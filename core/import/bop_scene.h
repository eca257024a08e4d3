#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

/// An object in an image, as scene_gt.json lists it.
struct BopInstance {
  int obj_id = 0;    ///< of its model
  int instance = 0;  ///< its place among those of the same model in the image's list, from 0
  Pose camera_from_model;
};

/// What a scene's files say of one image.
struct BopImage {
  std::optional<Pose> camera_from_world;
  std::vector<BopInstance> objects;
};

/// A scene folder of the BOP challenge (bop_toolkit/docs/bop_datasets_format.md), without its images.
struct BopScene {
  std::array<double, 4> intrinsics_px{};  ///< fx, fy, cx, cy of all images
  double depth_units_per_m = 1000;
  std::map<std::int64_t, BopImage> images;  ///< by number; at least one
  bool has_objects = false;                 ///< there is a scene_gt.json
};

/// Reads scene_camera.json and, where it is there, scene_gt.json. Throws InputError with file and image; also
/// where the intrinsics or the depth's scale change.
BopScene read_bop_scene(const std::filesystem::path& folder);

}  // namespace uniquadric
