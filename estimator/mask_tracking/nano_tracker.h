#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "estimator/images/onnx_model.h"
#include "estimator/mask_tracking/mask_tracker.h"

namespace uniquadric {

/// NanoTrack v1, a Siamese box tracker of two networks. The numbers without a word are those it was published
/// with.
struct NanoTrackOptions {
  std::string backbone, head;  // ONNX files
  static constexpr double window_influence = 0.455;
  static constexpr double size_penalty = 0.055;
  double learning_rate = 0.37;  // of the box's size
  double min_score = 0.3;       // ours: a worse match leaves the box where it was
};

/// A box by its middle and size [px].
struct NanoBox {
  Eigen::Vector2d center = Eigen::Vector2d::Zero(), size = Eigen::Vector2d::Zero();
};

/// The best box of the head's outputs (scores 1x2xSxS, sides 1x4xSxS) and its score, from a search window
/// that was cut around `previous` and scaled by `scale`. Scores are the softmax of two channels; the sides'
/// channels are the distances to the left, upper, right and lower side from a grid of 16 px; boxes are
/// penalised for a change of size and proportions, and for their distance from the middle by a Hanning
/// window.
std::optional<NanoBox> decode_nanotrack(const cv::Mat& scores, const cv::Mat& sides, const NanoBox& previous,
                                        double scale, const NanoTrackOptions& options);

/// Carries masks by the motion of their boxes: a mask is moved and scaled with its box, and depth mends its
/// outline afterwards.
class NanoTracker : public MaskTracker {
 public:
  /// Throws InputError when OpenCV refuses one of the networks.
  explicit NanoTracker(const NanoTrackOptions& options);
  void prepare(TrackedImage& /*image*/, const TrackedImage* /*previous*/) const override {}
  void learn(const cv::Mat& masks, const TrackedImage& image) override;
  CarriedMasks carry(const cv::Mat& masks, const TrackedImage& from, const TrackedImage& to) const override;

 private:
  cv::Mat features(const cv::Mat& crop) const;
  NanoBox find(const cv::Mat& template_features, const NanoBox& previous, const cv::Mat& rgb) const;

  NanoTrackOptions options_;
  OnnxModel backbone_, head_;
  std::map<int, cv::Mat> templates_;  // features of each body as it was last segmented
};

}  // namespace uniquadric
