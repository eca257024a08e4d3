#include "core/import/kitti_result.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/base/files.h"
#include "core/import/result.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kFrame_ns = 100'000'000;
// h 1.5, w 2, l 4 with its bottom at (1, 2, 10); a quarter turn later its length lies along -z
constexpr const char* kLabels =
    "0 0 Car -1 -1 -10 10 10 50 50 1.5 2 4 1 2 10 0 0.9\n"
    "0 3 Pedestrian 0 0 0 10 10 50 50 1.8 0.5 0.6 0 1 5 0\n"
    "2 0 Car -1 -1 -10 10 10 50 50 1.6 2.2 4.4 1 2 10 1.5707963267948966 0.8\n";

class KittiResult : public testing::Test {
 protected:
  KittiResult() {
    for (int i = 0; i < 3; ++i) {
      sequence_.frames.emplace_back().frame = i;
      sequence_.frames.back().stamp_ns = i * kFrame_ns;
    }
  }
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder() / name).parent_path());
    write_text(folder() / name, text);
  }
  std::string refusal() const {
    return input_error([&] { read_kitti_result(folder(), sequence_); });
  }
  fs::path folder() const { return temp_.path() / "mine"; }
  const TempFolder temp_;
  Sequence sequence_;
};

TEST_F(KittiResult, BoxesAreAsTheLinesSay) {
  write("0000.txt", kLabels);
  const Tracks tracks = read_kitti_result(folder(), sequence_);
  ASSERT_EQ(tracks.objects.size(), 2u);
  EXPECT_EQ(tracks.objects[0].id, 3);
  EXPECT_EQ(tracks.objects[1].id, 4);  // KITTI's 0
  const auto& [first, turned] = std::pair(tracks.objects[1].states.at(0), tracks.objects[1].states.at(1));
  EXPECT_EQ(first.exponents, (SuperExponents{1, 1, 1}));
  EXPECT_EQ(first.ellipsoid.semi_axes_m, Eigen::Vector3d(2, 1, 0.75));
  EXPECT_EQ(turned.ellipsoid.semi_axes_m, Eigen::Vector3d(2.2, 1.1, 0.8));
  EXPECT_EQ(turned.frame, 2);
  EXPECT_EQ(turned.stamp_ns, 2 * kFrame_ns);
  const Pose& pose = first.ellipsoid.world_from_object;  // no poses: the sensor's frame
  EXPECT_TRUE(pose.translation.isApprox(Eigen::Vector3d(1, 1.25, 10)));
  EXPECT_TRUE((pose.rotation * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_TRUE((pose.rotation * Eigen::Vector3d::UnitZ()).isApprox(-Eigen::Vector3d::UnitY()));
  EXPECT_TRUE((turned.ellipsoid.world_from_object.rotation * Eigen::Vector3d::UnitX())
                  .isApprox(-Eigen::Vector3d::UnitZ()));
}

TEST_F(KittiResult, StandsInTheWorldByThePosesBesideIt) {
  write("data/0000.txt", kLabels);
  write("camera.tum", "0 5 0 0 0 0 0 1\n0.201 5 0 100 0 0 1 0\n");
  const Tracks tracks = read_kitti_result(folder(), sequence_);
  EXPECT_EQ(tracks.camera.size(), 2u);
  const auto& states = tracks.objects[1].states;
  ASSERT_EQ(states.size(), 2u);
  EXPECT_TRUE(states[0].ellipsoid.world_from_object.translation.isApprox(Eigen::Vector3d(6, 1.25, 10)));
  EXPECT_TRUE(states[1].ellipsoid.world_from_object.translation.isApprox(Eigen::Vector3d(4, -1.2, 110)));
}

// By what the sequence was given; frames without a pose are left out.
TEST_F(KittiResult, ElseByTheGivenCamera) {
  write("0000.txt", kLabels);
  sequence_.given_camera = Trajectory{{0, {Eigen::Quaterniond::Identity(), {7, 0, 0}}}};
  const Tracks tracks = read_kitti_result(folder() / "0000.txt", sequence_);
  ASSERT_EQ(tracks.objects[1].states.size(), 1u);
  EXPECT_EQ(tracks.objects[1].states[0].ellipsoid.world_from_object.translation.x(), 8);
}

TEST_F(KittiResult, OfALidarAloneFramesAreScans) {
  Sequence scans;
  scans.lidar.emplace().rate_hz = 10;
  for (int i = 0; i < 3; ++i) scans.scans.push_back({i * kFrame_ns, ""});
  write("0000.txt", kLabels);
  EXPECT_EQ(read_kitti_result(folder(), scans).objects[1].states[1].stamp_ns, 3 * kFrame_ns);
}

TEST_F(KittiResult, SaysWhatIsWrong) {
  fs::create_directories(folder());
  EXPECT_NE(refusal().find("has no file of labels"), std::string::npos);
  write("0000.txt", "3 0 Car -1 -1 -10 10 10 50 50 1.5 2 4 1 2 10 0\n");
  EXPECT_NE(refusal().find("0000.txt:1: frame '3' is no whole number from 0 to 2"), std::string::npos);
  write("0001.txt", "");
  EXPECT_NE(refusal().find("has 2 files of labels"), std::string::npos);
  fs::remove(folder() / "0001.txt");
  write("0000.txt", kLabels);
  write("poses/0000.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_NE(refusal().find("poses/0000.txt: has 1 lines for 3 frames"), std::string::npos);
}

// The export's box is larger where the camera looks down, its centre is the object's.
TEST_F(KittiResult, OfAnExportHasTheTruthsPlaces) {
  const fs::path data = temp_.path() / "data", exported = temp_.path() / "kitti", out = temp_.path() / "out";
  write("small.yaml", small_scene_yaml());
  ASSERT_EQ(run_program({"simulate", folder() / "small.yaml", data, "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_program({"export", "kitti-tracking", data / "sequence", exported, "--quiet"}).exit_code, 0);
  expect_refused(run_program({"convert-result", "kitti-tracking", exported, out}), "--sequence is required");
  fs::remove_all(exported / "poses");  // the given camera's instead: the truth's world
  const ProgramRun run =
      run_program({"convert-result", "kitti-tracking", exported, out, "--sequence", data / "sequence"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("the sequence's given ones are taken"), std::string::npos) << run.err;
  const Tracks truth = read_tracks(data / "truth"), result = read_tracks(out);
  ASSERT_EQ(result.objects.size(), 2u);
  for (const ObjectTrack& track : result.objects)
    for (const ObjectState& state : track.states) {
      const auto& expected = truth.objects.at(track.id - 1).states.at(state.frame);
      EXPECT_EQ(state.stamp_ns, expected.stamp_ns);
      EXPECT_LT(
          (state.ellipsoid.world_from_object.translation - expected.ellipsoid.world_from_object.translation)
              .norm(),
          1e-5);
    }
}

}  // namespace
}  // namespace uniquadric
