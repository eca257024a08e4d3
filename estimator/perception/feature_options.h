#pragma once

#include "estimator/option_io.h"
#include "estimator/perception/features.h"

namespace uniquadric {

inline constexpr double kLeastJump = 1e-4,
                        kMostJump = 0.9;  // of relative depth: rounding, and all that there is

/// Names the options' keys, for reading and writing (option_io.h).
template <typename Io>
void visit(Io& io, RigidMotionOptions& o) {
  io.positive("pixel_sigma", o.pixel_sigma, kSigma_px);
  io.positive("pixel_gate", o.pixel_gate);
  io.positive("depth_gate", o.depth_gate);
  io.number("depth_slack_m", o.depth_slack_m, 0.0, 10.0);
  io.number("iterations", o.iterations, 1, kMostIterations);
  io.number("min_inliers", o.min_inliers, 3, 10'000);
  io.number("min_share", o.min_share, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, PlaneDepthOptions& o) {
  io.number("half_window_px", o.half_window_px, 1, 10);
  io.number("half_wide_px", o.half_wide_px, 0, 10);
  io.number("max_jump", o.max_jump, kLeastJump, kMostJump);
  io.number("min_share", o.min_share, 0.0, 1.0);
  io.positive("outlier_sigmas", o.outlier_sigmas);
  io.positive("agreement_sigmas", o.agreement_sigmas);
  io.number("curvature_share", o.curvature_share, 0.0, 10.0);
  io.number("min_sigma", o.min_sigma, 0.0, 1.0);
  io.flag("correlated_noise", o.correlated_noise);
}

template <typename Io>
void visit(Io& io, GalleryOptions& o) {
  io.number("body_tracks", o.body_tracks, 0, 1'000'000);
  io.number("background_tracks", o.background_tracks, 0, 1'000'000);
  io.number("min_sightings", o.min_sightings, 1, 1000);
  io.number("max_distance", o.max_distance, 0, 256);
  io.number("max_ratio", o.max_ratio, 0.0, 1.0);
  io.number("min_matches", o.min_matches, 3, 10'000);
  io.number("min_share", o.min_share, 0.0, 1.0);
  io.positive("pixel_gate", o.pixel_gate);
  io.flag("look_where_left", o.look_where_left);
}

template <typename Io>
void visit(Io& io, FeatureOptions& o) {
  io.number("body_features", o.body_features, 8, 10'000);
  io.number("background_features", o.background_features, 8, 100'000);
  io.number("fast_threshold", o.fast_threshold, 1, 255);
  io.positive("min_distance_px", o.min_distance_px);
  io.number("start_margin_px", o.start_margin_px, 1, 100);
  io.number("keep_margin_px", o.keep_margin_px, 1, 100);
  io.number("max_missed", o.max_missed, 0, 1000);
  io.number("max_prediction_gap_s", o.max_prediction_gap_s, 0.0, 1e6);
  io.number("max_anchor_warp", o.max_anchor_warp, 1.0, 10.0);
  io.number("min_anchor_correlation", o.min_anchor_correlation, 0.0, 1.0);
  io.positive("max_pixel_sigma", o.max_pixel_sigma, kSigma_px);
  io.positive("max_slip_px", o.max_slip_px);
  io.positive("aligned_pixel_gate", o.aligned_pixel_gate);
  io.positive("max_scale_change", o.max_scale_change);
  io.number("max_scale_refused_s", o.max_scale_refused_s, 0.0, 1e6);
  io.section("flow", [&](auto& inner) {
    inner.number("window_px", o.flow.window_px, 3, 100);
    inner.number("levels", o.flow.levels, 0, 8);
    inner.number("iterations", o.flow.iterations, 1, 1000);
    inner.positive("min_eigenvalue", o.flow.min_eigenvalue);
    inner.positive("max_round_trip_px", o.flow.max_round_trip_px);
  });
  io.section("alignment", [&](auto& inner) {
    inner.number("half_window_px", o.alignment.half_window_px, 2, 8);
    inner.number("iterations", o.alignment.iterations, 1, 1000);
    inner.positive("max_shift_px", o.alignment.max_shift_px);
    inner.number("min_correlation", o.alignment.min_correlation, 0.0, 1.0);
  });
  io.section("depth", [&](auto& inner) { visit(inner, o.depth); });
  io.section("motion", [&](auto& inner) { visit(inner, o.motion); });
  io.section("rolling_shutter", [&](auto& inner) {
    inner.flag("enabled", o.rolling_shutter.enabled);
    inner.positive("velocity_sigma_mps", o.rolling_shutter.velocity_sigma_mps);
    inner.positive("turn_sigma_radps", o.rolling_shutter.turn_sigma_radps);
  });
  io.section("gallery", [&](auto& inner) { visit(inner, o.gallery); });
}

}  // namespace uniquadric
