#include "core/sequence/imu.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "core/sequence/calibration.h"
#include "core/sequence/stamps.h"

namespace uniquadric {
namespace {

constexpr double kMinRate_hz = 1e-3, kMaxRate_hz = 100'000;
constexpr double kMostAmount = 1000;  // ours: of noise and gravity, far beyond any sensor and planet
constexpr std::string_view kHeader =
    "timestamp_ns,gyro_x_radps,gyro_y_radps,gyro_z_radps,accel_x_mps2,accel_y_mps2,accel_z_mps2";
constexpr std::size_t kColumns = 7;
constexpr std::size_t kShownBytes = 40;  // ours: of a column's name in an error

// Of noise densities and gravity alike.
void read_amount(const ConfigNode& node, const std::string& key, double& value) {
  value = node.get<double>(key, value);
  if (value < 0) node.at(key).fail(fmt::format("cannot be negative, found {}", value));
  if (value > kMostAmount)
    node.at(key).fail(fmt::format("expected at most {}, found {}", kMostAmount, value));
}

ImuSample parse_sample(const std::filesystem::path& path, int line,
                       const std::vector<std::string_view>& fields) {
  if (fields.size() != kColumns)
    throw InputError(path, line, fmt::format("expected {} columns, found {}", kColumns, fields.size()));
  ImuSample sample;
  const auto stamp = parse_stamp_of_ns(fields[0]);
  if (!stamp) throw InputError(path, line, fmt::format("'{}' is not a stamp in nanoseconds", fields[0]));
  sample.stamp_ns = *stamp;
  for (int k = 0; k < 6; ++k) {
    const auto value = parse_double(fields[static_cast<std::size_t>(k) + 1]);
    if (!value) throw InputError(path, line, fmt::format("'{}' is not a finite number", fields[k + 1]));
    (k < 3 ? sample.angular_velocity_radps[k] : sample.specific_force_mps2[k - 3]) = *value;
  }
  return sample;
}

// The units stand in the names: a column of another name is no reading in ours.
void require_header(const std::filesystem::path& path, int line,
                    const std::vector<std::string_view>& fields) {
  const std::vector<std::string_view> names = split(kHeader, ',');
  if (fields.size() != names.size())
    throw InputError(path, line, fmt::format("expected the header {}", kHeader));
  for (std::size_t i = 0; i < names.size(); ++i)
    if (fields[i] != names[i])
      throw InputError(path, line,
                       fmt::format("expected the header {}, but column {} is '{}'", kHeader, i + 1,
                                   fields[i].substr(0, kShownBytes)));
}

}  // namespace

void read_imu_model(const ConfigNode& node, ImuCalibration& imu) {
  imu.rate_hz = node.positive("rate_hz", imu.rate_hz);
  if (imu.rate_hz > kMaxRate_hz) node.at("rate_hz").fail(fmt::format("expected at most {} Hz", kMaxRate_hz));
  if (imu.rate_hz < kMinRate_hz) node.at("rate_hz").fail(fmt::format("expected at least {} Hz", kMinRate_hz));
  read_amount(node, "gyroscope_noise_radps_rthz", imu.gyroscope_noise_radps_rthz);
  read_amount(node, "gyroscope_walk_radps2_rthz", imu.gyroscope_walk_radps2_rthz);
  read_amount(node, "accelerometer_noise_mps2_rthz", imu.accelerometer_noise_mps2_rthz);
  read_amount(node, "accelerometer_walk_mps3_rthz", imu.accelerometer_walk_mps3_rthz);
  read_amount(node, "gravity_mps2", imu.gravity_mps2);
}

ImuCalibration read_imu_calibration(const ConfigNode& node) {
  ImuCalibration imu;
  for (const char* key : {"rate_hz", "gravity_mps2"}) node.at(key);
  read_imu_model(node, imu);
  imu.camera_from_imu = read_extrinsics(node.at("camera_from_imu"));
  node.refuse_unknown_keys();
  return imu;
}

std::string imu_yaml(const ImuCalibration& imu) {
  return fmt::format(
      "rate_hz: {}, camera_from_imu: {}, gyroscope_noise_radps_rthz: {}, gyroscope_walk_radps2_rthz: {}, "
      "accelerometer_noise_mps2_rthz: {}, accelerometer_walk_mps3_rthz: {}, gravity_mps2: {}",
      imu.rate_hz, extrinsics_yaml(imu.camera_from_imu), imu.gyroscope_noise_radps_rthz,
      imu.gyroscope_walk_radps2_rthz, imu.accelerometer_noise_mps2_rthz, imu.accelerometer_walk_mps3_rthz,
      imu.gravity_mps2);
}

std::vector<ImuSample> read_imu_csv(const std::filesystem::path& path) {
  std::vector<ImuSample> samples;
  bool header = true;
  for_each_line(
      path,
      [&](int line, const std::vector<std::string_view>& fields) {
        if (std::exchange(header, false)) {
          require_header(path, line, fields);
          return;
        }
        samples.push_back(parse_sample(path, line, fields));
        if (samples.size() > 1 && samples.back().stamp_ns <= samples[samples.size() - 2].stamp_ns)
          throw InputError(path, line, fmt::format("stamp {} does not come after the last", fields[0]));
      },
      ',');
  return samples;
}

void write_imu_csv(const std::filesystem::path& path, const std::vector<ImuSample>& samples) {
  std::string text = fmt::format("{}\n", kHeader);
  for (const ImuSample& s : samples) {
    const auto &w = s.angular_velocity_radps, &f = s.specific_force_mps2;
    text += fmt::format("{},{},{},{},{},{},{}\n", s.stamp_ns, w.x(), w.y(), w.z(), f.x(), f.y(), f.z());
  }
  write_text(path, text);
}

}  // namespace uniquadric
