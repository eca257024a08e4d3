#include "core/import/tum.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/sequence.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kRounding = 1e-12;  // m: of one linear interpolation
const char* const kCamera =
    "{width: 8, height: 6, fx: 10, fy: 11, cx: 3.5, cy: 2.5, depth_units_per_metre: 1000}\n";

void append(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::app) << text;
}

// Four frames 0.1 s apart; the camera moves at 1 m/s along x, with poses from 1.05 s to 1.25 s and again
// at 1.5 s.
fs::path write_recording(const TempFolder& temp) {
  const fs::path folder = temp.path() / "recording";
  fs::create_directories(folder / "rgb");
  fs::create_directories(folder / "depth");
  write_text(folder / "camera.yaml", kCamera);
  for (const char* stamp : {"1.000000", "1.100000", "1.200000", "1.300000"}) {
    write_png(folder / "rgb" / (std::string(stamp) + ".png"), cv::Mat(6, 8, CV_8UC3, cv::Scalar(1, 2, 3)));
    append(folder / "rgb.txt", std::string(stamp) + " rgb/" + stamp + ".png\n");
  }
  for (const char* stamp : {"1.015000", "1.110000", "1.230000"}) {  // the last is 0.03 s from its image
    write_png(folder / "depth" / (std::string(stamp) + ".png"), cv::Mat(6, 8, CV_16UC1, cv::Scalar(2500)));
    append(folder / "depth.txt", std::string(stamp) + " depth/" + stamp + ".png\n");
  }
  write_text(folder / "groundtruth.txt",
             "# comment\n1.05 0.05 0 0 0 0 0 1\n1.125 0.125 0 0 0 0 0 1\n"
             "1.2 0.2 0 0 0 0 0 1\n1.25 0.25 0 0 0 0 0 1\n1.5 0.5 0 0 0 0 0 1\n");
  return folder;
}

ImportTumOptions quiet() {
  ImportTumOptions options;
  options.quiet = options.force = true;
  return options;
}

TEST(ImportTum, ReadsBackWhatTheRecordingHolds) {
  const TempFolder temp;
  const fs::path recording = write_recording(temp), out = temp.path() / "out";
  import_tum(recording, quiet(), out);
  const Sequence sequence = open_sequence(out);
  EXPECT_EQ(sequence.name, "recording");
  EXPECT_EQ(sequence.camera.fy, 11);
  EXPECT_EQ(sequence.depth_units_per_m, 1000);
  EXPECT_NEAR(sequence.rate_hz, 10, kRounding);
  ASSERT_EQ(sequence.frames.size(), 4u);
  EXPECT_EQ(sequence.frames[1].stamp_ns, 1'100'000'000);
  for (const auto& frame : sequence.frames)
    EXPECT_EQ(read_text(out / frame.rgb), read_text(recording / frame.rgb));
  EXPECT_EQ(sequence.frames[0].depth, "depth/1.015000.png");
  EXPECT_EQ(sequence.frames[1].depth, "depth/1.110000.png");
  EXPECT_TRUE(sequence.frames[2].depth.empty());  // 0.03 s away is no depth of this image
  EXPECT_EQ(read_depth(sequence, sequence.frames[0]).at<float>(3, 3), 2.5f);
}

TEST(ImportTum, PosesAreInterpolatedInsideTheirSpanAlone) {
  const TempFolder temp;
  const fs::path recording = write_recording(temp), out = temp.path() / "out";
  testing::internal::CaptureStderr();
  import_tum(recording, quiet(), out);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("groundtruth.txt: 2 of 4 images have no pose"),
            std::string::npos);
  const auto poses = open_sequence(out).given_camera;
  ASSERT_TRUE(poses.has_value());
  ASSERT_EQ(poses->size(), 2u);  // 1.0 s lies before the first pose, 1.3 s in a gap of 0.25 s
  EXPECT_EQ((*poses)[0].stamp_ns, 1'100'000'000);
  EXPECT_NEAR((*poses)[0].pose.translation.x(), 0.1, kRounding);
  EXPECT_EQ((*poses)[1].pose.translation.x(), 0.2);
  ImportTumOptions patient = quiet();
  patient.max_pose_gap_s = 0.3;
  import_tum(recording, patient, out);
  EXPECT_EQ(open_sequence(out).given_camera->size(), 3u);
  fs::remove(recording / "groundtruth.txt");
  import_tum(recording, quiet(), out);
  EXPECT_FALSE(open_sequence(out).given_camera.has_value());
}

TEST(ImportTum, BadRecordingsAreRefusedAndLeaveNothing) {
  struct Case {
    std::string what;
    std::function<void(const fs::path&)> damage;
  };
  const std::vector<Case> cases = {
      {"rgb.txt: cannot be read", [](const auto& r) { fs::remove(r / "rgb.txt"); }},
      {"depth.txt: cannot be read", [](const auto& r) { fs::remove(r / "depth.txt"); }},
      {"camera.yaml: cannot be read", [](const auto& r) { fs::remove(r / "camera.yaml"); }},
      {"rgb.txt:5: expected: timestamp filename", [](const auto& r) { append(r / "rgb.txt", "1.4\n"); }},
      {"rgb.txt:5: timestamp 1.2 does not come after",
       [](const auto& r) { append(r / "rgb.txt", "1.2 rgb/1.200000.png\n"); }},
      {"rgb.txt:5: file rgb/no.png is missing",
       [](const auto& r) { append(r / "rgb.txt", "2 rgb/no.png\n"); }},
      {"rgb.txt:5: ../recording/rgb/1.200000.png leads out of the folder",
       [](const auto& r) { append(r / "rgb.txt", "2 ../recording/rgb/1.200000.png\n"); }},
      {"depth.txt: names no image", [](const auto& r) { write_text(r / "depth.txt", ""); }},
      {"depth.txt: 0 of 2 depth images lie within 0.02 s of one of the 4 of rgb.txt",
       [](const auto& r) {
         write_text(r / "depth.txt", "1100 depth/1.110000.png\n1200 depth/1.110000.png\n");
       }},
      {"groundtruth.txt:7: 'nan' is not a finite number",
       [](const auto& r) { append(r / "groundtruth.txt", "2 nan 0 0 0 0 0 1\n"); }},
      {"groundtruth.txt: no image lies within the poses' times: the clocks differ",
       [](const auto& r) {
         write_text(r / "groundtruth.txt", "1001.05 0 0 0 0 0 0 1\n1001.1 0 0 0 0 0 0 1\n");
       }},
      {"groundtruth.txt: all images lie in holes of more than 0.1 s between the poses",
       [](const auto& r) { write_text(r / "groundtruth.txt", "0.95 0 0 0 0 0 0 1\n1.35 0 0 0 0 0 0 1\n"); }},
      {"groundtruth.txt: holds no pose",
       [](const auto& r) { write_text(r / "groundtruth.txt", "# comment\n"); }},
      {"1.200000.png: is a truncated image",
       [](const auto& r) {
         fs::resize_file(r / "rgb/1.200000.png", fs::file_size(r / "rgb/1.200000.png") / 2);
       }},
      {"1.110000.png: expected a 16-bit grey image",
       [](const auto& r) { write_png(r / "depth/1.110000.png", cv::Mat::zeros(6, 8, CV_8UC1)); }},
      {"1.100000.png: is 9x6, the camera says 8x6",
       [](const auto& r) { write_png(r / "rgb/1.100000.png", cv::Mat::zeros(6, 9, CV_8UC3)); }},
      {"camera.yaml:1: unknown key 'scale'",
       [](const auto& r) {
         write_text(r / "camera.yaml",
                    "{width: 8, height: 6, fx: 10, fy: 11, cx: 3.5, cy: 2.5, "
                    "depth_units_per_metre: 1000, scale: 2}\n");
       }},
  };
  int refused = 0;
  for (const auto& [what, damage] : cases) {
    const TempFolder temp;
    const fs::path recording = write_recording(temp), out = temp.path() / "out";
    damage(recording);
    try {
      import_tum(recording, quiet(), out);
      ADD_FAILURE() << "accepted: " << what;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(what), std::string::npos) << e.what();
      ++refused;
    }
    EXPECT_FALSE(fs::exists(out));
    EXPECT_FALSE(fs::exists(out.string() + ".partial"));
  }
  EXPECT_EQ(refused, 17);
}

}  // namespace
}  // namespace uniquadric
