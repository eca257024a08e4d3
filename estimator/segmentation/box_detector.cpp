#include "estimator/segmentation/box_detector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"

namespace uniquadric {
namespace {

constexpr int kStrides[] = {8, 16, 32};
constexpr int kBoxValues = 5;     // x, y, w, h, objectness
constexpr double kPadding = 114;  // grey, as these networks are trained with

struct Scored {
  BoxPrompt box;
  double score = 0;
};

int cells(int input_px) {
  int count = 0;
  for (const int stride : kStrides) count += (input_px / stride) * (input_px / stride);
  return count;
}

Scored decode_row(const float* row, int classes, int x, int y, int stride, double scale) {
  const double width = std::exp(double{row[2]}) * stride, height = std::exp(double{row[3]}) * stride;
  const double left = (double{row[0]} + x) * stride - width / 2;
  const double top = (double{row[1]} + y) * stride - height / 2;
  const float best = *std::max_element(row + kBoxValues, row + kBoxValues + classes);
  return {{0, left / scale, top / scale, width / scale, height / scale}, row[4] * best};
}

// Greedy non-maximum suppression; `found` best first.
std::vector<BoxPrompt> without_doubles(const std::vector<Scored>& found, double max_overlap) {
  std::vector<BoxPrompt> kept;
  for (const Scored& candidate : found) {
    const auto overlaps = [&](const BoxPrompt& box) { return box_iou(box, candidate.box) > max_overlap; };
    if (std::any_of(kept.begin(), kept.end(), overlaps)) continue;
    kept.push_back(candidate.box);
    kept.back().id = static_cast<int>(kept.size());
  }
  return kept;
}

// The image scaled to fit, upper left in a grey square.
cv::Mat letterbox(const cv::Mat& rgb, int input_px, double scale) {
  cv::Mat square(input_px, input_px, CV_8UC3, cv::Scalar::all(kPadding)), small;
  cv::resize(rgb, small, {}, scale, scale, cv::INTER_LINEAR);
  const cv::Rect place = cv::Rect({0, 0}, small.size()) & cv::Rect(0, 0, input_px, input_px);
  small(place).copyTo(square(place));
  return square;
}

BoxPrompt cut(BoxPrompt box, const cv::Size& image) {
  const double right = std::min(box.x + box.width, image.width - 0.5);
  const double bottom = std::min(box.y + box.height, image.height - 0.5);
  box.x = std::max(box.x, -0.5);
  box.y = std::max(box.y, -0.5);
  box.width = right - box.x;
  box.height = bottom - box.y;
  return box;
}

}  // namespace

std::vector<BoxPrompt> decode_yolox(const cv::Mat& output, double scale, const DetectorOptions& options) {
  const int columns = output.size[2];
  std::vector<Scored> found;
  int row = 0;
  for (const int stride : kStrides)
    for (int y = 0; y < options.input_px / stride; ++y)
      for (int x = 0; x < options.input_px / stride; ++x, ++row) {
        const Scored box = decode_row(output.ptr<float>(0, row), columns - kBoxValues, x, y, stride, scale);
        if (box.score >= options.min_score && std::isfinite(box.box.width * box.box.height))
          found.push_back(box);
      }
  std::stable_sort(found.begin(), found.end(),
                   [](const Scored& a, const Scored& b) { return a.score > b.score; });
  return without_doubles(found, options.max_overlap);
}

std::vector<BoxPrompt> detect_boxes(const OnnxModel& model, const cv::Mat& rgb,
                                    const DetectorOptions& options) {
  const double scale = std::min(options.input_px / static_cast<double>(rgb.cols),
                                options.input_px / static_cast<double>(rgb.rows));
  const cv::Mat blob = cv::dnn::blobFromImage(letterbox(rgb, options.input_px, scale));
  const cv::Mat output = model.run({{"", blob}}, model.output_names()).front();
  if (output.dims != 3 || output.size[1] != cells(options.input_px) || output.size[2] <= kBoxValues)
    throw InputError(model.file(),
                     fmt::format("is no YOLOX detector for {0}x{0}: expected an output of 1 x {1} x "
                                 "(5 + classes)",
                                 options.input_px, cells(options.input_px)));
  std::vector<BoxPrompt> boxes;
  for (const BoxPrompt& box : decode_yolox(output, scale, options)) {
    const BoxPrompt inside = cut(box, rgb.size());
    if (inside.width > 1 && inside.height > 1) boxes.push_back(inside);
  }
  return boxes;
}

}  // namespace uniquadric
