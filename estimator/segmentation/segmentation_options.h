#pragma once

#include "estimator/base/option_io.h"
#include "estimator/segmentation/segmentation.h"

namespace uniquadric {

// Names of the options' keys, for reading and writing (option_io.h).

template <typename Io>
void visit(Io& io, GrabcutOptions& o) {
  io.number("iterations", o.iterations, 1, 100);
  io.number("downscale", o.downscale, 1, 16);
  io.number("rim", o.rim, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, DepthPartsOptions& o) {
  io.positive("jump", o.jump);
}

template <typename Io>
void visit(Io& io, MotionSplitOptions& o) {
  io.number("frames", o.frames, 1, 1000);
  io.number("samples", o.samples, 10, 100'000);
  io.number("moving_ratio", o.moving_ratio, 0.0, 1000.0);
}

template <typename Io>
void visit(Io& io, SamOptions& o) {
  io.text("encoder", o.encoder);
  io.text("decoder", o.decoder);
  io.number("input_px", o.input_px, 16, 4096);
  io.number("decoder_points", o.decoder_points, 0, 1000);
  io.number("grid", o.grid, 1, 64);
  io.number("min_quality", o.min_quality, 0.0, 1.0);
  io.number("max_share", o.max_share, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, DetectorOptions& o) {
  io.text("model", o.model);
  io.number("input_px", o.input_px, 32, 4096);
  io.number("min_score", o.min_score, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, SegmentationOptions& o) {
  io.choice("source", o.source,
            Choices<MaskSource>{{"automatic", MaskSource::automatic},
                                {"sequence", MaskSource::sequence},
                                {"grabcut_depth", MaskSource::grabcut_depth},
                                {"depth_motion", MaskSource::depth_motion},
                                {"sam", MaskSource::sam},
                                {"detector", MaskSource::detector},
                                {"none", MaskSource::none}});
  io.section("grabcut_depth", [&](auto& inner) { visit(inner, o.grabcut_depth); });
  io.section("depth_parts", [&](auto& inner) { visit(inner, o.depth_parts); });
  io.section("motion_split", [&](auto& inner) { visit(inner, o.motion_split); });
  io.section("sam", [&](auto& inner) { visit(inner, o.sam); });
  io.section("detector", [&](auto& inner) { visit(inner, o.detector); });
}

}  // namespace uniquadric
