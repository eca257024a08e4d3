#include <pmmintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "simulator/lidar/embree_parts.h"

namespace uniquadric {
namespace {

constexpr int kWidth = 8;  // rays a call: measured as fast as 16 with this ISA, a quarter faster than 1

// Subnormal numbers count as zero while this lives, as Embree wants it.
class FlushSubnormals {
 public:
  FlushSubnormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON); }
  ~FlushSubnormals() { _mm_setcsr(saved_); }
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

 private:
  unsigned saved_;
};

void load(const RayBlock& rays, int first, RTCRayHit8& packet) {
  const auto row = [&](const RayBlock::Row<float>& from, float* to) {
    std::memcpy(to, from.data() + first, kWidth * sizeof(float));
  };
  row(rays.origin_x, packet.ray.org_x);
  row(rays.origin_y, packet.ray.org_y);
  row(rays.origin_z, packet.ray.org_z);
  row(rays.x, packet.ray.dir_x);
  row(rays.y, packet.ray.dir_y);
  row(rays.z, packet.ray.dir_z);
  row(rays.time, packet.ray.time);
  for (int lane = 0; lane < kWidth; ++lane) {
    packet.ray.tnear[lane] = 0;
    packet.ray.tfar[lane] = std::numeric_limits<float>::infinity();
    packet.ray.mask[lane] = ~0u;
    packet.ray.flags[lane] = 0;
    packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
}

void store(const CasterScan::State& scan, const RTCRayHit8& packet, int lane, RayBlock& rays, int i) {
  if (packet.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) {
    rays.distance[i] = -1;
    rays.incidence_cos[i] = rays.reflectivity[i] = 0;
    rays.instance[i] = 0;
    return;
  }
  const unsigned instance = packet.hit.instID[0][lane];
  const Part& part = *scan.parts[instance];
  const Eigen::Vector3f normal(packet.hit.Ng_x[lane], packet.hit.Ng_y[lane], packet.hit.Ng_z[lane]);
  const Eigen::Vector3f direction =
      scan.rotations[instance].to_object({rays.x[i], rays.y[i], rays.z[i]}, rays.time[i]);
  const float length2 = normal.squaredNorm() * direction.squaredNorm();
  rays.distance[i] = packet.ray.tfar[lane];
  rays.incidence_cos[i] = std::min(1.0f, std::abs(normal.dot(direction)) / std::sqrt(length2));
  rays.reflectivity[i] = part.reflectivity[packet.hit.geomID[lane]];
  rays.instance[i] = part.id;
}

}  // namespace

CasterScan::CasterScan(std::unique_ptr<State> state) : state_(std::move(state)) {}
CasterScan::CasterScan(CasterScan&&) noexcept = default;
CasterScan::~CasterScan() = default;

std::vector<MotionKeys> CasterScan::motion_keys() const {
  return {state_->keys.begin() + 1, state_->keys.end()};
}

void CasterScan::cast(RayBlock& rays) const {
  const FlushSubnormals flush;
  alignas(32) std::array<int, kWidth> valid;
  RTCRayHit8 packet;
  for (int first = 0; first < rays.count; first += kWidth) {
    load(rays, first, packet);
    for (int lane = 0; lane < kWidth; ++lane) valid[lane] = first + lane < rays.count ? -1 : 0;
    intersect(state_->scene.get(), valid.data(), packet);
    const int lanes = std::min(kWidth, rays.count - first);
    for (int lane = 0; lane < lanes; ++lane) store(*state_, packet, lane, rays, first + lane);
  }
}

}  // namespace uniquadric
