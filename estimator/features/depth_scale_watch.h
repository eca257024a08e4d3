#pragma once

#include <cstdint>

#include "estimator/features/frame_view.h"
#include "estimator/features/tracked_body.h"

namespace uniquadric {

/// Notices depth images whose scale jumps by less than DepthCheck sees: with the camera placed by pixels
/// alone, the depths of the background's points are compared with those that its map predicts. The map's own
/// scale is of the images before.
class DepthScaleWatch {
 public:
  /// `refused`: this frame's depth has another scale than the last one that was believed. `changed`: it
  /// stayed for max_scale_refused_s, or in more frames than the one before was believed in, and is how it is;
  /// what was mapped before has the wrong one.
  enum class Verdict { believed, refused, changed };
  Verdict judge(const FrameView& view, const TrackedBody& background, std::int64_t stamp_ns);

 private:
  double scale_ = 1;  // of the last image that was believed, to the map
  int map_ = -1;      // of the background, that it is to
  int believed_ = 0, refused_ = 0;
  std::int64_t refused_since_ns_ = 0;
};

}  // namespace uniquadric
