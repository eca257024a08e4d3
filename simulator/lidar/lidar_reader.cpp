#include "simulator/lidar/lidar_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/config.h"
#include "core/base/error.h"
#include "simulator/scene/bounds.h"
#include "simulator/scene/path_reader.h"
#include "simulator/scene/pose_reader.h"

namespace uniquadric {
namespace {

constexpr double kMinRate_hz = 1e-3, kMaxRate_hz = 1000;

int read_count(const ConfigNode& node, const std::string& key, int fallback, int least, int most) {
  const int value = node.get<int>(key, fallback);
  if (value < least || value > most)
    node.at(key).fail(fmt::format("expected {} to {}, found {}", least, most, value));
  return value;
}

double read_rate(const ConfigNode& node, const std::string& key, double fallback) {
  const double rate_hz = node.positive(key, fallback);
  if (rate_hz > kMaxRate_hz) node.at(key).fail(fmt::format("expected at most {} Hz", kMaxRate_hz));
  if (rate_hz < kMinRate_hz) node.at(key).fail(fmt::format("expected at least {} Hz", kMinRate_hz));
  return rate_hz;
}

void read_pattern(const ConfigNode& node, LidarRig& rig, std::vector<std::filesystem::path>& files) {
  const auto name = node.find("pattern"), csv = node.find("csv");
  if (name.has_value() == csv.has_value()) node.fail("give one of pattern, csv");
  if (csv) {
    if (const auto spin = node.find("spin_hz")) spin->fail("belongs to a pattern that spins");
    const std::filesystem::path path = resolve_path(*csv);
    rig.pattern_name = path.filename().string();
    rig.pattern = csv_pattern(path);
    files.push_back(path);
    return;
  }
  rig.pattern_name = name->as<std::string>();
  try {
    rig.pattern = named_pattern(rig.pattern_name, read_rate(node, "spin_hz", rig.rate_hz));
  } catch (const InputError& error) {
    name->fail(error.what());
  }
  rig.noise = noise_of(rig.pattern_name);
}

double read_probability(const ConfigNode& node, const std::string& key, double fallback) {
  const double value = read_at_most(node, key, fallback, 1);
  if (value == 1) node.at(key).fail("expected a probability below 1");
  return value;
}

// Of ranges and directions.
void read_errors(const ConfigNode& node, LidarNoise& noise) {
  constexpr double kLeastQuantum_m = 1e-9;  // ours: finer than any range is written
  noise.range_sigma_m = read_at_most(node, "range_sigma_m", noise.range_sigma_m, kMostRangeError_m);
  noise.divergence_deg = read_at_most(node, "divergence_deg", noise.divergence_deg, kMostAngle_deg);
  noise.angle_sigma_deg = read_at_most(node, "angle_sigma_deg", noise.angle_sigma_deg, kMostAngle_deg);
  noise.quantum_m = read_zero_or(node, "quantum_m", noise.quantum_m, kLeastQuantum_m, kMostRangeError_m);
  noise.weak_bias_m = read_within(node, "weak_bias_m", noise.weak_bias_m, kMostRangeError_m);
}

void read_noise(const ConfigNode& node, LidarNoise& noise) {
  // ours: nothing is seen at a metre; half of the pulses at a tenth of the limit are found
  constexpr double kMostExtinction_per_m = 10, kMostDetectionSigma = 10;
  if (node.choice("model", {"sensor", "none"}, "sensor") == "none") noise = LidarNoise::none();
  read_errors(node, noise);
  noise.min_range_m = read_at_most(node, "min_range_m", noise.min_range_m, kMostRange_m);
  noise.max_range_m = read_positive(node, "max_range_m", noise.max_range_m, kMostRange_m);
  noise.r10_m = read_at_most(node, "r10_m", noise.r10_m, kMostRange_m);
  noise.extinction_per_m =
      read_at_most(node, "extinction_per_m", noise.extinction_per_m, kMostExtinction_per_m);
  noise.detection_sigma = read_at_most(node, "detection_sigma", noise.detection_sigma, kMostDetectionSigma);
  noise.false_alarm = read_probability(node, "false_alarm", noise.false_alarm);
  noise.crosstalk = read_probability(node, "crosstalk", noise.crosstalk);
  if (noise.max_range_m <= noise.min_range_m)
    node.fail(
        fmt::format("max_range_m {} is not above min_range_m {}", noise.max_range_m, noise.min_range_m));
  node.refuse_unknown_keys();
}

// Of the model, whose noise may be left out (`model: none`) or multiplied; what the scene says of the sensor
// itself counts.
LidarDataSheet read_data_sheet(const ConfigNode& node, const LidarNoise& model) {
  LidarDataSheet sheet{model.range_sigma_m, model.divergence_deg, model.angle_sigma_deg};
  if (const auto noise = node.find("noise")) {
    sheet.range_sigma_m = read_at_most(*noise, "range_sigma_m", sheet.range_sigma_m, kMostRangeError_m);
    sheet.divergence_deg = read_at_most(*noise, "divergence_deg", sheet.divergence_deg, kMostAngle_deg);
    sheet.angle_sigma_deg = read_at_most(*noise, "angle_sigma_deg", sheet.angle_sigma_deg, kMostAngle_deg);
  }
  return sheet;
}

void read_beam(const ConfigNode& node, LidarBeam& beam) {
  beam.vertical_deg = read_at_most(node, "vertical_deg", beam.vertical_deg, kMostAngle_deg);
  beam.horizontal_deg = read_at_most(node, "horizontal_deg", beam.horizontal_deg, kMostAngle_deg);
  constexpr int kMostRays = 16;  // in a row; a block of 256 rays holds a beam
  beam.vertical_rays = read_count(node, "vertical_rays", beam.vertical_rays, 1, kMostRays);
  beam.horizontal_rays = read_count(node, "horizontal_rays", beam.horizontal_rays, 1, kMostRays);
  beam.merge_m = read_at_most(node, "merge_m", beam.merge_m, kMostRange_m);
  const std::string returned = node.choice("return", {"first", "strongest", "last"}, "strongest");
  beam.returned = returned == "first"  ? LidarBeam::Return::first
                  : returned == "last" ? LidarBeam::Return::last
                                       : LidarBeam::Return::strongest;
  node.refuse_unknown_keys();
}

void read_method(const ConfigNode& node, LidarRig& rig) {
  constexpr double kLeastCell_m = 1e-3, kMostCell_m = 100, kLeastTolerance_m = 1e-9;  // ours
  rig.method = node.choice("method", {"embree", "depth_octree"}, "embree") == "embree"
                   ? LidarMethod::embree
                   : LidarMethod::depth_octree;
  rig.octree_resolution_m =
      read_between(node, "octree_resolution_m", rig.octree_resolution_m, kLeastCell_m, kMostCell_m);
  rig.caster.isa = node.choice("isa", {"sse2", "sse4.2", "avx", "avx2", "avx512"}, rig.caster.isa);
  rig.caster.motion_keys = read_count(node, "motion_keys", 0, 0, 129);
  if (rig.caster.motion_keys == 1) node.at("motion_keys").fail("expected 0 (by tolerance) or 2 to 129");
  rig.caster.motion_tolerance_m = read_between(node, "motion_tolerance_m", rig.caster.motion_tolerance_m,
                                               kLeastTolerance_m, kMostRangeError_m);
}

void read_reflectivity(const ConfigNode& node, LidarRig& rig) {
  constexpr double kMostReflectivity = 1e6;  // ours: a corner cube's is some thousands
  for (const auto& [name, value] : node.entries()) {
    if (value.as<double>() < 0) value.fail("expected at least 0");
    if (value.as<double>() > kMostReflectivity)
      value.fail(fmt::format("expected at most {}, found {}", kMostReflectivity, value.as<double>()));
    rig.reflectivity.emplace_back(name, value.as<double>());
  }
}

}  // namespace

LidarRig read_lidar(const ConfigNode& node, std::vector<std::filesystem::path>& files) {
  LidarRig rig;
  rig.rate_hz = read_rate(node, "rate_hz", rig.rate_hz);
  read_pattern(node, rig, files);
  rig.camera_from_lidar = read_mounting(node, "lidar");
  rig.mounting_error = read_mounting_error(node);
  rig.time_offset_s = read_at_most(node, "time_offset_s", rig.time_offset_s, kMostDelay_s);
  rig.point_times = node.get<bool>("point_times", rig.point_times);
  read_method(node, rig);
  rig.data_sheet = read_data_sheet(node, rig.noise);
  if (const auto noise = node.find("noise")) read_noise(*noise, rig.noise);
  if (const auto beam = node.find("beam")) read_beam(*beam, rig.beam);
  if (const auto reflectivity = node.find("reflectivity")) read_reflectivity(*reflectivity, rig);
  node.refuse_unknown_keys();
  return rig;
}

}  // namespace uniquadric
