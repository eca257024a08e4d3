#pragma once

#include "estimator/ego/ego_options.h"
#include "estimator/features/feature_options.h"
#include "estimator/mask_tracking/aot_options.h"
#include "estimator/perception/perceive.h"
#include "estimator/segmentation/segmenter.h"

namespace uniquadric {

/// Names the options' keys, for reading and writing (option_io.h).
template <typename Io>
void visit(Io& io, PointOptions& o) {
  io.number("smooth_px", o.smooth_px, 0, 20);
  io.number("erode_px", o.erode_px, 0, 100);
  io.positive("max_depth_m", o.max_depth_m);
  io.positive("voxel_m", o.voxel_m);
  io.number("max_points", o.max_points, 4);
  io.number("min_points", o.min_points, 4);
}

template <typename Io>
void visit(Io& io, ContactOptions& o) {
  io.flag("enabled", o.enabled);
  io.positive("ring", o.ring);
}

template <typename Io>
void visit(Io& io, DepthCheckOptions& o) {
  io.flag("enabled", o.enabled);
  io.number("max_gap_s", o.max_gap_s, 0.0, 1e6);
}

template <typename Io>
void visit(Io& io, SilhouetteOptions& o) {
  io.number("directions", o.directions, 4, 360);
}

template <typename Io>
void visit(Io& io, BodyTwistOptions& o) {
  io.number("reach_px", o.reach_px, 0.5, 200.0);
  io.number("max_jump", o.max_jump, kLeastJump, kMostJump);
  io.number("max_points", o.max_points, 10, 1'000'000);
}

template <typename Io>
void visit(Io& io, PointPlaneOptions& o) {
  io.number("reach_px", o.reach_px, 0.5, 200.0);
  io.number("max_jump", o.max_jump, kLeastJump, kMostJump);
}

template <typename Io>
void visit(Io& io, LidarDepthOptions& o) {
  io.choice("undistortion", o.undistortion,
            Choices<Undistortion>{
                {"none", Undistortion::none}, {"ego", Undistortion::ego}, {"object", Undistortion::object}});
  io.choice("motion", o.motion,
            Choices<MotionSource>{{"points", MotionSource::points}, {"features", MotionSource::features}});
  io.section("twist", [&](auto& inner) { visit(inner, o.twist); });
  io.number("erode_px", o.erode_px, 0, 100);
  visit(io, o.planes);
  io.number("max_points", o.max_points, 1, 1'000'000);
}

template <typename Io>
void visit(Io& io, ScanObjectOptions& o) {
  io.flag("enabled", o.enabled);
  io.flag("masks", o.masks);
  io.positive("cell_m", o.clusters.cell_m);
  io.number("min_points", o.clusters.min_points, 4, 1'000'000);
  io.flag("moving_only", o.tracker.moving_only);
  io.number("width_deg", o.width_deg, 1.0, 160.0);
  io.number("height_deg", o.height_deg, 1.0, 160.0);
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
