#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/ellipsoid.h"
#include "core/geometry/superquadric.h"
#include "core/sequence/trajectory.h"

namespace uniquadric {

using Vector9d = Eigen::Matrix<double, 9, 1>;

/// Lifecycle of a tracked object.
enum class ObjectStatus { tentative, active, occluded, lost };
const char* to_string(ObjectStatus status);

/// Whether an object stands still in the world.
enum class ObjectMotion {
  unknown,  ///< not decided, or not asked
  at_rest,  ///< `static` in files
  moving,   ///< `dynamic` in files
};
const char* to_string(ObjectMotion motion);

/// The 9-DoF state of one object at one time.
struct ObjectState {
  std::int64_t frame = 0;
  std::int64_t stamp_ns = 0;
  Ellipsoid ellipsoid;       ///< world_from_object and semi-axes [m]
  SuperExponents exponents;  ///< of the superellipsoid with those semi-axes: all 2, the ellipsoid
  int profile_axis = 2;      ///< along which its profiles are, 0 x, 1 y, 2 z
  /// Variances: semi-axes [m^2], translation [m^2], rotation vector [rad^2]; NaN where not estimated.
  Vector9d covariance_diagonal = Vector9d::Constant(std::numeric_limits<double>::quiet_NaN());
  ObjectStatus status = ObjectStatus::active;
  ObjectMotion motion = ObjectMotion::unknown;
};

struct ObjectTrack {
  int id = 0;                       ///< positive, unique in its Tracks
  std::string name;                 ///< empty where unknown
  std::vector<ObjectState> states;  ///< strictly increasing stamps
};

/// Camera and object trajectories: the one type of truth and estimate.
struct Tracks {
  Trajectory camera;                  ///< world_from_camera (optical frame)
  std::vector<ObjectTrack> objects;   ///< in order of their ids
  std::optional<Camera> calibration;  ///< camera that the poses belong to, where known
};

/// Reads a truth folder (objects.yaml: constant semi-axes) or an estimate folder: this program's (camera.tum,
/// objects.csv, objects/ID.tum) or another's, of which camera.tum or objects are enough
/// (read_estimated_objects). Throws InputError with file and line.
Tracks read_tracks(const std::filesystem::path& folder);

/// Folders below an estimate's own, which holds what was known at each frame: the same files with what was
/// known a fixed lag later, and at the end. An estimate may lack them.
inline constexpr const char* kLaterOutputs[] = {"fixed_lag", "final"};

/// Counts the frames of states that have none (-1) by all stamps of the tracks.
void number_frames(Tracks& tracks);

/// Writes `camera.tum`, `objects/ID.tum` and `objects.csv` of an estimate into an existing folder. A variance
/// that is not finite or negative is written as one that was not estimated.
void write_estimate(const std::filesystem::path& folder, const Tracks& tracks);

}  // namespace uniquadric
