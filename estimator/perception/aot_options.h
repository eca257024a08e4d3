#pragma once

#include "estimator/option_io.h"
#include "estimator/perception/aot.h"

namespace uniquadric {

/// Names the options' keys, for reading and writing (option_io.h).
template <typename Io>
void visit(Io& io, FlowTrackerOptions& o) {
  using Preset = FlowOptions::Preset;
  io.choice(
      "preset", o.flow.preset,
      Choices<Preset>{{"ultrafast", Preset::ultrafast}, {"fast", Preset::fast}, {"medium", Preset::medium}});
  io.number("downscale", o.flow.downscale, 1, 8);
  io.positive("depth_tolerance", o.depth_tolerance);
  io.positive("max_depth_change", o.max_depth_change);
  io.number("lost_share", o.lost_share, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, NanoTrackOptions& o) {
  io.text("backbone", o.backbone);
  io.text("head", o.head);
  io.number("window_influence", o.window_influence, 0.0, 1.0);
  io.number("size_penalty", o.size_penalty, 0.0, 10.0);
  io.number("learning_rate", o.learning_rate, 0.0, 1.0);
  io.number("min_score", o.min_score, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, MaskEdgeOptions& o) {
  io.number("reach_px", o.reach_px, 0, 50);
  io.positive("jump", o.jump);
}

template <typename Io>
void visit(Io& io, AssociationOptions& o) {
  io.number("min_iou", o.min_iou, 0.0, 1.0);
  io.number("min_fragment", o.min_fragment, 0.0, 1.0);
  io.positive("max_depth_step", o.max_depth_step);
  io.number("min_similarity", o.min_similarity, 0.0, 1.0);
  io.number("sure_similarity", o.sure_similarity, 0.0, 1.0);
  io.positive("max_area_ratio", o.max_area_ratio);
  io.number("reach_m", o.reach_m, 0.0);
  io.number("reach_mps", o.reach_mps, 0.0);
  io.number("patience_s", o.patience_s, 0.0);
  io.number("hold_s", o.hold_s, 0.0);
}

template <typename Io>
void visit(Io& io, AotOptions& o) {
  io.flag("enabled", o.enabled);
  io.choice("clock", o.clock,
            Choices<AotClock>{{"virtual", AotClock::virtual_time}, {"threads", AotClock::threads}});
  io.choice("latency", o.latency,
            Choices<AotLatency>{{"sequence", AotLatency::sequence}, {"fixed", AotLatency::fixed}});
  io.number("latency_s", o.latency_s, 0.0, 60.0);
  io.flag("trust_ids", o.trust_ids);
  io.number("min_pixels", o.min_pixels, 1);
  io.number("clear_growth", o.clear_growth, 0.0, 10.0);
  io.number("jump_iou", o.jump_iou, 0.0, 1.0);
  io.number("max_missing", o.max_missing, 1);
  io.positive("max_silence_s", o.max_silence_s);
  io.positive("max_gap_s", o.max_gap_s);
  io.choice(
      "tracker", o.tracker,
      Choices<MaskTrackerKind>{{"flow", MaskTrackerKind::flow}, {"nanotrack", MaskTrackerKind::nanotrack}});
  io.section("flow", [&](auto& inner) { visit(inner, o.flow); });
  io.section("nanotrack", [&](auto& inner) { visit(inner, o.nano); });
  io.section("edges", [&](auto& inner) { visit(inner, o.edges); });
  io.section("association", [&](auto& inner) { visit(inner, o.association); });
}

}  // namespace uniquadric
