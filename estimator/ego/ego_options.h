#pragma once

#include <cstdint>

#include "estimator/ego/lidar_ego.h"
#include "estimator/ego/rgbd_odometry.h"
#include "estimator/features/feature_options.h"

namespace uniquadric {

inline constexpr std::int64_t kMaxTimeOffset_ns = 10'000'000'000;

/// Names the options' keys, for reading and writing (option_io.h).
template <typename Io>
void visit(Io& io, EgoOptions& o) {
  io.section("pose", [&](auto& inner) { visit(inner, o.pose); });
  io.section("bundle", [&](auto& inner) { inner.number("iterations", o.bundle.iterations, 1, 1000); });
  io.section("loop", [&](auto& inner) {
    inner.number("min_points", o.loop.min_points, 3, 10'000);
    inner.section("motion", [&](auto& innermost) { visit(innermost, o.loop.motion); });
  });
  io.section("upright", [&](auto& inner) { inner.positive("max_range_m", o.upright.max_range_m); });
}

template <typename Io>
void visit(Io& io, LidarMapOptions& o) {
  io.positive("cell_m", o.cell_m);
  io.number("levels", o.levels, 1, 8);
  io.positive("max_range_m", o.max_range_m);
  io.number("max_blocks", o.max_blocks, 1, 100'000'000);
}

template <typename Io>
void visit(Io& io, LidarEgoOptions& o) {
  LidarOdometryOptions& odometry = o.odometry;
  io.flag("use_imu", odometry.use_imu);
  io.choice("cut", o.cut, Choices<SweepCut>{{"frames", SweepCut::frames}, {"scans", SweepCut::scans}});
  io.number("imu_time_offset_ns", o.imu_time_offset_ns, -kMaxTimeOffset_ns, kMaxTimeOffset_ns);
  io.positive("min_range_m", odometry.sweep.min_range_m);
  io.positive("max_range_m", odometry.sweep.max_range_m);
  io.positive("voxel_m", odometry.sweep.voxel_m);
  io.section("map", [&](auto& inner) { visit(inner, odometry.map); });
  io.positive("range_sigma_m", odometry.sight.range_sigma_m, kSigma_m);
  io.positive("beam_sigma_rad", odometry.sight.beam_sigma_rad, kSigma_rad);
  io.number("iterations", odometry.iterations, 1, 100);
  io.number("min_points", odometry.sight.min_points, 6);
}

}  // namespace uniquadric
