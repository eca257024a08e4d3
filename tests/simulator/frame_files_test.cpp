#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/sequence/sequence.h"
#include "simulator/frame_log.h"
#include "simulator/png.h"
#include "tests/simulator/same_image.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

std::string stored(const cv::Mat& image) {
  const bool color = image.type() == CV_8UC3;
  StoredPng png(color ? PngFormat::rgb_8 : PngFormat::grey_16, image.cols, image.rows);
  for (const std::uint8_t fill : {std::uint8_t{0xa5}, std::uint8_t{0}})  // what was before leaves no trace
    for (int v = 0; v < image.rows; ++v)
      for (int u = 0; u < image.cols; ++u) {
        const auto* bytes = image.ptr(v, u);
        unsigned char* out = png.row(v) + (color ? 3 : 2) * u;
        if (fill)
          std::fill(out, out + (color ? 3 : 2), fill);
        else if (color)
          out[0] = bytes[2], out[1] = bytes[1], out[2] = bytes[0];
        else
          out[0] = bytes[1], out[1] = bytes[0];
      }
  return std::string(png.finish());
}

TEST(StoredPng, AnotherLibraryReadsWhatWasWritten) {
  const TempFolder temp;
  int cases = 0;
  for (const int type : {CV_8UC3, CV_16UC1})
    for (const cv::Size size : {cv::Size(1, 1), {13, 7}, {640, 480}, {16384, 5}}) {  // one and many blocks
      cv::Mat image(size, type);
      cv::randu(image, 0, 65536);
      write_file(temp.path() / "image.png", stored(image));
      EXPECT_TRUE(same(read_image(temp.path() / "image.png"), image)) << type << size;
      ++cases;
    }
  EXPECT_EQ(cases, 8);
}

TEST(PackPng, AnotherLibraryReadsRunsOfEveryLength) {
  // Image i has runs of i equal pixels; the filter makes of each a run of its own kind. A run of 2 i + 1
  // bytes or so meets every length symbol, alone and behind the longest ones.
  const TempFolder temp;
  int cases = 0;
  for (int length = 1; length < 400; length += length < 20 ? 1 : 7) {
    cv::Mat ids(3, 4 * length, CV_16UC1);
    for (int v = 0; v < ids.rows; ++v)
      for (int u = 0; u < ids.cols; ++u)
        ids.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>((u / length + v) % 3 * 0x4141);
    write_file(temp.path() / "ids.png", pack_png(ids));
    EXPECT_TRUE(same(read_image(temp.path() / "ids.png"), ids)) << length;
    ++cases;
  }
  EXPECT_EQ(cases, 74);
}

TEST(PackPng, AnotherLibraryReadsNoise) {
  const TempFolder temp;
  cv::Mat ids(60, 77, CV_16UC1);  // all literals
  cv::randu(ids, 0, 65536);
  write_file(temp.path() / "ids.png", pack_png(ids(cv::Rect(3, 5, 70, 50))));
  EXPECT_TRUE(same(read_image(temp.path() / "ids.png"), ids(cv::Rect(3, 5, 70, 50))));
}

TEST(PackPng, IsSmall) {
  cv::Mat ids = cv::Mat::zeros(480, 640, CV_16UC1);
  ids(cv::Rect(200, 100, 150, 200)) = 7;
  EXPECT_LT(pack_png(ids).size(), 10'000u);  // of 614 400
}

TEST(WriteFile, SaysWhatCannotBeWritten) {
  const TempFolder temp;
  try {
    write_file(temp.path() / "no/such/folder.png", "x");
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("folder.png: cannot be written: No such"), std::string::npos);
  }
}

TEST(FrameLog, KeepsWhatIsCompleteInTheOrderOfFrames) {
  const TempFolder temp;
  const auto path = temp.path() / "log";
  {
    FrameLog log(path);
    log.add(2, "2,a\n2,b\n");
    log.add(0, "0,a\n0,b\n");
    log.add(1, "");
    EXPECT_TRUE(log.has(1));
    EXPECT_EQ(log.lines(), "0,a\n0,b\n2,a\n2,b\n");
  }
  const std::string whole = read_text(path);
  const std::string record = "12 2\n12,a\n12,b\n";
  int cases = 0;
  for (std::size_t kept = 0; kept <= record.size(); ++kept) {  // wherever a killed process stopped
    std::ofstream(path, std::ios::binary) << whole << record.substr(0, kept);
    FrameLog log(path);
    EXPECT_TRUE(log.has(0) && log.has(1) && log.has(2));
    EXPECT_EQ(log.has(12), kept == record.size()) << kept;
    if (!log.has(12)) log.add(12, "12,c\n");
    EXPECT_EQ(FrameLog(path).lines(), log.lines());
    ++cases;
  }
  EXPECT_EQ(cases, 16);
}

}  // namespace
}  // namespace uniquadric
