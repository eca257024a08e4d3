#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estimator/images/onnx_model.h"
#include "estimator/segmentation/prompts.h"

namespace uniquadric {

/// A promptable segmenter in the form of SAM (Kirillov et al., arXiv 2304.02643): an encoder run once an
/// image and a decoder run once a prompt, exported as two ONNX files with the inputs and outputs of SAM's own
/// exporter.
struct SamOptions {
  std::string encoder, decoder;  // ONNX files
  int input_px = 1024;           // side of the encoder's square input
  int decoder_points = 0;        // points of a prompt that the decoder was exported for; 0: any number, which
                                 // OpenCV 4.6 gets wrong in layers that reduce over them
  int grid = 8;              // ours: points a side that `everything` prompts with; SAM's own 32 take minutes
  double min_quality = 0.8;  // of the decoder's own guess of its mask's IoU; SAM's generator has 0.88
  double max_share = 0.3;    // ours: of the image; larger masks are the room
  static constexpr double max_overlap =
      0.5;  // ours: IoU above which the lesser of two masks of one body goes
};

/// What the decoder is asked for: points on one body, or its box.
struct SamPrompt {
  int id = 0;
  std::vector<PointPrompt> points;
  std::vector<BoxPrompt> box;  ///< one or none
};

/// Encoder and decoder of a SAM-style segmenter.
class SamSegmenter {
 public:
  /// Throws InputError when OpenCV refuses one of the networks.
  explicit SamSegmenter(const SamOptions& options);

  /// The mask of each prompt (CV_16UC1 by its id; where two claim a pixel the smaller mask has it). `rgb`
  /// CV_8UC3 in the order blue, green, red.
  cv::Mat segment(const cv::Mat& rgb, const std::vector<SamPrompt>& prompts) const;
  /// Everything: masks of a grid of points, the good ones, numbered from 1.
  cv::Mat segment_everything(const cv::Mat& rgb) const;

 private:
  struct Found {
    cv::Mat mask;  // CV_8UC1
    double quality = 0;
    int area_px = 0, id = 0;
  };
  cv::Mat encode(const cv::Mat& rgb) const;
  Found decode(const cv::Mat& embedding, const SamPrompt& prompt, const cv::Size& image) const;
  static cv::Mat paint(std::vector<Found> found, const cv::Size& image);

  SamOptions options_;
  OnnxModel encoder_, decoder_;
};

}  // namespace uniquadric
