#include "harness/check.h"

#include <opencv2/imgcodecs.hpp>

#include "core/base/files.h"
#include "core/base/folder_hashes.h"
#include "core/import/tum.h"
#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// What the fixture adds to the simulated sequence (scans) is taken into its hashes first.
class Check : public Export {
 protected:
  void SetUp() override {
    Export::SetUp();
    write_hashes(sequence_.folder);
  }
  std::string problems() const {
    std::string text;
    for (const std::string& problem : check_sequence(data())) text += problem + "\n";
    return text;
  }
  // The one problem that the change of a file makes; the file is put back.
  void expect_problem(const fs::path& file, const std::string& content, const std::string& what) {
    const std::string before = bytes_of(file);
    write_text(file, content);
    const std::string found = problems();
    EXPECT_NE(found.find(what), std::string::npos) << "wanted: " << what << "\ngot: " << found;
    write_text(file, before);
    ++changes_;
  }
  std::string replaced(const fs::path& file, const std::string& find, const std::string& by) const {
    std::string text = bytes_of(file);
    const std::size_t at = text.find(find);
    EXPECT_NE(at, std::string::npos) << find;
    return text.replace(at, find.size(), by);
  }
  std::string png(const cv::Mat& image) const {
    const fs::path file = folder() / "image.png";
    write_png(file, image);
    return bytes_of(file);
  }
  int changes_ = 0;
};

TEST_F(Check, FindsNothingWrongWithWhatWasSimulated) {
  EXPECT_EQ(problems(), "");
  fs::remove(sequence_.folder / kHashesFile);  // they are not required
  fs::remove(data() / "truth" / kHashesFile);
  EXPECT_EQ(problems(), "");
}

TEST_F(Check, NamesEachThingThatIsWrong) {
  const fs::path sequence = sequence_.folder, truth = data() / "truth";
  expect_problem(sequence / "rgb/000001.png", bytes_of(sequence / "rgb/000001.png").substr(0, 900),
                 "rgb/000001.png: is a truncated image");
  expect_problem(sequence / "rgb/000001.png", png(cv::Mat(10, 20, CV_8UC3, cv::Scalar(1))),
                 "rgb/000001.png: is 20x10, the camera says 160x120");
  expect_problem(sequence / "depth/000002.png", png(cv::Mat(120, 160, CV_16U, cv::Scalar(0))),
                 "depth/000002.png: has no depth at any pixel");
  expect_problem(sequence / "depth/000002.png", png(cv::Mat(120, 160, CV_16U, cv::Scalar(65535))),
                 "depth/000002.png: is cut off at the 16 bits' end at 19200 pixels");
  expect_problem(sequence / "masks/000003.png", png(cv::Mat(120, 160, CV_16U, cv::Scalar(9))),
                 "masks/000003.png: 19200 pixels are of object 9, which is unknown");
  expect_problem(sequence / "sequence.yaml",
                 replaced(sequence / "sequence.yaml", "rate_hz: 10", "rate_hz: 30"),
                 "rgb.txt: comes at 10 Hz, sequence.yaml says 30");
  expect_problem(sequence / "sequence.yaml", replaced(sequence / "sequence.yaml", "cx: 79.5", "cx: -79.5"),
                 "the principal point lies outside the image");
  expect_problem(sequence / "imu.csv", replaced(sequence / "imu.csv", "\n150000000,", "\n158000000,"),
                 "imu.csv: 1 gaps of more than 1.5 periods");
  const std::string imu = bytes_of(sequence / "imu.csv");
  expect_problem(sequence / "imu.csv", imu.substr(0, imu.find("\n250000000,") + 1),
                 "imu.csv: does not cover");
  expect_problem(sequence / "lidar/2.pcd", "nonsense", "lidar/2.pcd");
  expect_problem(sequence / "lidar.txt", "5.000000000 lidar/1.pcd\n",
                 "lidar/1.pcd: was taken before the first frame or after the last");
  expect_problem(truth / "camera.tum", bytes_of(truth / "camera.tum") + "0.4 0 0 0 0 0 0 1\n",
                 "camera.tum: does not have the sequence's frames");
  expect_problem(truth / "camera.yaml", replaced(truth / "camera.yaml", "fx: 130", "fx: 131"),
                 "camera.yaml: is not the sequence's calibration");
  expect_problem(truth / "instances/000000.png", png(cv::Mat(120, 160, CV_16U, cv::Scalar(1))),
                 "frame 0, object 1: ");
  expect_problem(truth / "objects/2.tum", "0 0 0 0 0 0 0 1\n", "2.tum: does not have the sequence's frames");
  for (const char* digits : {"0.000", "10000"})  // before those of the scale
    expect_problem(
        sequence / "sequence.yaml",
        replaced(sequence / "sequence.yaml", "units_per_m: ", std::string("units_per_m: ") + digits),
        "sequence.yaml: depth.units_per_m: ");
  std::vector<ImuSample> in_g = read_imu_csv(sequence / "imu.csv");
  for (ImuSample& sample : in_g) sample.specific_force_mps2 /= 9.81;
  write_imu_csv(folder() / "in_g.csv", in_g);
  expect_problem(sequence / "imu.csv", bytes_of(folder() / "in_g.csv"), "where gravity_mps2 is 9.81: in g?");
  EXPECT_EQ(changes_, 18);
  EXPECT_EQ(problems(), "");
}

TEST_F(Check, PointsAfterTheScansEndAndUnlistedFilesAreProblems) {
  auto points = scans_[1];
  points[7].offset_ns = 120'000'000;
  points[8].x = NAN;
  write_lidar_points(sequence_.folder / "lidar/2.pcd", points);
  write_text(sequence_.folder / "rgb/stray.png", "stray");
  const std::string found = problems();
  EXPECT_NE(found.find("lidar/2.pcd: 1 points come after the scan's end"), std::string::npos) << found;
  EXPECT_NE(found.find("lidar/2.pcd: 1 points are not finite"), std::string::npos) << found;
  EXPECT_NE(found.find("rgb/stray.png: stands in no list"), std::string::npos) << found;
}

TEST_F(Check, PointsTimesThatSpanLittleOfAScanAreAProblem) {
  const std::string what = "lidar.txt: the points' times span 9.95e-05 s of a scan at most, of 0.1 s";
  for (int scan = 1; scan <= 3; ++scan) {
    auto points = scans_[static_cast<std::size_t>(scan) - 1];
    for (LidarPoint& p : points) p.offset_ns /= 1000;
    EXPECT_EQ(problems().find(what), std::string::npos);
    write_lidar_points(sequence_.folder / "lidar" / (std::to_string(scan) + ".pcd"), points);
  }
  EXPECT_NE(problems().find(what), std::string::npos) << problems();
}

TEST_F(Check, AFrameThatIsGoneIsAGap) {
  sequence_.frames.erase(sequence_.frames.begin() + 1);
  rewrite_index();
  const std::string found = problems();
  EXPECT_NE(found.find("rgb.txt: 1 gaps of more than 1.5 periods"), std::string::npos) << found;
  EXPECT_NE(found.find("rgb/000001.png: stands in no list"), std::string::npos) << found;
  EXPECT_NE(found.find("camera.tum: does not have the sequence's frames"), std::string::npos) << found;
}

TEST_F(Check, HashesTellWhatHasChanged) {
  write_hashes(sequence_.folder);
  const std::string list = bytes_of(sequence_.folder / "hashes.txt");
  EXPECT_EQ(list.find("hashes.txt"), std::string::npos);
  EXPECT_NE(list.find(" rgb/000002.png\n"), std::string::npos);
  const fs::path given = sequence_.folder / "camera_given.tum", imu = sequence_.folder / "imu.csv";
  write_text(given, "# a comment, which changes nothing but the bytes\n" + bytes_of(given));
  EXPECT_NE(problems().find("camera_given.tum: has changed"), std::string::npos);
  fs::remove(given);
  EXPECT_NE(problems().find("camera_given.tum: is missing"), std::string::npos);
  write_text(sequence_.folder / "notes.txt", "");
  EXPECT_NE(problems().find("notes.txt: does not stand in hashes.txt"), std::string::npos);
}

TEST_F(Check, ATruthFolderIsCheckedWithItsSequenceOrAlone) {
  const fs::path truth = data() / "truth", camera = truth / "camera.yaml";
  const auto found = [](const fs::path& folder) {
    std::string text;
    for (const std::string& problem : check_sequence(folder)) text += problem + "\n";
    return text;
  };
  EXPECT_EQ(found(truth), "");
  write_text(camera, replaced(camera, "fx: 130", "fx: 131"));
  EXPECT_NE(found(truth).find("camera.yaml: is not the sequence's calibration"), std::string::npos);
  const fs::path alone = folder() / "alone";
  fs::rename(truth, alone);
  EXPECT_NE(found(alone).find("camera.yaml: has changed"), std::string::npos);
  write_text(alone / "camera.yaml", replaced(alone / "camera.yaml", "fx: 131", "fx: 130"));
  EXPECT_EQ(found(alone), "");
  write_text(alone / "objects/2.tum", "0 0 0 0 0 0 0 2\n");
  EXPECT_NE(found(alone).find("2.tum:1: quaternion has norm 2"), std::string::npos);
}

// An import has no second calibration to compare with: its hashes tell.
TEST_F(Check, AnImportThatWasEditedIsSeen) {
  ImportTumOptions options;
  options.quiet = true;
  const fs::path back = folder() / "back";
  import_tum(run("tum"), options, back);
  EXPECT_EQ(check_sequence(back), std::vector<std::string>());
  write_text(back / "sequence.yaml", replaced(back / "sequence.yaml", "fx: 130", "fx: 131"));
  const auto found = check_sequence(back);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].find("sequence.yaml: has changed"), std::string::npos);
}

TEST_F(Check, ARecordingsTruthMayKnowSomeFramesAlone) {
  sequence_.scene_hash.clear();
  rewrite_index();
  const fs::path truth = data() / "truth/objects/2.tum";
  write_text(truth, bytes_of(truth).substr(0, bytes_of(truth).find('\n') + 1));
  fs::remove(data() / "truth" / kHashesFile);
  fs::remove(sequence_.folder / kHashesFile);
  EXPECT_EQ(problems(), "");
  write_text(truth, "0.05 0 0 0 0 0 0 1\n");
  EXPECT_NE(problems().find("2.tum: "), std::string::npos);
}

TEST_F(Check, AFolderThatIsNoSequenceIsOneProblem) {
  EXPECT_EQ(check_sequence(folder() / "none").size(), 1u);
  fs::remove(sequence_.folder / "rgb.txt");
  EXPECT_NE(problems().find("rgb.txt"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
