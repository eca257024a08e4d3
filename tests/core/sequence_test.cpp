#include "core/sequence/sequence.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/sequence/visibility.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

const std::string kName = "small: \"x\" # [1, \\ \t";  // must survive YAML

class SequenceFolder : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* sub : {"rgb", "depth", "masks"}) fs::create_directory(folder() / sub);
    Sequence sequence;
    sequence.name = kName;
    sequence.program = "uniquadric test";
    sequence.camera = {8, 6, 10, 10, 3.5, 2.5, {}};
    sequence.rate_hz = 30;
    sequence.depth_units_per_m = 1000;
    for (int i = 0; i < 3; ++i) {
      const std::string file = std::to_string(i) + ".png";
      cv::Mat depth(6, 8, CV_16UC1, cv::Scalar(1500 + i)), masks(6, 8, CV_16UC1, cv::Scalar(300));
      write_png(folder() / "rgb" / file, cv::Mat(6, 8, CV_8UC3, cv::Scalar(10, 20, 30 + i)));
      write_png(folder() / "depth" / file, depth);
      write_png(folder() / "masks" / file, masks);
      sequence.frames.push_back(
          {i, i * 33'333'333LL, "rgb/" + file, "depth/" + file, "masks/" + file, i * 33'333'333LL + 100});
    }
    sequence.given_camera = Trajectory{{0, {}}, {33'333'333, {}}};
    write_sequence_index(folder(), sequence);
  }
  const fs::path& folder() const { return temp_.path(); }
  std::string error() const {
    return input_error([&] {
      const Sequence sequence = open_sequence(folder());
      for (const auto& frame : sequence.frames) {
        read_rgb(sequence, frame);
        read_depth(sequence, frame);
        read_masks(sequence, frame);
      }
    });
  }
  void expect_error(const std::string& file, const std::string& what) const {
    const std::string expected = (folder() / file).string() + what;
    EXPECT_EQ(error().substr(0, expected.size()), expected);
  }
  void replace(const std::string& file, const std::string& find, const std::string& by) const {
    std::string text = read_text(folder() / file);
    ASSERT_NE(text.find(find), std::string::npos) << text;
    write_text(folder() / file, text.replace(text.find(find), find.size(), by));
  }

 private:
  TempFolder temp_;
};

TEST_F(SequenceFolder, ReadsBackAsItWasWritten) {
  const Sequence sequence = open_sequence(folder());
  EXPECT_EQ(sequence.name, kName);
  EXPECT_EQ(sequence.camera.cx, 3.5);
  ASSERT_EQ(sequence.frames.size(), 3u);
  EXPECT_EQ(sequence.frames[2].masks_arrival_ns, 66'666'766);
  EXPECT_EQ(read_rgb(sequence, sequence.frames[1]).at<cv::Vec3b>(3, 3), cv::Vec3b(10, 20, 31));
  EXPECT_FLOAT_EQ(read_depth(sequence, sequence.frames[2]).at<float>(0, 0), 1.502f);
  EXPECT_EQ(read_masks(sequence, sequence.frames[0]).at<std::uint16_t>(5, 7), 300);
  ASSERT_TRUE(sequence.given_camera.has_value());
  EXPECT_EQ(sequence.given_camera->size(), 2u);
}

// Other programs' sequences name none.
TEST_F(SequenceFolder, KeepsTheRealismThatItNames) {
  Sequence sequence = open_sequence(folder());
  EXPECT_EQ(sequence.realism, "");
  EXPECT_EQ(read_text(folder() / "sequence.yaml").find("realism"), std::string::npos);
  sequence.realism = "harsh";
  write_sequence_index(folder(), sequence);
  EXPECT_EQ(open_sequence(folder()).realism, "harsh");
}

TEST_F(SequenceFolder, ABiasOfInverseDepthIsTakenOutAsItIsRead) {
  Sequence sequence = open_sequence(folder());
  constexpr double kMeasured = 1.502;
  for (const double bias : {0.006, -0.02}) {
    sequence.inverse_depth_bias_per_m = bias;
    const float z = read_depth(sequence, sequence.frames[2]).at<float>(0, 0);
    EXPECT_NEAR(1 / z, 1 / kMeasured - bias, 1e-6);
  }
  sequence.inverse_depth_bias_per_m = 1;  // behind infinity
  EXPECT_EQ(read_depth(sequence, sequence.frames[2]).at<float>(0, 0), 0);
}

TEST_F(SequenceFolder, TheLidarsDataSheetReadsBackAndMayBeUnknown) {
  Sequence sequence = open_sequence(folder());
  sequence.lidar = LidarCalibration{"livox_mid40", 10, {}, {}};
  write_sequence_index(folder(), sequence);
  EXPECT_EQ(read_text(folder() / "sequence.yaml").find("noise"), std::string::npos);
  EXPECT_FALSE(open_sequence(folder()).lidar->noise);  // as in sequences before there was one
  sequence.lidar->noise = LidarDataSheet{0.03, 0.25, 0.1};
  write_sequence_index(folder(), sequence);
  const auto noise = open_sequence(folder()).lidar->noise;
  ASSERT_TRUE(noise);
  EXPECT_EQ(noise->range_sigma_m, 0.03);
  EXPECT_EQ(noise->divergence_deg, 0.25);
  EXPECT_EQ(noise->angle_sigma_deg, 0.1);
  replace("sequence.yaml", "range_sigma_m: 0.03", "range_sigma_m: -1");
  EXPECT_NE(error().find("range_sigma_m: expected at least 0, found -1"), std::string::npos) << error();
}

TEST_F(SequenceFolder, TheReadOutTimeOfARollingShutterReadsBackAndIsWrittenOnlyWhereThereIsOne) {
  EXPECT_EQ(read_text(folder() / "sequence.yaml").find("rolling_shutter_s"), std::string::npos);
  Sequence sequence = open_sequence(folder());
  EXPECT_EQ(sequence.rolling_shutter_s, 0);
  sequence.rolling_shutter_s = 0.02;
  write_sequence_index(folder(), sequence);
  EXPECT_EQ(open_sequence(folder()).rolling_shutter_s, 0.02);
}

TEST_F(SequenceFolder, AReadOutTimeIsNeitherNegativeNorLongerThanAFrame) {
  replace("sequence.yaml", "rate_hz: 30", "rate_hz: 30, rolling_shutter_s: 0.04");
  EXPECT_NE(error().find("sequence.yaml:4: camera.rolling_shutter_s: is 0.04 s, longer than a frame, 0.0333"),
            std::string::npos)
      << error();
  replace("sequence.yaml", "rolling_shutter_s: 0.04", "rolling_shutter_s: -0.01");
  EXPECT_NE(error().find("camera.rolling_shutter_s: expected at least 0, found -0.01"), std::string::npos)
      << error();
}

TEST_F(SequenceFolder, MasksOfMoreIdsThanThereCanBeBodiesAreRefused) {
  replace("sequence.yaml", "width: 8", "width: 300");
  const Sequence sequence = open_sequence(folder());
  cv::Mat masks(6, 300, CV_16UC1);
  for (int u = 0; u < masks.cols; ++u) masks.col(u).setTo(u <= kMostIds ? 200 * u : 0);
  write_png(folder() / "masks/1.png", masks);
  EXPECT_EQ(read_masks(sequence, sequence.frames[1]).at<std::uint16_t>(0, kMostIds), 200 * kMostIds);
  masks.at<std::uint16_t>(5, 299) = 65535;
  write_png(folder() / "masks/1.png", masks);
  EXPECT_EQ(input_error([&] { read_masks(sequence, sequence.frames[1]); }),
            (folder() / "masks/1.png").string() + ": holds 257 ids, more than the 256 that masks may have");
}

TEST_F(SequenceFolder, DepthIsAssociatedWithin20ms) {
  replace("depth.txt", "0.033333333 depth/1.png\n", "0.052 depth/1.png\n");
  replace("depth.txt", "0.066666666 depth/2.png\n", "0.087 depth/2.png\n");
  const Sequence sequence = open_sequence(folder());
  EXPECT_EQ(sequence.frames[1].depth, "depth/1.png");
  EXPECT_EQ(sequence.frames[2].depth, "");
}

TEST_F(SequenceFolder, RefusesImagesThatAreNotWhatTheySay) {
  const std::string whole = read_text(folder() / "rgb/1.png");
  write_text(folder() / "rgb/1.png", whole.substr(0, whole.size() / 2));
  expect_error("rgb/1.png", ": is a truncated image");
  std::string damaged = whole;
  damaged[damaged.size() - 20] ^= 1;
  write_text(folder() / "rgb/1.png", damaged);
  expect_error("rgb/1.png", ": is a damaged image");
  damaged = whole;
  damaged[5] ^= 1;
  write_text(folder() / "rgb/1.png", damaged);
  expect_error("rgb/1.png", ": is not an image that can be decoded: neither PNG nor JPEG");
  write_text(folder() / "rgb/1.png", "");
  expect_error("rgb/1.png", ": is empty");
  write_text(folder() / "rgb/1.png", "not an image at all");
  expect_error("rgb/1.png", ": is not an image that can be decoded");
  write_png(folder() / "rgb/1.png", cv::Mat(6, 9, CV_8UC3, cv::Scalar()));
  expect_error("rgb/1.png", ": is 9x6, the camera says 8x6");
  write_text(folder() / "rgb/1.png", whole);
  write_png(folder() / "depth/1.png", cv::Mat(6, 8, CV_8UC1, cv::Scalar()));
  expect_error("depth/1.png", ": expected a 16-bit grey image");
}

TEST_F(SequenceFolder, RefusesBadIndexes) {
  replace("rgb.txt", "0.033333333", "0.0");
  expect_error("rgb.txt", ":3: timestamp 0.0 does not come after 0.000000000");
  SetUp();
  fs::remove(folder() / "depth/1.png");
  expect_error("depth.txt", ":3: file depth/1.png is missing");
  SetUp();
  write_text(folder() / "depth.txt",
             "# timestamp filename\r0 depth/0.png\r");  // of old Macs: a comment alone
  expect_error("depth.txt", ": names no image; a sequence without depth has none");
  SetUp();
  replace("rgb.txt", "rgb/1.png", "../rgb/1.png");
  expect_error("rgb.txt", ":3: ../rgb/1.png leads out of the folder");
  SetUp();
  replace("masks.txt", " 0.033333433", "");
  expect_error("masks.txt", ":3: expected: timestamp filename arrival");
  SetUp();
  replace("sequence.yaml", "fx: 10", "fx: 0");
  expect_error("sequence.yaml", ":4: camera.fx: expected a number greater than 0, found 0");
  SetUp();
  replace("sequence.yaml", "cx: 3.5", "cx: 1e7");
  expect_error("sequence.yaml", ":4: camera.cx: expected -80 to 80 px, found 10000000");
  SetUp();
  replace("sequence.yaml", "cy: 2.5", "cy: -61");
  expect_error("sequence.yaml", ":4: camera.cy: expected -60 to 60 px, found -61");
  SetUp();
  replace("sequence.yaml", "schema: 1", "schema: 9");
  expect_error("sequence.yaml", ":1: schema: version 9 is not supported");
  SetUp();
  replace("sequence.yaml", "\nname:", "\nnmae:");
  expect_error("sequence.yaml", ":1: missing key 'name'");
}

TEST(Visibility, CountsThePixelsOfEachIdButTheBackground) {
  cv::Mat masks = cv::Mat::zeros(3, 4, CV_16UC1);
  masks.row(1).setTo(7);
  masks.at<std::uint16_t>(2, 3) = 65535;
  EXPECT_EQ(count_ids(masks), (std::map<int, int>{{7, 4}, {65535, 1}}));
  EXPECT_TRUE(count_ids(cv::Mat()).empty());
}

}  // namespace
}  // namespace uniquadric
