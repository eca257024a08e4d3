#include "simulator/scene/sensor_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "core/base/config.h"
#include "core/base/warning.h"
#include "simulator/scene/bounds.h"
#include "simulator/scene/pose_reader.h"

namespace uniquadric {
namespace {

// Of depth_noise: what other models have not.
constexpr std::array kStereoKeys = {"baseline_m",        "disparity_sigma_px", "disparity_step_px",
                                    "disparity_bias_px", "correlation_px",     "smear_px",
                                    "flying_pixels",     "max_incidence_deg",  "shadow"};

double probability(const ConfigNode& node, const std::string& key, double fallback) {
  return read_between(node, key, fallback, 0, 1);
}

void read_light(const ConfigNode& node, Scene& scene) {
  constexpr double kLeastNorm = 1e-6, kMostPart = 1e6;  // ours: its square is far from 0 and infinity
  scene.sun_direction = read_within(node, "sun_direction", scene.sun_direction, kMostPart);
  if (scene.sun_direction.norm() < kLeastNorm) node.at("sun_direction").fail("a direction cannot be zero");
  scene.sky_color = node.get<Eigen::Vector3d>("sky_color", scene.sky_color);
  if (scene.sky_color.minCoeff() < 0 || scene.sky_color.maxCoeff() > 1)
    node.at("sky_color").fail("expected red, green, blue from 0 to 1");
  scene.ambient = probability(node, "ambient", scene.ambient);
  scene.shadows = node.get<bool>("shadows", scene.shadows);
}

// Two lengths in the image, (u, v); none: zero.
Eigen::Vector2d pixels(const ConfigNode& node, const std::string& key) {
  const auto found = node.find(key);
  if (!found) return Eigen::Vector2d::Zero();
  const auto values = found->as<std::vector<double>>();
  if (values.size() != 2) found->fail(fmt::format("expected 2 numbers, found {}", values.size()));
  for (const double value : values)
    if (std::abs(value) > kMostSize_px)
      found->fail(fmt::format("expected -{0} to {0} each, found {1}", kMostSize_px, value));
  return {values[0], values[1]};
}

std::string name_of(DepthNoise::Model model) {
  return model == DepthNoise::Model::none           ? "none"
         : model == DepthNoise::Model::proportional ? "proportional"
                                                    : "stereo";
}

void warn_of_other_models(const ConfigNode& depth_noise, const std::string& model) {
  const auto warn_of = [&](const std::string& key, const std::string& of) {
    if (model == of || !depth_noise.has(key)) return;
    warn(fmt::format("{}: counts for model {} alone, and the model is {}", depth_noise.at(key).place(), of,
                     model));
  };
  warn_of("k", "proportional");
  for (const char* key : kStereoKeys) warn_of(key, "stereo");
  for (const char* key : {"edge_dropout", "dark_dropout"})
    if (model == "none" && depth_noise.has(key))
      warn(fmt::format("{}: counts for nothing, for model none has all depth", depth_noise.at(key).place()));
}

void read_depth_noise(const ConfigNode& node, DepthNoise& noise) {
  constexpr double kMostColorOffset_m = 1, kMostBaseline_m = 10, kLeastBaseline_m = 1e-3;  // ours: a wide rig
  constexpr double kMostShare = 1;  // of the distance: nothing is measured
  constexpr double kMostLevel = 255, kRightAngle_deg = 90, kLeastStep_px = 1e-6;
  const std::string model = node.choice("model", {"none", "proportional", "stereo"}, "proportional");
  noise.model = model == "none"           ? DepthNoise::Model::none
                : model == "proportional" ? DepthNoise::Model::proportional
                                          : DepthNoise::Model::stereo;
  noise.k = read_at_most(node, "k", noise.k, kMostShare);
  noise.baseline_m = read_between(node, "baseline_m", noise.baseline_m, kLeastBaseline_m, kMostBaseline_m);
  noise.disparity_sigma_px = read_at_most(node, "disparity_sigma_px", noise.disparity_sigma_px, kMostSize_px);
  noise.disparity_step_px =
      read_zero_or(node, "disparity_step_px", noise.disparity_step_px, kLeastStep_px, kMostSize_px);
  noise.edge_dropout = probability(node, "edge_dropout", noise.edge_dropout);
  noise.flying_pixels = probability(node, "flying_pixels", noise.flying_pixels);
  noise.max_incidence_deg =
      read_positive(node, "max_incidence_deg", noise.max_incidence_deg, kRightAngle_deg);
  noise.shadow = node.get<bool>("shadow", noise.shadow);
  noise.correlation_px =
      read_zero_or(node, "correlation_px", noise.correlation_px, kLeastSize_px, kMostSize_px);
  noise.disparity_bias_px = read_within(node, "disparity_bias_px", noise.disparity_bias_px, kMostSize_px);
  noise.smear_px = read_at_most(node, "smear_px", noise.smear_px, kMostSize_px);
  if (noise.smear_px != std::round(noise.smear_px)) node.at("smear_px").fail("expected whole pixels");
  noise.dark_dropout = probability(node, "dark_dropout", noise.dark_dropout);
  noise.dark_level = read_positive(node, "dark_level", noise.dark_level, kMostLevel);
  noise.color_offset_m = read_within(node, "color_offset_m", noise.color_offset_m, kMostColorOffset_m);
  noise.registered = node.get<bool>("registered", noise.registered);
  noise.registration_error_px = pixels(node, "registration_error_px");
  if (noise.registration_error_px != noise.registration_error_px.array().round().matrix())
    node.at("registration_error_px").fail("expected whole pixels");
  noise.delay_s = read_at_most(node, "delay_s", noise.delay_s, kMostDelay_s);
  noise.min_range_m = read_positive(node, "min_range_m", noise.min_range_m, kMostRange_m);
  noise.max_range_m = read_positive(node, "max_range_m", noise.max_range_m, kMostRange_m);
  if (noise.max_range_m <= noise.min_range_m)
    node.fail(
        fmt::format("max_range_m {} is not above min_range_m {}", noise.max_range_m, noise.min_range_m));
}

// Beyond half the time between two frames a stamp is nearer to another frame.
double stamp_error(const ConfigNode& node, const std::string& key, double rate_hz) {
  const double value_s = node.get<double>(key, 0);
  if (std::abs(value_s) * rate_hz > 0.5)
    node.at(key).fail(
        fmt::format("is {} s, more than half the time between two frames, {} s", value_s, 0.5 / rate_hz));
  return value_s;
}

void read_imaging(const ConfigNode& node, const Scene& scene, Imaging& imaging) {
  const double rate_hz = scene.rate_hz;
  constexpr double kMostGain = 1000, kMostLevel = 255;  // ours: white from a third of a grey level on
  constexpr int kMostSteps = 256;                       // of 255 grey levels each, in 16 bits
  imaging.samples = node.get<int>("samples", imaging.samples);
  if (imaging.samples != 1 && imaging.samples != 4) node.at("samples").fail("expected 1 or 4");
  imaging.gain = read_positive(node, "gain", imaging.gain, kMostGain);
  imaging.exposure_s = read_at_least_0(node, "exposure_s", imaging.exposure_s);
  if (imaging.exposure_s * rate_hz > 1)
    node.at("exposure_s").fail(fmt::format("is longer than a frame, {} s", 1 / rate_hz));
  imaging.exposure_steps = node.get<int>("exposure_steps", imaging.exposure_steps);
  if (imaging.exposure_steps < 1 || imaging.exposure_steps > kMostSteps)
    node.at("exposure_steps").fail(fmt::format("expected 1 to {}", kMostSteps));
  imaging.rolling_shutter_s = read_at_least_0(node, "rolling_shutter_s", imaging.rolling_shutter_s);
  if (imaging.rolling_shutter_s * rate_hz > 1)
    node.at("rolling_shutter_s").fail(fmt::format("is longer than a frame, {} s", 1 / rate_hz));
  imaging.auto_exposure_level =
      read_at_most(node, "auto_exposure_level", imaging.auto_exposure_level, kMostLevel);
  constexpr double kMostDrift = 1;  // ours: a factor of 2.7 is one standard deviation
  imaging.exposure_drift = read_at_most(node, "exposure_drift", imaging.exposure_drift, kMostDrift);
  imaging.white_balance_drift =
      read_at_most(node, "white_balance_drift", imaging.white_balance_drift, kMostDrift);
  imaging.stamp_offset_s = stamp_error(node, "stamp_offset_s", rate_hz);
  imaging.stamp_jitter_s =
      read_at_least_0(node, "stamp_jitter_s", stamp_error(node, "stamp_jitter_s", rate_hz));
}

void read_image_noise(const ConfigNode& node, ImageNoise& noise) {
  constexpr double kMostSigma = 255, kLeastElectrons = 1e-3, kMostElectrons = 1e6;  // ours: a level
  noise.sigma = read_at_most(node, "sigma", noise.sigma, kMostSigma);
  noise.electrons_per_level =
      read_zero_or(node, "electrons_per_level", noise.electrons_per_level, kLeastElectrons, kMostElectrons);
}

void read_segmenter(const ConfigNode& node, SegmenterNoise& noise) {
  noise.boundary_sigma_px = read_at_most(node, "boundary_sigma_px", noise.boundary_sigma_px, kMostSize_px);
  noise.boundary_length_px =
      read_between(node, "boundary_length_px", noise.boundary_length_px, kLeastSize_px, kMostSize_px);
  noise.miss_probability = probability(node, "miss_probability", noise.miss_probability);
  noise.latency_s = read_at_most(node, "latency_s", noise.latency_s, kMostLatency_s);
  noise.latency_sigma_s = read_at_most(node, "latency_sigma_s", noise.latency_sigma_s, kMostLatency_s);
  noise.merge_probability = probability(node, "merge_probability", noise.merge_probability);
  noise.split_probability = probability(node, "split_probability", noise.split_probability);
  noise.leak_probability = probability(node, "leak_probability", noise.leak_probability);
  noise.false_probability = probability(node, "false_probability", noise.false_probability);
  noise.leak_px = read_at_most(node, "leak_px", noise.leak_px, kMostSize_px);
  noise.outage_every_s =
      read_zero_or(node, "outage_every_s", noise.outage_every_s, kLeastOutage_s, kMostOutage_s);
  noise.outage_s = read_positive(node, "outage_s", noise.outage_s, kMostOutage_s);
  if (noise.outage_every_s > 0 && noise.outage_every_s <= noise.outage_s)
    node.at("outage_every_s").fail(fmt::format("leaves no mask: each outage lasts {} s", noise.outage_s));
  noise.every_n_frames = node.get<int>("every_n_frames", noise.every_n_frames);
  if (noise.every_n_frames < 1) node.at("every_n_frames").fail("expected at least 1");
  noise.min_pixels = node.get<int>("min_pixels", noise.min_pixels);
  if (noise.min_pixels < 1) node.at("min_pixels").fail("expected at least 1");
}

std::optional<double> optional_positive(const ConfigNode& node, const std::string& key, double most) {
  return node.has(key) ? std::optional(read_positive(node, key, most, most)) : std::nullopt;
}

void read_imu(const ConfigNode& node, ImuRig& imu) {
  constexpr double kMostTurn_radps = 1000,
                   kMostForce_mps2 = 10'000;  // ours: 1,000 g, as no MEMS sensor reads
  read_imu_model(node, imu.calibration);
  imu.calibration.camera_from_imu = read_mounting(node, "imu");
  imu.mounting_error = read_mounting_error(node);
  imu.gyroscope_bias_radps =
      read_within(node, "gyroscope_bias_radps", imu.gyroscope_bias_radps, kMostTurn_radps);
  imu.accelerometer_bias_mps2 =
      read_within(node, "accelerometer_bias_mps2", imu.accelerometer_bias_mps2, kMostForce_mps2);
  imu.gyroscope_range_radps = optional_positive(node, "gyroscope_range_radps", kMostTurn_radps);
  imu.accelerometer_range_mps2 = optional_positive(node, "accelerometer_range_mps2", kMostForce_mps2);
}

}  // namespace

bool is_of_stereo_alone(std::string_view key) {
  return std::ranges::find(kStereoKeys, key) != kStereoKeys.end();
}

void warn_of_idle_keys(const ConfigNode& given, const Scene& scene) {
  struct Need {
    const char *section, *key, *needs;
    bool is_met;
  };
  const SegmenterNoise& segmenter = scene.segmenter;
  const Need needs[] = {
      {"image", "exposure_steps", "exposure_s above 0", scene.imaging.exposure_s > 0},
      {"segmenter", "latency_sigma_s", "latency_s above 0", segmenter.latency_s > 0},
      {"segmenter", "leak_px", "leak_probability above 0", segmenter.leak_probability > 0},
      {"segmenter", "outage_s", "outage_every_s above 0", segmenter.outage_every_s > 0},
      {"segmenter", "boundary_length_px", "boundary_sigma_px above 0", segmenter.boundary_sigma_px > 0},
      {"depth_noise", "registered", "a color_offset_m", scene.depth_noise.color_offset_m != 0},
      {"depth_noise", "dark_level", "dark_dropout above 0", scene.depth_noise.dark_dropout > 0}};
  const auto section_of = [&](const std::string& name) {
    const auto section = given.find(name);
    return section && section->is_map() ? section : std::nullopt;
  };
  const auto depth_noise = section_of("depth_noise");
  if (depth_noise && !scene.depth)
    warn(fmt::format("{}: counts for nothing, for it needs camera.depth", depth_noise->place()));
  else if (depth_noise)
    warn_of_other_models(*depth_noise, name_of(scene.depth_noise.model));
  for (const Need& need : needs) {
    const auto section = section_of(need.section);
    if (section && section->has(need.key) && !need.is_met)
      warn(fmt::format("{}: counts for nothing, for it needs {}", section->at(need.key).place(), need.needs));
  }
}

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
  section("image", [&](const ConfigNode& node) { read_imaging(node, scene, scene.imaging); });
  section("image_noise", [&](const ConfigNode& node) { read_image_noise(node, scene.image_noise); });
  section("imu", [&](const ConfigNode& node) { read_imu(node, scene.imu.emplace()); });
  scene.lidar = root.find("lidar");
  section("segmenter", [&](const ConfigNode& node) { read_segmenter(node, scene.segmenter); });
}

}  // namespace uniquadric
