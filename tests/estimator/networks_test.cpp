// Networks: written by the tests themselves, and the real ones where they are at hand.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/sequence/sequence.h"
#include "drawn_world.h"
#include "estimator/mask_tracking/nano_tracker.h"
#include "estimator/segmentation/box_detector.h"
#include "estimator/segmentation/sam_segmenter.h"
#include "tests/support/onnx_writer.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

const Sprite kRed{
    1,        31, {30, 30, 220},
    {72, 48}, 2,  [](std::int64_t n) {
                    return Eigen::Vector2d(80 + 3.0 * static_cast<double>(n), 96); }};
const Sprite kOtherRed{2,        31, {30, 30, 220},
                       {40, 40}, 2,  [](std::int64_t) { return Eigen::Vector2d(240, 30); }};

fs::path models() {
  return fs::path(UNIQUADRIC_SOURCE_DIR) / "../shared/data/models";
}

// An encoder for 64 x 64 images whose embedding is their mean colours on a grid of 16 x 16.
void write_encoder(const fs::path& file) {
  OnnxWriter writer;
  writer.input("images", {1, 3, 64, 64});
  std::vector<float> mean(3 * 3 * 16, 0.0F);
  for (int channel = 0; channel < 3; ++channel)
    for (int i = 0; i < 16; ++i) mean[(channel * 3 + channel) * 16 + i] = 1 / 16.0F;
  writer.constant("mean", {3, 3, 4, 4}, mean);
  writer.node("Conv", {"images", "mean"}, "embeddings", {{"kernel_shape", {4, 4}}, {"strides", {4, 4}}});
  writer.output("embeddings", {1, 3, 16, 16});
  writer.write(file);
}

// A decoder that finds what is much redder than green, wherever it is asked for, and guesses a quality that
// falls with the prompt's coordinates.
void write_decoder(const fs::path& file) {
  OnnxWriter writer;
  writer.input("image_embeddings", {1, 3, 16, 16});
  writer.input("point_coords", {1, 3, 2});
  writer.input("point_labels", {1, 3});
  writer.input("mask_input", {1, 1, 256, 256});
  writer.input("has_mask_input", {1, 1});
  writer.input("orig_im_size", {1, 2});
  writer.constant("redness", {1, 3, 1, 1}, {1, -1, 0});
  writer.constant("threshold", {1}, {-1.5});
  writer.node("Conv", {"image_embeddings", "redness", "threshold"}, "low_res_masks",
              {{"kernel_shape", {1, 1}}});
  const auto reduce = [&](const std::string& from, const std::string& to, const OnnxWriter::Shape& axes,
                          int keep) {
    writer.node("ReduceMean", {from}, to, {{"axes", axes}}, {{"keepdims", keep}});
  };
  reduce("point_coords", "coordinate_of_each", {2}, 0);
  reduce("coordinate_of_each", "mean_coordinate", {1}, 1);
  reduce("point_labels", "mean_label", {1}, 1);
  reduce("mask_input", "mean_mask", {2, 3}, 0);
  reduce("orig_im_size", "mean_size", {1}, 1);
  writer.constant("slope", {1, 1}, {-0.01F});
  writer.constant("start", {1, 1}, {1});
  writer.constant("nothing", {1, 1}, {0});
  writer.node("Mul", {"mean_coordinate", "slope"}, "fall");
  writer.node("Add", {"fall", "start"}, "sum_0");
  int terms = 0;  // every input is used, as in the real one
  for (const char* name : {"mean_label", "mean_mask", "has_mask_input", "mean_size"}) {
    const std::string n = std::to_string(terms++);
    writer.node("Mul", {name, "nothing"}, "none_" + n);
    writer.node("Add", {"sum_" + n, "none_" + n},
                terms < 4 ? "sum_" + std::to_string(terms) : "iou_predictions");
  }
  writer.output("low_res_masks", {1, 1, 16, 16});
  writer.output("iou_predictions", {1, 1});
  writer.write(file);
}

SamOptions tiny_sam(const TempFolder& temp) {
  write_encoder(temp.path() / "encoder.onnx");
  write_decoder(temp.path() / "decoder.onnx");
  SamOptions options;
  options.encoder = temp.path() / "encoder.onnx";
  options.decoder = temp.path() / "decoder.onnx";
  options.input_px = 64;
  options.decoder_points = 3;
  options.min_quality = 0.7;
  return options;
}

TEST(Networks, ASamPairSegmentsWhatPointsAndBoxesMean) {
  const TempFolder temp;
  const SamSegmenter sam(tiny_sam(temp));
  const DrawnFrame drawn = draw_world({kRed}, 0);
  const std::vector<SamPrompt> prompts = {{7, {{7, 100, 110}}, {}}};
  const cv::Mat by_point = sam.segment(drawn.rgb, prompts);
  EXPECT_EQ(cv::countNonZero((by_point != 0) & (by_point != 7)), 0);
  // A cell of the mask stands for 20 x 20 pixels of the image, and is interpolated.
  EXPECT_GT(mask_iou(by_point == 7, drawn.masks == 1), 0.8);
  const cv::Mat by_box = sam.segment(drawn.rgb, {{3, {}, {{3, 80, 96, 72, 48}}}});
  EXPECT_EQ(cv::countNonZero((by_box == 3) != (by_point == 7)), 0);
  EXPECT_EQ(cv::countNonZero(sam.segment(drawn.rgb, {})), 0);
}

TEST(Networks, MorePointsThanADecoderTakesAreRefused) {
  const TempFolder temp;
  const SamSegmenter sam(tiny_sam(temp));
  const SamPrompt three = {7, {{7, 100, 110}, {7, 101, 110}, {7, 102, 110}}, {}};
  const std::string message = input_error([&] { sam.segment(draw_world({kRed}, 0).rgb, {three}); });
  EXPECT_NE(message.find("decoder.onnx: takes 3 points, a prompt has 4"), std::string::npos) << message;
}

TEST(Networks, EverythingKeepsGoodMasksOnce) {
  const TempFolder temp;
  SamOptions options = tiny_sam(temp);
  const DrawnFrame drawn = draw_world({kRed, kOtherRed}, 0);
  const cv::Mat masks =
      SamSegmenter(options).segment_everything(drawn.rgb);  // one mask: this decoder has but one
  double most = 0;
  cv::minMaxLoc(masks, nullptr, &most);
  EXPECT_EQ(most, 1);
  EXPECT_GT(mask_iou(masks == 1, drawn.masks != 0), 0.75);
  options.min_quality = 1.01;
  EXPECT_EQ(cv::countNonZero(SamSegmenter(options).segment_everything(drawn.rgb)), 0);
  options = tiny_sam(temp);
  options.max_share = 0.01;
  EXPECT_EQ(cv::countNonZero(SamSegmenter(options).segment_everything(drawn.rgb)), 0);
}

TEST(Networks, RefusedFilesAreNamedWithTheirLayer) {
  const TempFolder temp;
  const SamOptions good = tiny_sam(temp);
  const auto message = [&](const SamOptions& options) {
    return input_error([&] { SamSegmenter(options).segment(draw_world({}, 0).rgb, {{1, {{1, 5, 5}}, {}}}); });
  };
  SamOptions options = good;
  options.encoder = temp.path() / "nowhere.onnx";
  EXPECT_NE(message(options).find("nowhere.onnx: no such ONNX file"), std::string::npos);
  write_text(temp.path() / "broken.onnx", "this is no network");
  options.encoder = temp.path() / "broken.onnx";
  EXPECT_NE(message(options).find("broken.onnx: OpenCV refuses this network"), std::string::npos);
  OnnxWriter writer;
  writer.input("images", {1, 3, 64, 64});
  writer.node("NoSuchLayer", {"images"}, "embeddings");
  writer.output("embeddings", {1, 3, 64, 64});
  writer.write(temp.path() / "odd.onnx");
  options.encoder = temp.path() / "odd.onnx";
  EXPECT_NE(message(options).find("odd.onnx: OpenCV refuses this network"), std::string::npos)
      << message(options);
  EXPECT_NE(message(options).find("NoSuchLayer"), std::string::npos) << message(options);
  options = good;
  options.decoder = good.encoder;  // lacks a decoder's inputs
  EXPECT_NE(message(options).find("encoder.onnx: this network cannot be run"), std::string::npos)
      << message(options);
}

// Rows of zeros but for one in each grid: its box, worked by hand.
TEST(Detector, DecodesTheThreeGrids) {
  DetectorOptions options;
  options.input_px = 64;  // 8 x 8 + 4 x 4 + 2 x 2 cells
  const int shape[] = {1, 84, 7};
  cv::Mat output(3, shape, CV_32F, cv::Scalar(0));
  const auto set = [&](int row, const std::vector<float>& values) {
    std::copy(values.begin(), values.end(), output.ptr<float>(0, row));
  };
  set(8 * 3 + 2, {0.5F, 0.25F, std::log(2.0F), std::log(3.0F), 0.9F, 0.1F, 0.8F});  // stride 8, cell (2, 3)
  set(64 + 4 * 1 + 3, {0, 0, 0, 0, 0.9F, 0.6F, 0});                                 // stride 16, cell (3, 1)
  set(80 + 2, {0.1F, 0.1F, 0, 0, 0.5F, 0.1F, 0.1F});                                // too low a score
  const auto boxes = decode_yolox(output, 0.5, options);
  ASSERT_EQ(boxes.size(), 2u);
  EXPECT_EQ(boxes[0].id, 1);
  EXPECT_NEAR(boxes[0].x, (2.5 * 8 - 8) / 0.5, 1e-4);
  EXPECT_NEAR(boxes[0].y, (3.25 * 8 - 12) / 0.5, 1e-4);
  EXPECT_NEAR(boxes[0].width, 16 / 0.5, 1e-4);
  EXPECT_NEAR(boxes[0].height, 24 / 0.5, 1e-4);
  EXPECT_NEAR(boxes[1].x, (3 * 16 - 8) / 0.5, 1e-4);
  EXPECT_NEAR(boxes[1].width, 16 / 0.5, 1e-4);
}

TEST(Detector, OfTwoBoxesOfOneBodyTheBetterStays) {
  DetectorOptions options;
  options.input_px = 32;
  const int shape[] = {1, 21, 6};
  cv::Mat output(3, shape, CV_32F, cv::Scalar(0));
  const std::vector<float> lesser = {0, 0, std::log(2.0F), std::log(2.0F), 0.8F, 0.6F};
  const std::vector<float> better = {-0.9F, 0, std::log(2.0F), std::log(2.0F), 0.8F, 0.9F};
  std::copy(lesser.begin(), lesser.end(), output.ptr<float>(0, 5));
  std::copy(better.begin(), better.end(), output.ptr<float>(0, 6));
  const auto boxes = decode_yolox(output, 1, options);
  ASSERT_EQ(boxes.size(), 1u);
  EXPECT_NEAR(boxes[0].x, (2 - 0.9) * 8 - 8, 1e-4);
}

TEST(Detector, AnotherNetworkIsRefused) {
  const TempFolder temp;
  OnnxWriter writer;
  writer.input("images", {1, 3, 64, 64});
  writer.node("Relu", {"images"}, "out");
  writer.output("out", {1, 3, 64, 64});
  writer.write(temp.path() / "relu.onnx");
  DetectorOptions options;
  options.input_px = 64;
  const OnnxModel model(temp.path() / "relu.onnx");
  EXPECT_NE(input_error([&] {
              detect_boxes(model, draw_world({}, 0).rgb, options);
            }).find("relu.onnx: is no YOLOX"),
            std::string::npos);
}

// On a real image with a real detector a box lies on the cabinet that the recording's own detections name.
TEST(Detector, TheRealOneLooksAtARealImage) {
  const fs::path recording = fs::path(UNIQUADRIC_SOURCE_DIR) / "../shared/data/tum_fr3_cabinet";
  if (!fs::exists(models() / "yolox_nano.onnx") || !fs::exists(recording))
    GTEST_SKIP() << "no network or no recording at ../shared/data";
  const OnnxModel model(models() / "yolox_nano.onnx");
  DetectorOptions options;
  options.min_score = 0.1;
  int boxes = 0;
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(recording / "rgb")) images.push_back(entry.path());
  std::sort(images.begin(), images.end());
  for (std::size_t i = 0; i < images.size(); i += 20)
    for (const BoxPrompt& box : detect_boxes(model, read_image(images[i]), options)) {
      EXPECT_GE(box.x, -0.5);
      EXPECT_LE(box.x + box.width, 640);
      ++boxes;
    }
  EXPECT_GT(boxes, 0);
}

cv::Mat planes(int channels, int side) {
  const int shape[] = {1, channels, side, side};
  return cv::Mat(4, shape, CV_32F, cv::Scalar(0));
}

// One cell says that the body lies there: its box is worked by hand.
TEST(NanoTrack, DecodesTheBestCell) {
  cv::Mat scores = planes(2, 16), sides = planes(4, 16);
  for (int i = 0; i < 256; ++i) {
    scores.ptr<float>(0, 0)[i] = 6;
    for (int side = 0; side < 4; ++side) sides.ptr<float>(0, side)[i] = 20;
  }
  const int cell = 9 * 16 + 10;  // x = 10, y = 9: 32 and 16 px from the middle
  scores.ptr<float>(0, 1)[cell] = 12;
  const float expected[] = {30, 20, 34, 24};  // left, up, right, down
  for (int side = 0; side < 4; ++side) sides.ptr<float>(0, side)[cell] = expected[side];
  NanoTrackOptions options;
  options.learning_rate = 1;
  const NanoBox previous{{200, 100}, {128, 88}};  // twice the cell's size, for a scale of 0.5
  const auto found = decode_nanotrack(scores, sides, previous, 0.5, options);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->center.x(), 200 + (32 + 2) / 0.5, 1e-9);
  EXPECT_NEAR(found->center.y(), 100 + (16 + 2) / 0.5, 1e-9);
  EXPECT_NEAR(found->size.x(), 128, 0.01);
  EXPECT_NEAR(found->size.y(), 88, 0.01);
  scores.ptr<float>(0, 1)[cell] = 0;
  EXPECT_FALSE(decode_nanotrack(scores, sides, previous, 0.5, options));
}

TEST(NanoTrack, TheRealOneFollowsADrawnBody) {
  if (!fs::exists(models() / "nanotrack_head_sim.onnx"))
    GTEST_SKIP() << "no networks at ../shared/data/models";
  NanoTrackOptions options;
  options.backbone = models() / "nanotrack_backbone_sim.onnx";
  options.head = models() / "nanotrack_head_sim.onnx";
  NanoTracker tracker(options);
  DrawnFrame before = draw_world({kRed}, 0);
  cv::Mat masks = before.masks;
  tracker.learn(masks, {0, before.rgb, before.depth, {}, {}});
  for (int n = 1; n < 10; ++n) {
    const DrawnFrame now = draw_world({kRed}, n);
    masks = tracker.carry(masks, {n - 1, before.rgb, before.depth, {}, {}}, {n, now.rgb, now.depth, {}, {}})
                .masks;
    before = now;
  }
  EXPECT_GT(mask_iou(masks == 1, before.masks == 1), 0.7);
}

}  // namespace
}  // namespace uniquadric
