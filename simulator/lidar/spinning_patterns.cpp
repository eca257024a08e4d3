#include <cmath>
#include <numbers>

#include "simulator/lidar/pattern_source.h"

namespace uniquadric {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Laser {
  double elevation_deg = 0, azimuth_deg = 0;  ///< azimuth counter-clockwise from the sensor's heading
  double offset_ns = 0;                       ///< within the firing
};

struct SpinningSensor {
  double spin_hz = 10, firing_ns = 0;
  double origin_m = 0;  ///< where beams start, from the axis along the heading
  std::vector<Laser> lasers = {};
};

FiringTimes firing_times(const SpinningSensor& sensor) {
  FiringTimes times{sensor.firing_ns, {}};
  for (const Laser& laser : sensor.lasers) times.offsets_ns.push_back(laser.offset_ns);
  return times;
}

class SpinningPattern : public ScanPattern::Source {
 public:
  explicit SpinningPattern(const SpinningSensor& sensor)
      : Source(firing_times(sensor), static_cast<int>(sensor.lasers.size())),
        turns_a_firing_(sensor.spin_hz * sensor.firing_ns * 1e-9) {
    for (const Laser& laser : sensor.lasers) {
      const double turned = -2 * std::numbers::pi * sensor.spin_hz * laser.offset_ns * 1e-9;
      const double azimuth = turned + laser.azimuth_deg * kDegree, elevation = laser.elevation_deg * kDegree;
      beams_.push_back({std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                        std::sin(elevation), sensor.origin_m * std::cos(turned),
                        sensor.origin_m * std::sin(turned)});
    }
  }

  void fill(std::int64_t first, int count, BeamBlock& block) const override {
    const auto lasers = static_cast<std::int64_t>(beams_.size());
    for (int i = 0; i < count;) {
      const double turns = turns_a_firing_ * static_cast<double>((first + i) / lasers);
      const double angle = -2 * std::numbers::pi * (turns - std::round(turns));
      const double c = std::cos(angle), s = std::sin(angle);
      for (std::int64_t laser = (first + i) % lasers; laser < lasers && i < count; ++laser, ++i) {
        const Beam& beam = beams_[static_cast<std::size_t>(laser)];
        block.x[i] = c * beam.x - s * beam.y;
        block.y[i] = s * beam.x + c * beam.y;
        block.z[i] = beam.z;
        block.origin_x[i] = c * beam.origin_x - s * beam.origin_y;
        block.origin_y[i] = s * beam.origin_x + c * beam.origin_y;
        block.origin_z[i] = 0;
        block.ring[i] = static_cast<std::uint16_t>(laser);
      }
    }
  }

 private:
  struct Beam {
    double x, y, z, origin_x, origin_y;  // when the firing starts at heading x
  };
  double turns_a_firing_;
  std::vector<Beam> beams_;
};

SpinningSensor vlp16() {
  SpinningSensor sensor{.firing_ns = 55'296};
  for (int k = 0; k < 16; ++k)
    sensor.lasers.push_back({.elevation_deg = k % 2 == 0 ? -15.0 + k : k, .offset_ns = 2'304.0 * k});
  return sensor;
}

SpinningSensor hdl64e() {
  SpinningSensor sensor{.firing_ns = 48'000};
  for (int k = 0; k < 64; ++k) {
    const double elevation = k < 32 ? 2.02 - 0.34 * k : -8.95 - (24.71 - 8.95) / 31 * (k - 32);
    // ours: the 64 lasers evenly through the cycle; the sensor fires them in groups that are not published
    // here
    sensor.lasers.push_back({.elevation_deg = elevation, .offset_ns = 750.0 * k});
  }
  return sensor;
}

SpinningSensor os1_64(double spin_hz) {
  constexpr std::array<double, 4> kAzimuth_deg = {3.164, 1.055, -1.055, -3.164};
  SpinningSensor sensor{.firing_ns = 1e9 / (1024 * spin_hz), .origin_m = 0.015806};
  for (int k = 0; k < 64; ++k)
    sensor.lasers.push_back(
        {.elevation_deg = 16.611 - 2 * 16.611 / 63 * k, .azimuth_deg = kAzimuth_deg[k % 4]});
  return sensor;
}

}  // namespace

std::shared_ptr<const ScanPattern::Source> spinning_source(std::string_view name, double spin_hz) {
  SpinningSensor sensor;
  if (name == "vlp16")
    sensor = vlp16();
  else if (name == "hdl64e")
    sensor = hdl64e();
  else if (name == "os1_64")
    sensor = os1_64(spin_hz);
  else
    return nullptr;
  sensor.spin_hz = spin_hz;
  return std::make_shared<SpinningPattern>(sensor);
}

}  // namespace uniquadric
