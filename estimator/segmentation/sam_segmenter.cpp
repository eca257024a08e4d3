#include "estimator/segmentation/sam_segmenter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"

namespace uniquadric {
namespace {

// The labels of SAM's prompt encoder.
constexpr float kNoPoint = -1, kOnTheBody = 1, kBoxCorner = 2, kOtherBoxCorner = 3;
constexpr int kMaskInput_px = 256;
const cv::Scalar kMean(123.675, 116.28, 103.53),
    kDeviation(58.395, 57.12, 57.375);  // red, green, blue: SAM's

double scale_of(const cv::Size& image, int input_px) {
  return input_px / static_cast<double>(std::max(image.width, image.height));
}

cv::Mat tensor(const std::vector<int>& shape, const std::vector<float>& values) {
  return cv::Mat(shape, CV_32F, const_cast<float*>(values.data())).clone();
}

// Coordinates in the encoder's input and labels; a prompt without a box ends with a point that is none.
void add_points(const SamPrompt& prompt, double scale, std::vector<float>& coordinates,
                std::vector<float>& labels) {
  const auto add = [&](double u, double v, float label) {
    coordinates.push_back(
        static_cast<float>((u + 0.5) * scale - 0.5));  // pixel centres are integers there too
    coordinates.push_back(static_cast<float>((v + 0.5) * scale - 0.5));
    labels.push_back(label);
  };
  for (const PointPrompt& point : prompt.points) add(point.u, point.v, kOnTheBody);
  for (const BoxPrompt& box : prompt.box) {
    add(box.x, box.y, kBoxCorner);
    add(box.x + box.width, box.y + box.height, kOtherBoxCorner);
  }
  if (prompt.box.empty()) {
    coordinates.insert(coordinates.end(), {0, 0});
    labels.push_back(kNoPoint);
  }
}

// To the number of points that the decoder was exported for.
void pad_points(int count, const SamOptions& options, std::vector<float>& coordinates,
                std::vector<float>& labels) {
  if (count == 0) return;
  if (std::ssize(labels) > count)
    throw InputError(
        options.decoder,
        fmt::format("takes {} points, a prompt has {} with the one that ends it", count, labels.size()));
  coordinates.resize(2 * static_cast<std::size_t>(count), 0);
  labels.resize(static_cast<std::size_t>(count), kNoPoint);
}

// A mask of the image from logits over the encoder's square input.
cv::Mat mask_of(const cv::Mat& logits, const cv::Size& image, int input_px) {
  const double scale = scale_of(image, input_px) * logits.cols / input_px;  // image to logits
  cv::Mat full;
  const cv::Matx23d image_from_logits(1 / scale, 0, 0.5 / scale - 0.5, 0, 1 / scale, 0.5 / scale - 0.5);
  cv::warpAffine(logits, full, image_from_logits, image, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return full > 0;
}

double iou(const cv::Mat& a, const cv::Mat& b) {
  const int both = cv::countNonZero(a & b);
  return both == 0 ? 0 : both / static_cast<double>(cv::countNonZero(a | b));
}

}  // namespace

SamSegmenter::SamSegmenter(const SamOptions& options)
    : options_(options), encoder_(options.encoder), decoder_(options.decoder) {}

cv::Mat SamSegmenter::encode(const cv::Mat& rgb) const {
  const double scale = scale_of(rgb.size(), options_.input_px);
  cv::Mat small, colours, square = cv::Mat::zeros(options_.input_px, options_.input_px, CV_32FC3);
  cv::resize(rgb, small, {}, scale, scale, cv::INTER_LINEAR);
  cv::cvtColor(small, colours, cv::COLOR_BGR2RGB);
  colours.convertTo(colours, CV_32F);
  cv::subtract(colours, kMean, colours);
  cv::divide(colours, kDeviation, colours);
  const cv::Rect place = cv::Rect({0, 0}, colours.size()) & cv::Rect({0, 0}, square.size());
  colours(place).copyTo(square(place));
  return encoder_.run({{"", cv::dnn::blobFromImage(square)}}, encoder_.output_names()).front();
}

SamSegmenter::Found SamSegmenter::decode(const cv::Mat& embedding, const SamPrompt& prompt,
                                         const cv::Size& image) const {
  std::vector<float> coordinates, labels;
  add_points(prompt, scale_of(image, options_.input_px), coordinates, labels);
  pad_points(options_.decoder_points, options_, coordinates, labels);
  const int n = static_cast<int>(labels.size());
  const std::vector<float> no_mask(std::size_t{kMaskInput_px} * kMaskInput_px, 0.0F);
  const auto outputs = decoder_.run(
      {{"image_embeddings", embedding},
       {"point_coords", tensor({1, n, 2}, coordinates)},
       {"point_labels", tensor({1, n}, labels)},
       {"mask_input", tensor({1, 1, kMaskInput_px, kMaskInput_px}, no_mask)},
       {"has_mask_input", tensor({1, 1}, {0})},
       {"orig_im_size", tensor({1, 2}, {static_cast<float>(image.height), static_cast<float>(image.width)})}},
      {"low_res_masks", "iou_predictions"});
  const cv::Mat &masks = outputs[0], &qualities = outputs[1];
  if (masks.dims != 4 || masks.size[2] != masks.size[3] ||
      qualities.total() != static_cast<std::size_t>(masks.size[1]))
    throw InputError(decoder_.file(),
                     "is no decoder of SAM's form: low_res_masks is not 1 x M x S x S, or "
                     "iou_predictions not M numbers");
  Found best;
  best.id = prompt.id;
  for (int m = 0; m < masks.size[1]; ++m) {
    const double quality = qualities.ptr<float>()[m];
    if (!std::isfinite(quality))
      throw InputError(decoder_.file(), "gives a quality (iou_predictions) that is no number");
    if (m > 0 && quality <= best.quality) continue;
    const cv::Mat logits(masks.size[2], masks.size[3], CV_32F, const_cast<float*>(masks.ptr<float>(0, m)));
    best.quality = quality;
    best.mask = mask_of(logits, image, options_.input_px);
  }
  best.area_px = cv::countNonZero(best.mask);
  return best;
}

cv::Mat SamSegmenter::paint(std::vector<Found> found, const cv::Size& image) {
  std::stable_sort(found.begin(), found.end(),
                   [](const Found& a, const Found& b) { return a.area_px > b.area_px; });
  cv::Mat masks = cv::Mat::zeros(image, CV_16UC1);
  for (const Found& one : found) masks.setTo(one.id, one.mask);
  return masks;
}

cv::Mat SamSegmenter::segment(const cv::Mat& rgb, const std::vector<SamPrompt>& prompts) const {
  if (prompts.empty()) return cv::Mat::zeros(rgb.size(), CV_16UC1);
  const cv::Mat embedding = encode(rgb);
  std::vector<Found> found;
  for (const SamPrompt& prompt : prompts) found.push_back(decode(embedding, prompt, rgb.size()));
  return paint(std::move(found), rgb.size());
}

cv::Mat SamSegmenter::segment_everything(const cv::Mat& rgb) const {
  const cv::Mat embedding = encode(rgb);
  std::vector<Found> found;
  for (int i = 0; i < options_.grid * options_.grid; ++i) {
    const double u = (i % options_.grid + 0.5) * rgb.cols / options_.grid - 0.5;
    const double v = (i / options_.grid + 0.5) * rgb.rows / options_.grid - 0.5;
    Found one = decode(embedding, {0, {{0, u, v}}, {}}, rgb.size());
    const bool is_body =
        one.area_px > 0 && one.area_px <= options_.max_share * static_cast<double>(rgb.total());
    if (one.quality >= options_.min_quality && is_body) found.push_back(std::move(one));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Found& a, const Found& b) { return a.quality > b.quality; });
  std::vector<Found> kept;
  for (Found& one : found) {
    const auto overlaps = [&](const Found& other) {
      return iou(other.mask, one.mask) > options_.max_overlap;
    };
    if (std::any_of(kept.begin(), kept.end(), overlaps)) continue;
    one.id = static_cast<int>(kept.size()) + 1;
    kept.push_back(std::move(one));
  }
  return paint(std::move(kept), rgb.size());
}

}  // namespace uniquadric
