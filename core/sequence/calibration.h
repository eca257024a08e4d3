#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/body_symmetry.h"
#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

class ConfigNode;

/// What the truth says of one object, whatever the time.
struct ObjectDescription {
  int id = 0;
  std::string name;
  Eigen::Vector3d semi_axes_m = Eigen::Vector3d::Ones();  ///< half the extents of the mesh's tight box
  std::string shape;                                      ///< kind of mesh: box, ball, ...; `mesh` for a file
  std::string mesh;                                       ///< file name of a mesh that was loaded, else empty
  std::optional<BodySymmetry> symmetry{};                 ///< as stated; nothing: as shape and semi-axes say
  bool is_scored = true;  ///< false: it is seen, but evaluation has no figures of it and of its tracks
};

/// What a truth folder says of itself as a whole.
struct TruthNotes {
  bool is_partial = false;  ///< `labels: partial`: there are objects that it does not name
  bool in_sensor_frame =
      false;  ///< `frame: sensor`: poses are camera_from_object, as nobody knows the camera's
};

/// truth/objects.yaml. Reading throws InputError with file and line; objects come in order of their ids.
/// `scene_hash` says what scene they are of; empty: not written (recordings).
std::vector<ObjectDescription> read_objects_yaml(const std::filesystem::path& path);
void write_objects_yaml(const std::filesystem::path& path, const std::vector<ObjectDescription>& objects,
                        const std::string& scene_hash = {}, const TruthNotes& notes = {});
TruthNotes read_truth_notes(const std::filesystem::path& path);

/// Throw InputError with the node's file and line for a size of an image [px], a focal length [px] or a
/// coordinate of the principal point [px] that no camera has: it is in another unit.
void require_image_side(const ConfigNode& node, int side_px);
void require_focal_length(const ConfigNode& node, double focal_px, int side_px);
void require_principal_point(const ConfigNode& node, double place_px, int side_px);

/// Keys of a camera's calibration: width, height, fx, fy, cx, cy, distortion [k1 k2 p1 p2 k3]. Leaves other
/// keys of the map to the caller's check.
Camera read_camera(const ConfigNode& node);
/// One line of YAML flow map content: "width: 640, height: ..." (no braces).
std::string camera_yaml(const Camera& camera);

/// Where a sensor sits, a_from_b: `{position_m: [x, y, z], quaternion_xyzw: [x, y, z, w]}`.
Pose read_extrinsics(const ConfigNode& node);
std::string extrinsics_yaml(const Pose& pose);

/// A file that holds a camera's calibration alone (truth/camera.yaml).
Camera read_camera_yaml(const std::filesystem::path& path);
void write_camera_yaml(const std::filesystem::path& path, const Camera& camera);

}  // namespace uniquadric
