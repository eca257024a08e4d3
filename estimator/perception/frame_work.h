#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "estimator/base/stopwatch.h"
#include "estimator/lidar/frame_points.h"
#include "estimator/mask_tracking/aot.h"
#include "estimator/observation/perception.h"
#include "estimator/shape/object_points.h"

namespace uniquadric {

/// The outlines of a segmenter's result for an earlier frame.
struct LateOutlines {
  std::int64_t frame = 0;
  std::map<int, Silhouette> silhouettes;
};

/// A frame on its way through the stages of perception.
struct FrameWork {
  std::size_t index = 0;  ///< of the sequence's frames
  cv::Mat rgb, depth, masks;
  std::optional<Pose> world_from_camera;   ///< as it is known by now, but from features
  FramePoints points;                      ///< of the LiDAR, where the depth is its
  std::map<int, SurfacePoints> surfaces;   ///< of the bodies, by these
  std::vector<AotFrame::Arrived> arrived;  ///< results of the segmenter for earlier frames
  PerceivedFrame result;
  std::vector<LateOutlines> late;   ///< of `arrived`
  std::int64_t oldest_pending = 0;  ///< for no frame before it will there be any more of these
  std::vector<StageTime> times;
};

}  // namespace uniquadric
