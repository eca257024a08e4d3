#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>

#include "estimator/images/dense_flow.h"
#include "estimator/mask_tracking/body_shift.h"
#include "estimator/mask_tracking/mask_tracker.h"

namespace uniquadric {

/// How the flow tracker carries masks.
struct FlowTrackerOptions {
  FlowOptions flow;
  static constexpr double depth_tolerance =
      0.05;  // ours: relative; ten sigma of depth noise, no body turns as much in a frame
  static constexpr double max_depth_change = 0.05;  // ours: relative, of a whole body in a frame: 3 m/s at 2
                                                    // m and 30 Hz; more is something else in its place
  double lost_share = 0.9;  // ours: of a mask's pixels; where flow finds fewer again, the body is looked for
                            // as a whole (body_shift.h), and the mask whose colours agree over more of it is
                            // taken; 0: never
  double most_turn_rad = 0.6;  // ours: by which such a body may have turned in the image since; bodies that
                               // are thrown turn by a few tenths in a frame; 0: it is only shifted
};

/// Carries masks by dense flow. Pixels whose depth has not moved with the body's are left out: background
/// that the flow took along.
class FlowTracker : public MaskTracker {
 public:
  explicit FlowTracker(const FlowTrackerOptions& options) : options_(options) {}
  void prepare(TrackedImage& image, const TrackedImage* previous) const override;
  void learn(const cv::Mat& /*masks*/, const TrackedImage& /*image*/) override {}
  CarriedMasks carry(const cv::Mat& masks, const TrackedImage& from, const TrackedImage& to) const override;

 private:
  struct CarriedBody {
    cv::Rect region;
    cv::Mat origins;               // where the region's pixels come from
    cv::Mat mask, expected_depth;  // of the region's size
    double seen_again(const TrackedImage& from, const TrackedImage& to, double color_scale) const;
  };
  CarriedBody carry_body(const cv::Mat& mask, const cv::Rect& small_box, const TrackedImage& from,
                         const TrackedImage& to, const cv::Mat& flow) const;
  bool is_lost(const cv::Mat& mask, const CarriedBody& body) const;
  std::optional<CarriedBody> find_whole(const cv::Mat& mask, const CarriedBody& by_flow,
                                        const SmallImages& small, const TrackedImage& from,
                                        const TrackedImage& to) const;

  FlowTrackerOptions options_;
};

}  // namespace uniquadric
