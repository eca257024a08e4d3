#include "simulator/scene/realism.h"

#include <fmt/format.h>

#include <charconv>

#include "simulator/scene/scene.h"
#include "simulator/scene/sensor_reader.h"

namespace uniquadric {
namespace {

bool has_key(const ConfigNode& node, std::string_view key) {
  const std::size_t dot = key.find('.');
  const auto child = node.find(std::string(key.substr(0, dot)));
  if (!child || dot == key.npos) return child.has_value();
  return child->is_map() && has_key(*child, key.substr(dot + 1));
}

// Whether the scene turns that sensor itself, in any of the ways there are.
bool has_turn(const ConfigNode& scene, std::string_view key) {
  const std::size_t end = key.rfind(".rpy_deg");
  if (end == key.npos) return false;
  const std::string section(key.substr(0, end));
  return has_key(scene, section + ".quaternion_xyzw") || has_key(scene, section + ".look_at_m");
}

// Else the level's value would be blamed for what stands in the scene.
void require_section(const ConfigNode& scene, std::string_view key) {
  const auto section = scene.find(std::string(key.substr(0, key.find('.'))));
  if (section && (section->is_scalar() || section->is_sequence()))
    section->fail(fmt::format("expected a map, found {}", section->yaml()));
}

bool is_of_missing_sensor(const ConfigNode& scene, std::string_view key) {
  for (const std::string sensor : {"imu", "lidar"})
    if (key.starts_with(sensor + ".")) return !scene.has(sensor);
  return false;
}

bool is_of_other_noise(const ConfigNode& scene, std::string_view key) {
  constexpr std::string_view kSection = "depth_noise.";
  if (!key.starts_with(kSection) || !is_of_stereo_alone(key.substr(kSection.size()))) return false;
  const auto section = scene.find("depth_noise");
  return section && section->is_map() && section->get<std::string>("model", "stereo") != "stereo";
}

std::string in_seconds(std::string_view frames, double rate_hz) {
  double value = 0;
  std::from_chars(frames.data(), frames.data() + frames.size(), value);
  return fmt::format("{}", value / rate_hz);
}

}  // namespace

std::string read_realism(const ConfigNode& node) {
  return node.choice("realism", {"ideal", "mild", "real", "harsh"}, "ideal");
}

const std::vector<RealismRow>& realism_rows() {
  constexpr std::string_view kPlanes = "measured: planes of 20 x 20 px in visp_cube 0.06-0.10, TUM fr3 0.064";
  constexpr std::string_view kOurs = "ours";
  static const std::vector<RealismRow> rows = {
      {"light.shadows", "true", "true", "true", false, "every lit scene"},

      {"image.rolling_shutter_s", "0.15", "0.45", "0.9", true,
       "Ringaby and Forssen, IJCV 2012: 30.6 ms of 33.3 ms for a Kinect"},
      {"image.exposure_s", "", "0.15", "0.5", true, "ours: 5 ms in a lit room, 17 ms in a dim one"},
      {"image.exposure_steps", "", "2", "4", false, kOurs},
      {"image.samples", "", "1", "1", false, "the mean over the exposure makes edges smooth"},
      {"image.auto_exposure_level", "", "110", "110", false, "usual target of automatic exposure, 40-45 %"},
      {"image.exposure_drift", "0.02", "0.05", "0.1", false, kOurs},
      {"image.white_balance_drift", "", "0.02", "0.05", false, kOurs},
      {"image.stamp_jitter_s", "0.006", "0.03", "0.09", true,
       "ours: stamps taken on arrival over USB, 0.2, 1 and 3 ms at 30 a second"},
      {"image_noise.electrons_per_level", "30", "20", "8", false,
       "EMVA 1288 sheets: 5,000-10,000 electrons full well of small pixels, so 20-39 a level; harsh: with "
       "gain"},
      {"camera.calibration_error.focal", "0.0005", "0.002", "0.01", false,
       "TUM RGB-D: 517 px calibrated against 525 px by default, 1.5 %; mild, real: ours, of who calibrated"},
      {"camera.calibration_error.center_px", "[0.3, -0.2]", "[1, -1]", "[3, -2]", false,
       "TUM RGB-D: up to 9 px between default and calibrated"},
      {"depth_noise.model", "stereo", "stereo", "stereo", false, "active stereo"},
      {"depth_noise.baseline_m", "0.05", "0.05", "0.05", false, "RealSense D435 data sheet: 50 mm"},
      {"depth_noise.disparity_sigma_px", "0.05", "0.09", "0.12", false, kPlanes},
      {"depth_noise.disparity_step_px", "0.03125", "0.03125", "0.125", false,
       "D400: 1/32 px; Khoshelham and Elberink, Sensors 2012: 1/8 px for a Kinect"},
      {"depth_noise.correlation_px", "2", "5", "6", false,
       "measured: 5 px in visp_cube, 2 px in TUM fr3 and 7-Scenes"},
      {"depth_noise.disparity_bias_px", "", "0.15", "0.3", false,
       "D435 data sheet: error below 2 % at 2 m, which is 0.3 px"},
      {"depth_noise.smear_px", "", "", "3", false,
       "measured: none; the median step is 1 px wide in visp_cube, TUM fr3 and 7-Scenes; harsh: ours, of a "
       "camera that smooths"},
      {"depth_noise.flying_pixels", "0", "0", "0.3", false,
       "measured: round things alone give the twin of visp_cube as many pixels between a step's sides as the "
       "recording has; harsh: ours"},
      {"depth_noise.edge_dropout", "0.1", "0.15", "0.7", false,
       "measured: 1.2 px lost a step in visp_cube, 1.3 px in its twin, 2.0 px in TUM fr3; harsh: ours"},
      {"depth_noise.max_incidence_deg", "85", "84", "70", false,
       "measured: of visp_cube's table and keyboard 87 % have depth at 81-84 degrees; Nguyen et al., 3DIMPVT "
       "2012: 70-80 degrees for a Kinect"},
      {"depth_noise.dark_dropout", "0.05", "0.1", "0.9", false,
       "measured: 7-10 % of visp_cube's dark pixels have no depth, 3-5 % of its bright ones; mild, harsh: "
       "ours"},
      {"depth_noise.color_offset_m", "0.015", "0.015", "0.025", false,
       "D435 data sheet: 15 mm; Kinect: 25 mm (Herrera et al., PAMI 2012)"},
      {"depth_noise.registration_error_px", "", "[0, -1]", "[3, -1]", false,
       "ours: of registration by the default calibration"},
      {"depth_noise.delay_s", "", "0.1", "0.5", true,
       "shutters that are not synchronised: up to half a frame"},
      {"segmenter.boundary_sigma_px", "1", "1.5", "2.5", false, kOurs},
      {"segmenter.miss_probability", "0.01", "0.03", "0.1", false, kOurs},
      {"segmenter.latency_sigma_s", "0.01", "0.03", "0.1", false, kOurs},
      {"segmenter.merge_probability", "", "0.02", "0.1", false, kOurs},
      {"segmenter.split_probability", "", "0.02", "0.1", false, kOurs},
      {"segmenter.leak_probability", "0.02", "0.1", "0.3", false, kOurs},
      {"segmenter.leak_px", "5", "8", "12", false, kOurs},
      {"segmenter.false_probability", "", "0.02", "0.1", false, kOurs},
      {"segmenter.outage_every_s", "", "", "8", false, kOurs},
      {"imu.mounting_error.rpy_deg", "[0.05, -0.05, 0.05]", "[0.2, -0.2, 0.2]", "[1, -1, 1]", false,
       "Kalibr: camera and IMU within 0.1-0.3 degrees"},
      {"lidar.mounting_error.rpy_deg", "[0.05, 0, -0.05]", "[0.1, -0.1, 0.2]", "[0.5, -0.5, 1]", false,
       kOurs},
      {"lidar.mounting_error.position_m", "[0.005, 0, 0]", "[0.01, 0.01, -0.01]", "[0.05, 0.03, -0.03]",
       false, kOurs},
      {"lidar.time_offset_s", "", "0.002", "0.01", false, "ours: without and with a wrong clock"},
      {"lidar.point_times", "", "", "false", false,
       "KITTI's scans have no times of points (Geiger et al., IJRR 2013)"},
      {"lidar.noise.weak_bias_m", "0.005", "0.015", "0.03", false,
       "Livox and Velodyne data sheets: accuracy of 20-30 mm over all reflectivities"},
      {"lidar.noise.crosstalk", "", "0.0001", "0.001", false, kOurs},
  };
  return rows;
}

std::vector<ConfigOverride> realism_of(const ConfigNode& scene) {
  const std::string level = read_realism(scene);
  if (level == "ideal") return {};
  const double rate_hz = scene.positive("rate_hz", Scene{}.rate_hz);
  const std::string where = scene.at("realism").place() + ' ' + level;
  std::vector<ConfigOverride> added;
  for (const RealismRow& row : realism_rows()) {
    const std::string_view value = level == "mild" ? row.mild : level == "real" ? row.real : row.harsh;
    if (value.empty() || has_key(scene, row.key) || has_turn(scene, row.key) ||
        is_of_missing_sensor(scene, row.key) || is_of_other_noise(scene, row.key))
      continue;
    require_section(scene, row.key);
    added.push_back(
        {std::string(row.key), row.in_frames ? in_seconds(value, rate_hz) : std::string(value), where});
  }
  return added;
}

}  // namespace uniquadric
