#pragma once

#include <fmt/format.h>

#include "tests/evaluation/evaluate_fixture.h"

namespace uniquadric {

// An evaluation whose truth says how much of the cuboid (object 1) each frame shows; the others are in full
// view.
class VisibilityFixture : public Evaluate {
 protected:
  struct View {
    int visible_px = 1000, silhouette_px = 1000;
  };
  void write_visibility(const std::function<View(int)>& cuboid_at, std::int64_t period_ns = kPeriodNs) {
    std::string text = "frame,timestamp_ns,id,visible_px,silhouette_px,visible_fraction,touches_border\n";
    for (int frame = 0; frame < kFrames; ++frame)
      for (const ObjectDescription& object : kObjects) {
        const View view = object.id == 1 ? cuboid_at(frame) : View{};
        const double fraction = view.silhouette_px > 0 ? 1.0 * view.visible_px / view.silhouette_px : 0;
        text += fmt::format("{},{},{},{},{},{},0\n", frame, frame * period_ns, object.id, view.visible_px,
                            view.silhouette_px, fraction);
      }
    fs::create_directories(truth() / "instances");
    write_text(truth() / "instances/visibility.csv", text);
  }
};

}  // namespace uniquadric
