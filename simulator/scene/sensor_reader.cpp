#include "simulator/scene/sensor_reader.h"

#include <fmt/format.h>

#include "core/base/config.h"
#include "simulator/scene/pose_reader.h"

namespace uniquadric {
namespace {

double at_least_0(const ConfigNode& node, const std::string& key, double fallback) {
  const double value = node.get<double>(key, fallback);
  if (value < 0) node.at(key).fail(fmt::format("cannot be negative, found {}", value));
  return value;
}

double probability(const ConfigNode& node, const std::string& key, double fallback) {
  const double value = at_least_0(node, key, fallback);
  if (value > 1) node.at(key).fail(fmt::format("expected 0 to 1, found {}", value));
  return value;
}

void read_light(const ConfigNode& node, Scene& scene) {
  scene.sun_direction = node.get<Eigen::Vector3d>("sun_direction", scene.sun_direction);
  if (!(scene.sun_direction.norm() > 0)) node.at("sun_direction").fail("a direction cannot be zero");
  scene.sky_color = node.get<Eigen::Vector3d>("sky_color", scene.sky_color);
  if (scene.sky_color.minCoeff() < 0 || scene.sky_color.maxCoeff() > 1)
    node.at("sky_color").fail("expected red, green, blue from 0 to 1");
  scene.ambient = probability(node, "ambient", scene.ambient);
  scene.shadows = node.get<bool>("shadows", scene.shadows);
}

// Two numbers, (u, v); none: zero.
Eigen::Vector2d pixels(const ConfigNode& node, const std::string& key) {
  const auto found = node.find(key);
  if (!found) return Eigen::Vector2d::Zero();
  const auto values = found->as<std::vector<double>>();
  if (values.size() != 2) found->fail(fmt::format("expected 2 numbers, found {}", values.size()));
  return {values[0], values[1]};
}

void read_depth_noise(const ConfigNode& node, DepthNoise& noise) {
  const std::string model = node.choice("model", {"none", "proportional", "stereo"}, "proportional");
  noise.model = model == "none"           ? DepthNoise::Model::none
                : model == "proportional" ? DepthNoise::Model::proportional
                                          : DepthNoise::Model::stereo;
  noise.k = at_least_0(node, "k", noise.k);
  noise.baseline_m = node.positive("baseline_m", noise.baseline_m);
  noise.disparity_sigma_px = at_least_0(node, "disparity_sigma_px", noise.disparity_sigma_px);
  noise.disparity_step_px = at_least_0(node, "disparity_step_px", noise.disparity_step_px);
  noise.edge_dropout = probability(node, "edge_dropout", noise.edge_dropout);
  noise.flying_pixels = probability(node, "flying_pixels", noise.flying_pixels);
  noise.max_incidence_deg = node.positive("max_incidence_deg", noise.max_incidence_deg);
  if (noise.max_incidence_deg > 90) node.at("max_incidence_deg").fail("expected at most 90");
  noise.shadow = node.get<bool>("shadow", noise.shadow);
  noise.correlation_px = at_least_0(node, "correlation_px", noise.correlation_px);
  noise.disparity_bias_px = node.get<double>("disparity_bias_px", noise.disparity_bias_px);
  noise.smear_px = at_least_0(node, "smear_px", noise.smear_px);
  noise.dark_dropout = probability(node, "dark_dropout", noise.dark_dropout);
  noise.dark_level = node.positive("dark_level", noise.dark_level);
  noise.color_offset_m = node.get<double>("color_offset_m", noise.color_offset_m);
  noise.registered = node.get<bool>("registered", noise.registered);
  noise.registration_error_px = pixels(node, "registration_error_px");
  noise.delay_s = at_least_0(node, "delay_s", noise.delay_s);
  noise.min_range_m = node.positive("min_range_m", noise.min_range_m);
  noise.max_range_m = node.positive("max_range_m", noise.max_range_m);
  if (noise.max_range_m <= noise.min_range_m)
    node.fail(
        fmt::format("max_range_m {} is not above min_range_m {}", noise.max_range_m, noise.min_range_m));
}

void read_imaging(const ConfigNode& node, double rate_hz, Imaging& imaging) {
  constexpr int kMostSteps = 256;  // of 255 grey levels each, in 16 bits
  imaging.samples = node.get<int>("samples", imaging.samples);
  if (imaging.samples != 1 && imaging.samples != 4) node.at("samples").fail("expected 1 or 4");
  imaging.gain = node.positive("gain", imaging.gain);
  imaging.exposure_s = at_least_0(node, "exposure_s", imaging.exposure_s);
  if (imaging.exposure_s * rate_hz > 1)
    node.at("exposure_s").fail(fmt::format("is longer than a frame, {} s", 1 / rate_hz));
  imaging.exposure_steps = node.get<int>("exposure_steps", imaging.exposure_steps);
  if (imaging.exposure_steps < 1 || imaging.exposure_steps > kMostSteps)
    node.at("exposure_steps").fail(fmt::format("expected 1 to {}", kMostSteps));
  imaging.rolling_shutter_s = at_least_0(node, "rolling_shutter_s", imaging.rolling_shutter_s);
  if (imaging.rolling_shutter_s * rate_hz > 1)
    node.at("rolling_shutter_s").fail(fmt::format("is longer than a frame, {} s", 1 / rate_hz));
  imaging.auto_exposure_level = at_least_0(node, "auto_exposure_level", imaging.auto_exposure_level);
  if (imaging.auto_exposure_level > 255) node.at("auto_exposure_level").fail("expected at most 255");
  imaging.exposure_drift = at_least_0(node, "exposure_drift", imaging.exposure_drift);
  imaging.white_balance_drift = at_least_0(node, "white_balance_drift", imaging.white_balance_drift);
  imaging.stamp_offset_s = node.get<double>("stamp_offset_s", imaging.stamp_offset_s);
  imaging.stamp_jitter_s = at_least_0(node, "stamp_jitter_s", imaging.stamp_jitter_s);
  imaging.rolling_shutter_bands = node.get<int>("rolling_shutter_bands", imaging.rolling_shutter_bands);
  if (imaging.rolling_shutter_bands < 1) node.at("rolling_shutter_bands").fail("expected at least 1");
}

void read_segmenter(const ConfigNode& node, SegmenterNoise& noise) {
  noise.boundary_sigma_px = at_least_0(node, "boundary_sigma_px", noise.boundary_sigma_px);
  noise.boundary_length_px = node.positive("boundary_length_px", noise.boundary_length_px);
  noise.miss_probability = probability(node, "miss_probability", noise.miss_probability);
  noise.latency_s = at_least_0(node, "latency_s", noise.latency_s);
  noise.latency_sigma_s = at_least_0(node, "latency_sigma_s", noise.latency_sigma_s);
  noise.merge_probability = probability(node, "merge_probability", noise.merge_probability);
  noise.split_probability = probability(node, "split_probability", noise.split_probability);
  noise.leak_probability = probability(node, "leak_probability", noise.leak_probability);
  noise.false_probability = probability(node, "false_probability", noise.false_probability);
  noise.leak_px = at_least_0(node, "leak_px", noise.leak_px);
  noise.outage_every_s = at_least_0(node, "outage_every_s", noise.outage_every_s);
  noise.outage_s = node.positive("outage_s", noise.outage_s);
  noise.every_n_frames = node.get<int>("every_n_frames", noise.every_n_frames);
  if (noise.every_n_frames < 1) node.at("every_n_frames").fail("expected at least 1");
  noise.min_pixels = node.get<int>("min_pixels", noise.min_pixels);
  if (noise.min_pixels < 1) node.at("min_pixels").fail("expected at least 1");
}

std::optional<double> optional_positive(const ConfigNode& node, const std::string& key) {
  return node.has(key) ? std::optional(node.positive(key)) : std::nullopt;
}

void read_imu(const ConfigNode& node, ImuRig& imu) {
  read_imu_model(node, imu.calibration);
  imu.calibration.camera_from_imu = read_mounting(node, "imu");
  imu.mounting_error = read_mounting_error(node);
  imu.gyroscope_bias_radps = node.get<Eigen::Vector3d>("gyroscope_bias_radps", imu.gyroscope_bias_radps);
  imu.accelerometer_bias_mps2 =
      node.get<Eigen::Vector3d>("accelerometer_bias_mps2", imu.accelerometer_bias_mps2);
  imu.gyroscope_range_radps = optional_positive(node, "gyroscope_range_radps");
  imu.accelerometer_range_mps2 = optional_positive(node, "accelerometer_range_mps2");
}

}  // namespace

CalibrationError read_calibration_error(const ConfigNode& node) {
  CalibrationError error;
  error.focal = node.get<double>("focal", error.focal);
  if (!(error.focal > -0.5 && error.focal < 1)) node.at("focal").fail("expected more than -0.5, less than 1");
  error.center_px = pixels(node, "center_px");
  return error;
}

void read_sensor_models(const ConfigNode& root, Scene& scene) {
  const auto section = [&](const std::string& key, const auto& read) {
    const auto node = root.find(key);
    if (!node) return;
    read(*node);
    node->refuse_unknown_keys();
  };
  section("light", [&](const ConfigNode& node) { read_light(node, scene); });
  section("depth_noise", [&](const ConfigNode& node) { read_depth_noise(node, scene.depth_noise); });
  section("image", [&](const ConfigNode& node) { read_imaging(node, scene.rate_hz, scene.imaging); });
  section("image_noise", [&](const ConfigNode& node) {
    scene.image_noise.sigma = at_least_0(node, "sigma", scene.image_noise.sigma);
    scene.image_noise.electrons_per_level =
        at_least_0(node, "electrons_per_level", scene.image_noise.electrons_per_level);
  });
  section("imu", [&](const ConfigNode& node) { read_imu(node, scene.imu.emplace()); });
  scene.lidar = root.find("lidar");
  section("segmenter", [&](const ConfigNode& node) { read_segmenter(node, scene.segmenter); });
}

}  // namespace uniquadric
