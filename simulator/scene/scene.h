#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/config.h"
#include "core/base/config_overrides.h"
#include "core/geometry/body_symmetry.h"
#include "core/geometry/camera.h"
#include "core/sequence/imu.h"
#include "simulator/scene/mesh.h"
#include "simulator/scene/motion.h"

namespace uniquadric {

/// A rigid body: its object frame lies at the centre of its meshes' tight box, axes along it.
struct Body {
  int id = 0;  ///< 1..65535 for objects (their instance id); 0 for parts of the static world
  std::string name;
  std::string shape;      ///< kind of primitive, or "mesh"
  std::string mesh_file;  ///< path of a loaded mesh as the scene gives it, else empty
  std::vector<Mesh> meshes;
  Eigen::Vector3d semi_axes_m = Eigen::Vector3d::Ones();  ///< half the extents of the tight box
  Motion motion;                                          ///< world_from_object
  std::optional<BodySymmetry> symmetry;                   ///< as the scene states it
  bool is_scored = true;  ///< false: an object that is seen, and of which evaluation has no figures
};

/// Depth noise (SENSORS: Noise). Depth is z along the optical axis.
struct DepthNoise {
  enum class Model { none, proportional, stereo };
  Model model = Model::proportional;
  double k = 0.005;  ///< proportional: sigma = k d, d the distance from the optical centre (paper; ours: k)
  double baseline_m = 0.095;            ///< stereo: sigma = s z^2 / (f B), RealSense D455
  double disparity_sigma_px = 0.08;     ///< stereo: s
  double disparity_step_px = 1.0 / 32;  ///< stereo: quantisation
  double edge_dropout = 0.3;            ///< probability that a pixel beside a depth edge is lost
  double flying_pixels = 0.3;     ///< stereo: probability that it lies between the edge's two sides instead
  double max_incidence_deg = 80;  ///< stereo: surfaces seen at a flatter angle are lost; 90 keeps all
  bool shadow = true;         ///< stereo: what the second imager, baseline_m to the right, cannot see is lost
  double correlation_px = 0;  ///< stereo: length over which the disparity's noise is alike, 0: white
  double disparity_bias_px = 0;  ///< stereo: added to every disparity, so depth is off by b z^2 / (f B)
  double smear_px = 0;           ///< stereo: half the window that mixes the disparities of an edge's sides
  double dark_dropout = 0;       ///< probability that a black surface's depth is lost; at dark_level none is
  double dark_level = 40;        ///< grey level from which a surface is bright enough
  /// The depth camera stands so far to the right of the colour camera (negative: left). What it cannot see
  /// has no depth in the colour camera's image.
  double color_offset_m = 0;
  bool registered = true;                          ///< else depth is left in the depth camera's own image
  Eigen::Vector2d registration_error_px = {0, 0};  ///< (u, v) by which the depth image lies off
  double delay_s = 0;                              ///< depth shows what was there so long before the stamp
  double min_range_m = 0.1, max_range_m = 20;      ///< outside: no depth
};

/// How the camera makes its colour image. Ids, depth and true masks belong to pixel centres and the stamp
/// alone.
struct Imaging {
  int samples = 4;         ///< places in a pixel that surfaces are looked up at, 1 or 4 (anti-aliased edges)
  double gain = 1;         ///< exposure: grey levels are multiplied by it and saturate at 255
  double exposure_s = 0;   ///< time the shutter is open, its middle at the stamp: 0 is no motion blur
  int exposure_steps = 8;  ///< images whose mean is the blurred one
  /// Time in which the rows are exposed one after the other from the top, the middle one at the stamp; 0: all
  /// at once.
  double rolling_shutter_s = 0;
  double auto_exposure_level = 0;  ///< mean grey level that every image is brought to; 0: fixed exposure
  double exposure_drift = 0;       ///< standard deviation of the slow change of the gain's logarithm
  double white_balance_drift = 0;  ///< the same of the gains of red and blue against green's
  double stamp_offset_s = 0;       ///< images are stamped so late (negative: early)
  double stamp_jitter_s = 0;       ///< standard deviation of a stamp's error besides

  /// Then images are drawn with gain 1 and multiplied by `gain` afterwards (exposed): nothing saturates that
  /// a darker exposure would show.
  bool changes_exposure() const {
    return auto_exposure_level > 0 || exposure_drift > 0 || white_balance_drift > 0;
  }
};

struct ImageNoise {
  double sigma = 2;  ///< grey levels, white Gaussian
  /// Shot noise: the variance of a value has value / electrons_per_level besides; 0 is none.
  double electrons_per_level = 0;
};

/// Errors of the simulated segmenter, whose masks come from the true ones.
struct SegmenterNoise {
  double boundary_sigma_px =
      1;  ///< the outline moves along its normal by smooth noise of this standard deviation
  double boundary_length_px = 15;  ///< correlation length of that noise along the image
  double miss_probability = 0.01;  ///< that an object is missing from one result
  double latency_s = 0.1;          ///< mean time that a result takes; it arrives no earlier than the last
  int every_n_frames = 1;          ///< segmented frames: 1 is each
  int min_pixels = 50;             ///< smaller masks are not found
  double latency_sigma_s = 0;      ///< standard deviation of that time, which is log-normal
  /// Faults that last half a second: masks that touch become one, a mask falls into two, a mask runs over
  /// what lies below it in the image by leak_px, and a mask of nothing (noise/mask_faults.h has their ids).
  double merge_probability = 0, split_probability = 0, leak_probability = 0, false_probability = 0;
  double leak_px = 12;
  double outage_every_s = 0, outage_s = 2;  ///< once in that time no masks come for outage_s; 0: never
};

/// What is wrong with a calibration as it is told, beside the true one.
struct CalibrationError {
  double focal = 0;                    ///< both focal lengths are told so much too long, relative
  Eigen::Vector2d center_px = {0, 0};  ///< the principal point is told so far off
};

/// An inertial measurement unit on the camera.
struct ImuRig {
  ImuCalibration calibration;
  Eigen::Vector3d gyroscope_bias_radps = Eigen::Vector3d::Zero();     ///< when the sequence starts
  Eigen::Vector3d accelerometer_bias_mps2 = Eigen::Vector3d::Zero();  ///< when the sequence starts
  /// Readings beyond are cut off, an axis at a time; none: no limit.
  std::optional<double> gyroscope_range_radps, accelerometer_range_mps2;
  Pose mounting_error;  ///< the told camera_from_imu is the true one times this
};

/// What the simulator renders: read from YAML (scenes/README.md).
struct Scene {
  std::string name;
  std::string hash;     ///< of the file and of every file it names
  std::string realism;  ///< as the scene names it, else empty
  std::int64_t frames = 300;
  double rate_hz = 30;
  Camera camera;
  CalibrationError calibration_error;  ///< of the intrinsics that the sequence carries
  Motion camera_motion;                ///< world_from_camera, optical frame
  bool given_camera =
      true;  ///< whether the sequence carries the camera's poses as another system would give them
  std::vector<Body> world;  ///< static, id 0
  std::vector<Body> objects;
  Eigen::Vector3d sun_direction = {0.3, 0.4, -0.85};    ///< direction the light travels in, world frame
  double ambient = 0.55;                                ///< share of light that comes from everywhere
  bool shadows = false;                                 ///< whether what stands in the sun casts a shadow
  Eigen::Vector3d sky_color = Eigen::Vector3d::Zero();  ///< (red, green, blue) where no surface is
  bool depth = true;                                    ///< whether the camera measures depth
  DepthNoise depth_noise;
  Imaging imaging;
  ImageNoise image_noise;
  SegmenterNoise segmenter;
  std::optional<ImuRig> imu;
  std::uint64_t noise_seed = 0;     ///< scenes with others draw other noise at the same seed of a sequence
  double noise_scale = 1;           ///< what the amplitudes of noise were multiplied by (scale_noise)
  double map_resolution_m = 0.1;    ///< cell edge of the static world's octree (truth/map.bt)
  std::optional<ConfigNode> lidar;  ///< the section as it stands, for its own reader

  Camera told_camera() const;                       ///< with its calibration error
  std::int64_t stamp_ns(std::int64_t frame) const;  ///< of a frame, from 0 on, rounded to the nanosecond
  /// The seed of all noise in a sequence of this seed: the same, where the scene has no noise_seed.
  std::uint64_t stream_seed(std::uint64_t seed) const;
};

/// Whether primitives' textures are painted, which takes most of the time to load a scene, or left in one
/// tone: enough for who only checks a scene, hashes it or asks what sensors it has.
enum class Textures { painted, plain };

/// Loads a scene, with values set that need not be the file's; meshes are generated or loaded, re-centred,
/// scaled. Throws InputError with file and line.
Scene load_scene(const std::filesystem::path& path, const std::vector<ConfigOverride>& overrides = {},
                 Textures textures = Textures::painted);

/// The same of a text that stands, or will stand, in the file `path`.
Scene parse_scene(const std::string& text, const std::filesystem::path& path,
                  const std::vector<ConfigOverride>& overrides = {}, Textures textures = Textures::painted);

}  // namespace uniquadric
