#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estimator/images/onnx_model.h"
#include "estimator/segmentation/prompts.h"

namespace uniquadric {

/// A detector of the YOLOX family (Ge et al., arXiv 2107.08430): its boxes are prompts.
struct DetectorOptions {
  std::string model;       // ONNX file: input 1x3xSxS (blue, green, red, 0 to 255), output 1xNx(5+classes)
  int input_px = 416;      // S, as yolox_nano has it
  double min_score = 0.3;  // ours: objectness times the best class's probability
  static constexpr double max_overlap =
      0.45;  // ours: IoU above which the lesser of two boxes of one body goes
};

/// Boxes and scores (best first) of the network's output on an image that was scaled by `scale`: for each
/// cell of the grids with strides of 8, 16 and 32 px a row of x, y (offset from the cell, in strides), log
/// width, log height (of strides), objectness and the classes' probabilities. Classes are not told apart:
/// what a body is called does not matter here.
std::vector<BoxPrompt> decode_yolox(const cv::Mat& output, double scale, const DetectorOptions& options);

/// Boxes of one image (CV_8UC3), their ids 1, 2, ... with falling score, cut at the image's border.
std::vector<BoxPrompt> detect_boxes(const OnnxModel& model, const cv::Mat& rgb,
                                    const DetectorOptions& options);

}  // namespace uniquadric
