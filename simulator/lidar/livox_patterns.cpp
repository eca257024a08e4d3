#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/vector_clones.h"
#include "simulator/lidar/pattern_source.h"
#include "simulator/lidar/phasors.h"

// The numbers are those of the sensors as measured against the makers' tables and data sheets; the optics are
// Snell's law in vectors: d' = eta d + (eta c - sqrt(1 - eta^2 (1 - c^2))) n, c = -d.n, eta = n_in / n_out.
namespace uniquadric {
namespace {

using Row = BeamBlock::Row<double>;
constexpr double kGlass = 1.51;  // refractive index
constexpr double kDegree = std::numbers::pi / 180;

FiringTimes uniform_times(double rate_hz, int lines, double shift) {
  FiringTimes times{lines * 1e9 / rate_hz, {}};
  for (int i = 0; i < lines; ++i) times.offsets_ns.push_back((i + shift) * 1e9 / rate_hz);
  return times;
}

void start_at_the_axis(int count, BeamBlock& block) {
  std::fill_n(block.origin_x.begin(), count, 0.0);
  std::fill_n(block.origin_y.begin(), count, 0.0);
  std::fill_n(block.origin_z.begin(), count, 0.0);
}

/// A face of a wedge that light passes. Its normal, against the light, is (s cos phi, s sin phi, -c).
struct Face {
  double s = 0, c = 1;  ///< +- sine and cosine of the tilt
  double eta = 1;       ///< refractive index before over after
  int wedge = 0;        ///< whose angle phi it turns with
};

struct WedgeOptics {
  double rate_hz = 0, shift = 0;  ///< beam i is fired at (i + shift) / rate
  std::vector<Phasors> wedges = {};
  std::vector<Face> faces = {};  ///< in the order light passes them
  int lines = 1;
  double fan_deg = 0;   ///< between lines, in the optics' x-z plane
  bool x_is_up = true;  ///< optics x, y, z -> up, left, forward; otherwise left, up, forward
};

// What of the normal the refracted direction gains, for the cosine of the angle it is met at.
double gain(double eta, double c) {
  return eta * c - std::sqrt(1 - eta * eta * (1 - c * c));
}

UNIQUADRIC_VECTOR_CLONES void refract_flat(double eta, int n, double* x, double* y, double* z) {
  for (int i = 0; i < n; ++i) {
    const double m = gain(eta, z[i]);
    x[i] *= eta;
    y[i] *= eta;
    z[i] = eta * z[i] - m;
  }
}

UNIQUADRIC_VECTOR_CLONES
void refract(const Face& face, int n, const double* cosine, const double* sine, double* x, double* y,
             double* z) {
  for (int i = 0; i < n; ++i) {
    const double nx = face.s * cosine[i], ny = face.s * sine[i], nz = -face.c;
    const double m = gain(face.eta, -(x[i] * nx + y[i] * ny + z[i] * nz));
    x[i] = face.eta * x[i] + m * nx;
    y[i] = face.eta * y[i] + m * ny;
    z[i] = face.eta * z[i] + m * nz;
  }
}

/// Turning glass wedges in front of a fan of fixed lasers.
class WedgePattern : public ScanPattern::Source {
 public:
  explicit WedgePattern(WedgeOptics optics)
      : Source(uniform_times(optics.rate_hz, optics.lines, optics.shift), optics.lines),
        optics_(std::move(optics)) {
    for (int line = 0; line < optics_.lines; ++line) {
      const double angle = (line - (optics_.lines - 1) / 2.0) * optics_.fan_deg * kDegree;
      start_x_.push_back(std::sin(angle));
      start_z_.push_back(std::cos(angle));
    }
  }

  void fill(std::int64_t first, int count, BeamBlock& block) const override {
    Row& x = optics_.x_is_up ? block.z : block.y;
    Row& y = optics_.x_is_up ? block.y : block.z;
    Row& z = block.x;
    auto line = static_cast<std::size_t>(first % optics_.lines);
    for (int i = 0; i < count; ++i, line = line + 1 == start_x_.size() ? 0 : line + 1) {
      block.ring[i] = static_cast<std::uint16_t>(line);
      x[i] = start_x_[line];
      y[i] = 0;
      z[i] = start_z_[line];
    }
    std::array<Row, 3> cosine, sine;
    for (std::size_t k = 0; k < optics_.wedges.size(); ++k)
      optics_.wedges[k].fill(first, count, cosine[k].data(), sine[k].data());
    for (const Face& face : optics_.faces)
      if (face.s == 0)
        refract_flat(face.eta, count, x.data(), y.data(), z.data());
      else
        refract(face, count, cosine[face.wedge].data(), sine[face.wedge].data(), x.data(), y.data(),
                z.data());
    start_at_the_axis(count, block);
  }

 private:
  WedgeOptics optics_;
  std::vector<double> start_x_, start_z_;
};

WedgeOptics mid40() {
  constexpr double kAngle = 17.9636 * kDegree;
  WedgeOptics optics{.rate_hz = 100'000, .shift = 1, .x_is_up = false};
  for (const double rpm : {7294.0, -4664.0})
    optics.wedges.emplace_back(rpm / 60, optics.rate_hz, optics.shift, 0);
  // The first wedge's flat face meets the light head-on and leaves it as it is.
  optics.faces = {{std::sin(kAngle), std::cos(kAngle), kGlass, 0},
                  {-std::sin(kAngle), std::cos(kAngle), 1 / kGlass, 1},
                  {0, 1, kGlass, 1}};
  return optics;
}

struct Wedge {
  double angle_deg, hz;
};

WedgeOptics six_lines(const std::array<Wedge, 3>& wedges, double fan_deg) {
  WedgeOptics optics{.rate_hz = 240'000, .lines = 6, .fan_deg = fan_deg};
  for (int k = 0; k < 3; ++k) {
    const double angle = wedges[k].angle_deg * kDegree;
    optics.wedges.emplace_back(-wedges[k].hz, optics.rate_hz, 0, std::numbers::pi / 2);
    optics.faces.push_back({std::sin(angle), std::cos(angle), 1 / kGlass, k});
    optics.faces.push_back({0, 1, kGlass, k});
  }
  return optics;
}

/// The direction cosines across the axis as a sum of turning phasors.
class Mid70Pattern : public ScanPattern::Source {
 public:
  Mid70Pattern() : Source(uniform_times(kRate_hz, 1, 1), 1) {
    struct Term {
      int j, k;
      double deg;
    };
    constexpr double kA_hz = -77.7333, kB_hz = 121.5667;
    for (const Term& term : {Term{1, 0, 16.3786},
                             {0, 1, 15.6602},
                             {2, -1, .8437},
                             {-1, 2, .0696},
                             {3, -2, .0696},
                             {-2, 3, .0079},
                             {4, -3, .0079}}) {
      phasors_.emplace_back(term.j * kA_hz + term.k * kB_hz, kRate_hz, 1, 0);
      weights_.push_back(-term.deg * kDegree);
    }
  }

  void fill(std::int64_t first, int count, BeamBlock& block) const override {
    std::fill_n(block.y.begin(), count, 0.0);
    std::fill_n(block.z.begin(), count, 0.0);
    std::fill_n(block.ring.begin(), count, std::uint16_t{0});
    Row cosine, sine;
    for (std::size_t k = 0; k < phasors_.size(); ++k) {
      phasors_[k].fill(first, count, cosine.data(), sine.data());
      for (int i = 0; i < count; ++i) {
        block.y[i] += weights_[k] * cosine[i];
        block.z[i] += weights_[k] * sine[i];
      }
    }
    for (int i = 0; i < count; ++i)
      block.x[i] = std::sqrt(1 - block.y[i] * block.y[i] - block.z[i] * block.z[i]);
    start_at_the_axis(count, block);
  }

 private:
  static constexpr double kRate_hz = 100'000;
  std::vector<Phasors> phasors_;
  std::vector<double> weights_;
};

/// ours: the Mid-360's optics are not public. A mirror turns at the published 172.36 Hz while the elevation
/// bounces between -7 and 52 deg, four lines evenly out of step. 7.18 Hz has no small ratio to the turns, so
/// that the pattern does not repeat within seconds.
class Mid360Pattern : public ScanPattern::Source {
 public:
  Mid360Pattern() : Source(uniform_times(kRate_hz, kLines, 0), kLines), turn_(kTurn_hz, kRate_hz, 0, 0) {}

  void fill(std::int64_t first, int count, BeamBlock& block) const override {
    turn_.fill(first, count, block.x.data(), block.y.data());
    for (int i = 0; i < count; ++i) {
      const std::int64_t line = (first + i) % kLines;
      const double bounces =
          kBounce_hz * static_cast<double>(first + i) / kRate_hz + static_cast<double>(line) / (2.0 * kLines);
      const double saw = bounces - std::floor(bounces);
      const double elevation = kDegree * (-7 + 59 * std::abs(2 * saw - 1));
      const double across = std::cos(elevation);
      block.x[i] *= across;
      block.y[i] *= across;
      block.z[i] = std::sin(elevation);
      block.ring[i] = static_cast<std::uint16_t>(line);
    }
    start_at_the_axis(count, block);
  }

 private:
  static constexpr double kRate_hz = 200'000, kTurn_hz = 172.36, kBounce_hz = 7.18;
  static constexpr int kLines = 4;
  Phasors turn_;
};

}  // namespace

std::shared_ptr<const ScanPattern::Source> livox_source(std::string_view name) {
  if (name == "livox_mid40") return std::make_shared<WedgePattern>(mid40());
  if (name == "livox_mid70") return std::make_shared<Mid70Pattern>();
  if (name == "livox_avia")
    return std::make_shared<WedgePattern>(
        six_lines({{{30.8856, -131.5463}, {29.7735, 40.8032}, {3.1351, 213.1611}}}, 1.2370));
  if (name == "livox_horizon")
    return std::make_shared<WedgePattern>(
        six_lines({{{27.1198, 130}, {27.1198, -130}, {18.9043, 210.34}}}, 0.6));
  if (name == "livox_mid360") return std::make_shared<Mid360Pattern>();
  return nullptr;
}

}  // namespace uniquadric
