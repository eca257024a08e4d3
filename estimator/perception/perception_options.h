#pragma once

#include "estimator/ego/ego_options.h"
#include "estimator/perception/aot_options.h"
#include "estimator/perception/feature_options.h"
#include "estimator/perception/perceive.h"
#include "estimator/perception/segmentation_options.h"

namespace uniquadric {

/// Names the options' keys, for reading and writing (option_io.h).
template <typename Io>
void visit(Io& io, PointOptions& o) {
  io.number("smooth_px", o.smooth_px, 0, 20);
  io.number("erode_px", o.erode_px, 0, 100);
  io.positive("edge_ratio", o.edge_ratio);
  io.positive("max_depth_m", o.max_depth_m);
  io.positive("voxel_m", o.voxel_m);
  io.number("outlier_neighbours", o.outlier_neighbours, 1, 1000);
  io.positive("outlier_sigmas", o.outlier_sigmas);
  io.number("outlier_rounds", o.outlier_rounds, 0, 10);
  io.number("max_points", o.max_points, 4);
  io.number("min_points", o.min_points, 4);
}

template <typename Io>
void visit(Io& io, ContactOptions& o) {
  io.flag("enabled", o.enabled);
  io.positive("ring", o.ring);
  io.positive("threshold", o.threshold);
  io.number("min_share", o.min_share, 0.0, 1.0);
  io.number("max_below", o.max_below, 0.0, 1.0);
  io.number("lowest_share", o.lowest_share, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, DepthCheckOptions& o) {
  io.flag("enabled", o.enabled);
  io.positive("max_change", o.max_change);
  io.number("min_agreement", o.min_agreement, 0.0, 1.0);
  io.number("max_gap_s", o.max_gap_s, 0.0, 1e6);
}

template <typename Io>
void visit(Io& io, SilhouetteOptions& o) {
  io.number("directions", o.directions, 4, 360);
  io.number("min_pixels", o.min_pixels, 1, 1'000'000);
  io.number("min_share", o.min_share, 0.0, 1.0);
  io.number("outline_noise_px", o.outline_noise_px, 0.0, 100.0);
  io.positive("outline_length_px", o.outline_length_px);
  io.number("border_px", o.border_px, 0.0, 100.0);
  io.number("touch_px", o.touch_px, 0.0, 100.0);
  io.number("cut_share", o.cut_share, 0.0, 1.0);
  io.positive("occluder_jump", o.occluder_jump);
  io.number("occluder_reach_px", o.occluder_reach_px, 1, 100);
}

template <typename Io>
void visit(Io& io, BodyTwistOptions& o) {
  io.positive("first_velocity_mps", o.first_velocity_mps);
  io.positive("first_turn_radps", o.first_turn_radps);
  io.positive("acceleration_mps2_rthz", o.acceleration_mps2_rthz);
  io.positive("turn_acceleration_radps2_rthz", o.turn_acceleration_radps2_rthz);
  io.number("reach_px", o.reach_px, 0.5, 200.0);
  io.number("neighbours", o.neighbours, 5, 1000);
  io.number("max_jump", o.max_jump, kLeastJump, kMostJump);
  io.number("max_points", o.max_points, 10, 1'000'000);
  io.positive("pixel_sigma", o.pixel_sigma, kSigma_px);
  io.number("rows_as_one", o.rows_as_one, 1.0, 1e6);
}

template <typename Io>
void visit(Io& io, PointPlaneOptions& o) {
  io.number("reach_px", o.reach_px, 0.5, 200.0);
  io.number("neighbours", o.neighbours, 4, 1000);
  io.number("min_neighbours", o.min_neighbours, 4, 1000);
  io.number("max_jump", o.max_jump, kLeastJump, kMostJump);
}

template <typename Io>
void visit(Io& io, LidarDepthOptions& o) {
  io.choice("undistortion", o.undistortion,
            Choices<Undistortion>{
                {"none", Undistortion::none}, {"ego", Undistortion::ego}, {"object", Undistortion::object}});
  io.choice("motion", o.motion,
            Choices<MotionSource>{{"points", MotionSource::points}, {"features", MotionSource::features}});
  io.positive("motion_window_s", o.motion_window_s);
  io.section("twist", [&](auto& inner) { visit(inner, o.twist); });
  io.positive("window_s", o.window_s);
  io.number("erode_px", o.erode_px, 0, 100);
  visit(io, o.planes);
  io.number("max_points", o.max_points, 1, 1'000'000);
}

template <typename Io>
void visit(Io& io, ScanObjectOptions& o) {
  io.flag("enabled", o.enabled);
  io.flag("masks", o.masks);
  io.number("mask_share", o.mask_share, 0.0, 1.0);
  io.positive("cell_m", o.clusters.cell_m);
  io.number("ground_tilt_deg", o.clusters.ground_tilt_deg, 0.0, 60.0);
  io.number("ground_samples", o.clusters.ground_samples, 1, kMostIterations);
  io.positive("ground_m", o.clusters.ground_m);
  io.positive("tolerance_m", o.clusters.tolerance_m);
  io.positive("max_rise_m", o.clusters.max_rise_m);
  io.number("min_points", o.clusters.min_points, 4, 1'000'000);
  io.positive("min_height_m", o.clusters.min_height_m);
  io.positive("max_extent_m", o.clusters.max_extent_m);
  io.number("window_scans", o.tracker.window_scans, 3, 1000);
  io.number("confirm_scans", o.tracker.confirm_scans, 1, 1000);
  io.flag("moving_only", o.tracker.moving_only);
  io.number("moving_scans", o.tracker.moving_scans, 1, 1000);
  io.number("min_way", o.tracker.min_way, 0.0, 100.0);
  io.number("forget_scans", o.tracker.forget_scans, 1, 100'000);
  io.positive("min_speed_mps", o.tracker.min_speed_mps);
  io.positive("max_stretch_mps", o.tracker.max_stretch_mps);
  io.positive("end_sigma_m", o.tracker.end_sigma_m);
  io.number("min_overlap", o.tracker.min_overlap, 0.0, 1.0);
  io.positive("max_speed_mps", o.tracker.max_speed_mps);
  io.number("patience_scans", o.tracker.patience_scans, 0, 1000);
  io.number("width_deg", o.width_deg, 1.0, 160.0);
  io.number("height_deg", o.height_deg, 1.0, 160.0);
  io.number("focal_px", o.focal_px, 10.0, 2000.0);
  io.number("look_back_s", o.look_back_s, 0.0, 60.0);
  io.number("rim_deg", o.rim_deg, 0.1, 30.0);
  io.number("beside_deg", o.beside_deg, 0.05, 30.0);
  io.number("max_points", o.max_points, 1, 1'000'000);
}

template <typename Io>
void visit(Io& io, PerceptionOptions& o) {
  io.flag("images", o.images);
  io.number("fixed_lag_s", o.fixed_lag_s, 0.0, 60.0);
  io.section("lidar", [&](auto& inner) {
    inner.number("time_offset_ns", o.lidar_time_offset_ns, -kMaxTimeOffset_ns, kMaxTimeOffset_ns);
  });
  io.section("ego", [&](auto& inner) {
    inner.choice("source", o.ego,
                 Choices<EgoSource>{
                     {"given", EgoSource::given}, {"rgbd", EgoSource::rgbd}, {"lidar", EgoSource::lidar}});
    visit(inner, o.odometry);
    inner.section("lidar", [&](auto& innermost) { visit(innermost, o.lidar); });
  });
  io.section("depth", [&](auto& inner) {
    inner.choice("source", o.depth,
                 Choices<DepthSource>{{"recorded", DepthSource::recorded},
                                      {"images", DepthSource::images},
                                      {"lidar", DepthSource::lidar}});
    inner.section("check", [&](auto& innermost) { visit(innermost, o.depth_check); });
    inner.flag("calibration", o.depth_calibration);
    inner.flag("drop_smeared_edges", o.drop_smeared_edges);
    inner.section("lidar", [&](auto& innermost) { visit(innermost, o.lidar_depth); });
  });
  io.section("segmentation", [&](auto& inner) { visit(inner, o.segmentation); });
  io.section("aot", [&](auto& inner) { visit(inner, o.aot); });
  io.section("features", [&](auto& inner) { visit(inner, o.features); });
  io.section("silhouettes", [&](auto& inner) { visit(inner, o.silhouettes); });
  io.section("points", [&](auto& inner) { visit(inner, o.points); });
  io.section("contact", [&](auto& inner) { visit(inner, o.contact); });
  io.section("scan_objects", [&](auto& inner) { visit(inner, o.scan_objects); });
}

}  // namespace uniquadric
