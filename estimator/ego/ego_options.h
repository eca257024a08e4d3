#pragma once

#include <cstdint>

#include "estimator/ego/lidar_ego.h"
#include "estimator/ego/rgbd_odometry.h"
#include "estimator/perception/feature_options.h"

namespace uniquadric {

inline constexpr std::int64_t kMaxTimeOffset_ns = 10'000'000'000;

/// Names the options' keys, for reading and writing (option_io.h).
template <typename Io>
void visit(Io& io, EgoOptions& o) {
  io.number("keyframe_min_share", o.keyframe_min_share, 0.0, 1.0);
  io.positive("keyframe_shift", o.keyframe_shift);
  io.positive("keyframe_turn_rad", o.keyframe_turn_rad);
  io.number("keyframe_max_gap", o.keyframe_max_gap, 1, 10'000);
  io.number("window_keyframes", o.window_keyframes, 1, 10'000);
  io.flag("final_adjustment", o.final_adjustment);
  io.number("final_iterations", o.final_iterations, 1, 1000);
  io.number("young_frames", o.young_frames, 0, 10'000);
  io.number("young_lost_frames", o.young_lost_frames, 2, 10'000);
  io.number("restart_after_s", o.restart_after_s, 0.0, 1e6);
  io.number("restart_features", o.restart_features, 4, 100'000);
  io.number("bridge_features", o.bridge_features, 0, 100'000);
  io.section("pose", [&](auto& inner) { visit(inner, o.pose); });
  io.section("bundle", [&](auto& inner) {
    inner.positive("pixel_sigma", o.bundle.pixel_sigma, kSigma_px);
    inner.positive("huber_sigmas", o.bundle.huber_sigmas);
    inner.positive("outlier_sigmas", o.bundle.outlier_sigmas);
    inner.number("iterations", o.bundle.iterations, 1, 1000);
  });
  io.section("loop", [&](auto& inner) {
    inner.number("min_gap_keyframes", o.loop.min_gap_keyframes, 1, 10'000);
    inner.number("min_points", o.loop.min_points, 3, 10'000);
    inner.positive("min_disagreement_px", o.loop.min_disagreement_px);
    inner.positive("loop_sigma", o.loop.loop_sigma, kSigmaOfRatio);
    inner.section("motion", [&](auto& innermost) { visit(innermost, o.loop.motion); });
  });
  io.section("upright", [&](auto& inner) {
    inner.positive("plane_threshold_m", o.upright.plane_threshold_m);
    inner.number("min_share", o.upright.min_share, 0.0, 1.0);
    inner.number("max_tilt_deg", o.upright.max_tilt_deg, 0.0, 89.0);
    inner.positive("max_range_m", o.upright.max_range_m);
    inner.number("step_px", o.upright.step_px, 1, 100);
  });
}

template <typename Io>
void visit(Io& io, LidarMapOptions& o) {
  io.positive("cell_m", o.cell_m);
  io.number("neighbours", o.neighbours, 3, 27);
  io.number("min_neighbours", o.min_neighbours, 3, 27);
  io.number("levels", o.levels, 1, 8);
  io.number("wide_levels", o.wide_levels, 0, 4);
  io.positive("wide_flatness", o.wide_flatness);
  io.positive("min_flatness", o.min_flatness);
  io.number("max_count", o.max_count, 1);
  io.positive("max_range_m", o.max_range_m);
  io.number("max_blocks", o.max_blocks, 1, 100'000'000);
}

template <typename Io>
void visit(Io& io, LidarEgoOptions& o) {
  LidarOdometryOptions& odometry = o.odometry;
  io.flag("use_imu", odometry.use_imu);
  io.choice("cut", o.cut, Choices<SweepCut>{{"frames", SweepCut::frames}, {"scans", SweepCut::scans}});
  io.number("imu_time_offset_ns", o.imu_time_offset_ns, -kMaxTimeOffset_ns, kMaxTimeOffset_ns);
  io.flag("use_masks", o.use_masks);
  io.positive("min_range_m", odometry.sweep.min_range_m);
  io.positive("max_range_m", odometry.sweep.max_range_m);
  io.positive("voxel_m", odometry.sweep.voxel_m);
  io.positive("max_scan_s", odometry.sweep.max_scan_s);
  io.section("map", [&](auto& inner) { visit(inner, odometry.map); });
  io.positive("acceleration_mps2_rthz", odometry.acceleration_mps2_rthz);
  io.positive("angular_acceleration_radps2_rthz", odometry.angular_acceleration_radps2_rthz);
  io.positive("range_sigma_m", odometry.sight.range_sigma_m, kSigma_m);
  io.positive("beam_sigma_rad", odometry.sight.beam_sigma_rad, kSigma_rad);
  io.positive("plane_sigma_m", odometry.sight.plane_sigma_m, kSigma_m);
  io.positive("max_thickness", odometry.sight.max_thickness);
  io.number("min_breadth", odometry.sight.min_breadth, 0.0, 1000.0);
  io.positive("side_points", odometry.sight.side_points);
  io.positive("gate_sigmas", odometry.sight.gate_sigmas);
  io.positive("gate_m", odometry.sight.gate_m);
  io.positive("open_gate_m", odometry.sight.open_gate_m);
  io.positive("huber_sigmas", odometry.sight.huber_sigmas);
  io.number("iterations", odometry.iterations, 1, 100);
  io.number("searches", odometry.sight.searches, 1, 100);
  io.number("search_again_m", odometry.sight.search_again_m, 0.0, 1000.0);
  io.number("min_points", odometry.sight.min_points, 6);
  io.section("observability", [&](auto& inner) {
    inner.positive("min_ratio", odometry.sight.observability.min_ratio);
    inner.number("min_cosine", odometry.sight.observability.min_cosine, 0.0, 1.0);
    inner.number("min_cells", odometry.sight.observability.min_cells, 1);
    inner.number("min_facing", odometry.sight.observability.min_facing, 1);
  });
  io.positive("lost_sigma_m", odometry.lost_sigma_m);
  io.number("found_share", odometry.found_share, 0.0, 1.0);
  io.positive("first_velocity_mps", odometry.first_velocity_mps);
  io.number("first_sweeps", odometry.first_sweeps, 2, 1000);
  io.number("first_passes", odometry.first_passes, 1, 100);
  io.number("first_sweep_s", odometry.first_sweep_s, 0.0, 100.0);
  io.positive("first_change_mps", odometry.first_change_mps);
}

}  // namespace uniquadric
