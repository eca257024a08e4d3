#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "estimator/mask_tracking/appearance.h"

namespace uniquadric {

/// Gates of the backward association. All numbers are ours.
struct AssociationGates {
  static constexpr double min_iou =
      0.25;  // with the tracker's mask: half of a body that is a third of its width off
  static constexpr double min_fragment =
      0.5;  // share of a mask inside a track's that makes it a piece of that track
  static constexpr double max_depth_step = 0.05;  // relative, between pieces of one body
  static constexpr double min_similarity = 0.6;   // of colours: a body that comes back shows other sides
  static constexpr double sure_similarity =
      0.85;                                    // of colours: no need to wait for more of the body to be seen
  static constexpr double max_area_ratio = 3;  // of silhouettes in m^2, seen to known: more is another body
  static constexpr double reach_m = 0.5,
                          reach_mps = 1;    // of a hidden body about the line of its last velocity
  static constexpr double patience_s = 10;  // after that a hidden body is forgotten
  static constexpr double hold_s =
      0.5;  // how long a body that may be a hidden one is watched before it is called a new one
};

/// A body that is or was tracked.
struct KnownTrack {
  int id = 0;
  Appearance appearance;  // smoothed colours, last size and place
  double largest_area_m2 = 0, largest_area_px = 0;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  // camera frame
  std::int64_t seen_ns = 0;                                // stamp of the last result that showed it
  int missing = 0;                                         // results since, one after the other, that do not
  std::optional<std::int64_t> held_since_ns;  // when something was first seen that may be it, come back
};

/// A body in a segmenter's result.
struct Detection {
  int label = 0;  ///< value in the result's masks
  cv::Rect region;
  cv::Mat mask;  ///< CV_8UC1 of the region's size
  Appearance appearance;
};

/// Names the bodies of a segmenter's result: ids by label; labels left out are withheld for now. Two steps:
/// overlap with the tracker's masks of the same frame (Hungarian), then, for those left, a hidden body that
/// looks like it and could be there, or a new id. A piece inside a track's mask that another piece got is
/// named after it too.
class TrackBook {
 public:
  std::map<int, int> associate(const std::vector<Detection>& detections, const cv::Mat& tracked_masks,
                               std::int64_t stamp_ns);
  /// As above with the result's own labels for ids.
  std::map<int, int> trust(const std::vector<Detection>& detections, std::int64_t stamp_ns);
  const std::map<int, KnownTrack>& tracks() const { return tracks_; }

 private:
  void match_by_overlap(const std::vector<Detection>& detections, const cv::Mat& tracked_masks,
                        std::map<int, int>& ids) const;
  void match_by_looks(const std::vector<Detection>& detections, std::int64_t stamp_ns,
                      std::map<int, int>& ids);
  double likeness(const Detection& detection, const KnownTrack& track, std::int64_t stamp_ns) const;
  void learn(KnownTrack& track, const Appearance& seen, std::int64_t stamp_ns) const;
  void update(const std::vector<Detection>& detections, const std::map<int, int>& ids, std::int64_t stamp_ns);

  std::map<int, KnownTrack> tracks_;
  int next_id_ = 1;
};

}  // namespace uniquadric
