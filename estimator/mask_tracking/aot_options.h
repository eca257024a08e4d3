#pragma once

#include "estimator/base/option_io.h"
#include "estimator/mask_tracking/aot.h"

namespace uniquadric {

/// Names the options' keys, for reading and writing (option_io.h).
template <typename Io>
void visit(Io& io, FlowTrackerOptions& o) {
  using Preset = FlowOptions::Preset;
  io.choice(
      "preset", o.flow.preset,
      Choices<Preset>{{"ultrafast", Preset::ultrafast}, {"fast", Preset::fast}, {"medium", Preset::medium}});
  io.number("downscale", o.flow.downscale, 1, 8);
  io.number("lost_share", o.lost_share, 0.0, 1.0);
  io.number("most_turn_rad", o.most_turn_rad, 0.0, 3.2);
}

template <typename Io>
void visit(Io& io, NanoTrackOptions& o) {
  io.text("backbone", o.backbone);
  io.text("head", o.head);
  io.number("min_score", o.min_score, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, MaskEdgeOptions& o) {
  io.number("reach_px", o.reach_px, 0, 50);
  io.positive("jump", o.jump);
  io.flag("colors", o.colors);
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
  io.number("clear_growth", o.clear_growth, 0.0, 10.0);
  io.positive("max_gap_s", o.max_gap_s);
  io.choice(
      "tracker", o.tracker,
      Choices<MaskTrackerKind>{{"flow", MaskTrackerKind::flow}, {"nanotrack", MaskTrackerKind::nanotrack}});
  io.section("flow", [&](auto& inner) { visit(inner, o.flow); });
  io.section("nanotrack", [&](auto& inner) { visit(inner, o.nano); });
  io.section("edges", [&](auto& inner) { visit(inner, o.edges); });
}

}  // namespace uniquadric
