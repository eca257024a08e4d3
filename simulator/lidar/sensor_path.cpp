#include "simulator/lidar/sensor_path.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/vector_clones.h"
#include "simulator/lidar/scan_pattern.h"

namespace uniquadric {
namespace {

constexpr double kPiece_ns = 5e6;
constexpr double kOriginGrid = 1024;  // a power of two, per metre

using Entries = Eigen::Matrix<double, 12, 1>;

Entries entries_of(const Pose& pose, const Eigen::Vector3d& origin) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = pose.rotation.toRotationMatrix();
  Entries entries;
  entries << Eigen::Map<const Eigen::Matrix<double, 9, 1>>(rotation.data()), pose.translation - origin;
  return entries;
}

}  // namespace

SensorPath::SensorPath(const PoseAt& world_from_sensor, std::int64_t start_ns, std::int64_t end_ns)
    : start_ns_(static_cast<double>(start_ns)) {
  assert(end_ns > start_ns);
  const double length_ns = static_cast<double>(end_ns - start_ns);
  const int pieces = std::max(1, static_cast<int>(std::ceil(length_ns / kPiece_ns)));
  piece_ns_ = length_ns / pieces;
  const Eigen::Vector3d first = world_from_sensor(start_ns_ * 1e-9).translation;
  origin_ = (first * kOriginGrid).array().round() / kOriginGrid;
  const auto sample = [&](int third) {
    return entries_of(world_from_sensor((start_ns_ + third * piece_ns_ / 3) * 1e-9), origin_);
  };
  Entries p0 = sample(0);
  for (int i = 0; i < pieces; ++i) {
    const Entries p1 = sample(3 * i + 1), p2 = sample(3 * i + 2), p3 = sample(3 * i + 3);
    // The cubic through u = 0, 1/3, 2/3, 1, in powers of u.
    const Entries c1 = (-11 * p0 + 18 * p1 - 9 * p2 + 2 * p3) / 2;
    const Entries c2 = 9 * (2 * p0 - 5 * p1 + 4 * p2 - p3) / 2;
    const Entries c3 = 9 * (-p0 + 3 * p1 - 3 * p2 + p3) / 2;
    Piece piece;
    for (int e = 0; e < 12; ++e)
      for (int k = 0; k < 4; ++k) piece[k][e] = (k == 0 ? p0 : k == 1 ? c1 : k == 2 ? c2 : c3)[e];
    pieces_.push_back(piece);
    p0 = p3;
  }
}

void SensorPath::place(const BeamBlock& beams, WorldRays& rays) const {
  const auto piece_of = [&](int i) {
    const auto index = static_cast<int>((static_cast<double>(beams.time_ns[i]) - start_ns_) / piece_ns_);
    return std::clamp(index, 0, static_cast<int>(pieces_.size()) - 1);
  };
  for (int from = 0; from < beams.count;) {
    const int index = piece_of(from);
    int to = from + 1;
    while (to < beams.count && piece_of(to) == index) ++to;
    place_run(pieces_[static_cast<std::size_t>(index)], start_ns_ + index * piece_ns_, from, to, beams, rays);
    from = to;
  }
}

// In pieces that the compiler runs for several rays at once: whole numbers to places in the piece, then the
// poses. The copy and __restrict say that nothing that is written is read.
UNIQUADRIC_VECTOR_CLONES
void SensorPath::place_run(const Piece& piece, double piece_start_ns, int from, int to,
                           const BeamBlock& beams, WorldRays& rays) const {
  const Piece factors = piece;
  const BeamBlock* __restrict in = &beams;
  WorldRays* __restrict out = &rays;
  std::array<double, WorldRays::kCapacity> place;
  for (int i = from; i < to; ++i)
    place[i] = (static_cast<double>(in->time_ns[i]) - piece_start_ns) / piece_ns_;
  for (int i = from; i < to; ++i) {
    const double u = place[i];
    const auto entry = [&](int e) {
      return factors[0][e] + u * (factors[1][e] + u * (factors[2][e] + u * factors[3][e]));
    };
    const double r0 = entry(0), r1 = entry(1), r2 = entry(2), r3 = entry(3), r4 = entry(4), r5 = entry(5),
                 r6 = entry(6), r7 = entry(7), r8 = entry(8);
    const double x = in->x[i], y = in->y[i], z = in->z[i];
    out->x[i] = r0 * x + r1 * y + r2 * z;
    out->y[i] = r3 * x + r4 * y + r5 * z;
    out->z[i] = r6 * x + r7 * y + r8 * z;
    const double ox = in->origin_x[i], oy = in->origin_y[i], oz = in->origin_z[i];
    out->origin_x[i] = entry(9) + r0 * ox + r1 * oy + r2 * oz;
    out->origin_y[i] = entry(10) + r3 * ox + r4 * oy + r5 * oz;
    out->origin_z[i] = entry(11) + r6 * ox + r7 * oy + r8 * oz;
  }
}

}  // namespace uniquadric
