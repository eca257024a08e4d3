#pragma once

#include "estimator/base/option_io.h"
#include "estimator/features/features.h"

namespace uniquadric {

inline constexpr double kLeastJump = 1e-4,
                        kMostJump = 0.9;  // of relative depth: rounding, and all that there is

/// Names the options' keys, for reading and writing (option_io.h).
template <typename Io>
void visit(Io& io, RigidMotionOptions& o) {
  io.number("iterations", o.iterations, 1, kMostIterations);
  io.number("min_inliers", o.min_inliers, 3, 10'000);
}

template <typename Io>
void visit(Io& io, PlaneDepthOptions& o) {
  io.number("max_jump", o.max_jump, kLeastJump, kMostJump);
  io.number("min_sigma", o.min_sigma, 0.0, 1.0);
  io.flag("correlated_noise", o.correlated_noise);
}

template <typename Io>
void visit(Io& io, GalleryOptions& o) {
  io.flag("look_where_left", o.look_where_left);
}

template <typename Io>
void visit(Io& io, FeatureOptions& o) {
  io.number("body_features", o.body_features, 8, 10'000);
  io.positive("max_pixel_sigma", o.max_pixel_sigma, kSigma_px);
  io.number("max_scale_refused_s", o.max_scale_refused_s, 0.0, 1e6);
  io.section("flow", [&](auto& inner) {
    inner.number("levels", o.flow.levels, 0, 8);
    inner.number("iterations", o.flow.iterations, 1, 1000);
  });
  io.section("alignment", [&](auto& inner) { inner.number("iterations", o.alignment.iterations, 1, 1000); });
  io.section("depth", [&](auto& inner) { visit(inner, o.depth); });
  io.section("motion", [&](auto& inner) { visit(inner, o.motion); });
  io.section("rolling_shutter", [&](auto& inner) { inner.flag("enabled", o.rolling_shutter.enabled); });
  io.section("gallery", [&](auto& inner) { visit(inner, o.gallery); });
}

}  // namespace uniquadric
