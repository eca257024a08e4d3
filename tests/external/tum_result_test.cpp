#include "core/import/tum_result.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "core/import/result.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr const char* kPath = "# of the camera\n0.1 1 2 3 0 0 0 1\n0.2 2 2 3 0 0 0.6 0.8\n";

class TumResult : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder() / name).parent_path());
    write_text(folder() / name, text);
  }
  std::string refusal() const {
    return input_error([&] { read_tum_result(folder()); });
  }
  fs::path folder() const { return temp_.path() / "mine"; }
  const TempFolder temp_;
};

TEST_F(TumResult, AFileIsTheCamera) {
  write("any.txt", kPath);
  const Tracks tracks = read_tum_result(folder() / "any.txt");
  ASSERT_EQ(tracks.camera.size(), 2u);
  EXPECT_EQ(tracks.camera[1].stamp_ns, 200'000'000);
  EXPECT_EQ(tracks.camera[1].pose.rotation.z(), 0.6);
  EXPECT_TRUE(tracks.objects.empty());
}

TEST_F(TumResult, AFolderHasObjectsOfEitherName) {
  write("KeyFrameTrajectory.txt", kPath);
  write("objects/1.tum", "0.1 5 0 0 0 0 0 1\n");
  write("objects/7.txt", "0.15 6 0 0 0 0 0 1\n0.2 7 0 0 0 0 0 1\n");
  write("objects.yaml", "1: {size_m: [0.4, 0.3, 0.2]}\n7: {semi_axes_m: [1, 2, 3]}\n");
  const Tracks tracks = read_tum_result(folder());
  EXPECT_EQ(tracks.camera.size(), 2u);
  ASSERT_EQ(tracks.objects.size(), 2u);
  EXPECT_EQ(tracks.objects[0].states[0].ellipsoid.semi_axes_m, Eigen::Vector3d(0.2, 0.15, 0.1));
  EXPECT_EQ(tracks.objects[0].states[0].exponents, (SuperExponents{1, 1, 1}));
  EXPECT_EQ(tracks.objects[1].id, 7);
  EXPECT_EQ(tracks.objects[1].states[1].ellipsoid.world_from_object.translation.x(), 7);
  EXPECT_EQ(tracks.objects[1].states[1].exponents, SuperExponents());
  EXPECT_EQ(tracks.objects[1].states[1].frame, 2);  // of the stamps 0.1, 0.15, 0.2
}

TEST_F(TumResult, SaysWhatIsMissingOrTwice) {
  fs::create_directories(folder());
  EXPECT_NE(refusal().find("has neither a trajectory of the camera"), std::string::npos);
  write("camera.tum", kPath);
  write("CameraTrajectory.txt", kPath);
  EXPECT_NE(refusal().find("several trajectories of the camera, camera.tum, CameraTrajectory.txt"),
            std::string::npos);
  fs::remove(folder() / "CameraTrajectory.txt");
  write("objects/2.tum", kPath);
  EXPECT_NE(refusal().find("2.tum: objects.yaml has no size of object 2"), std::string::npos);
  write("objects.yaml", "2: {size_m: [1, 1, 1]}\n3: {size_m: [1, 1, 1]}\n");
  EXPECT_NE(refusal().find("objects.yaml: object 3 has no poses"), std::string::npos);
  write("objects/2.txt", kPath);
  EXPECT_NE(refusal().find("objects: has several trajectories of object 2"), std::string::npos);
  fs::remove(folder() / "objects/2.txt");
  write("objects.yaml", "2: {size_m: [1, 1, 1]}\n");
  write("camera.tum", "0.1 1 2 3 0 0 0\n");
  EXPECT_NE(refusal().find("camera.tum:1: expected 8 numbers"), std::string::npos);
}

TEST_F(TumResult, IsConvertedWithItsStampsOrTheFrames) {
  write("trajectory.txt", kPath);
  write("objects/1.txt", "0.2 5 0 0 0 0 0 1\n");
  write("objects.yaml", "1: {size_m: [0.4, 0.3, 0.2]}\n");
  const fs::path out = temp_.path() / "out";
  const ProgramRun run = run_program({"convert-result", "tum", folder(), out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Tracks tracks = read_tracks(out);
  ASSERT_EQ(tracks.camera.size(), 2u);
  EXPECT_EQ(tracks.camera[0].stamp_ns, 100'000'000);
  ASSERT_EQ(tracks.objects.size(), 1u);
  EXPECT_EQ(tracks.objects[0].states[0].frame, 1);
  EXPECT_EQ(tracks.objects[0].states[0].ellipsoid.semi_axes_m, Eigen::Vector3d(0.2, 0.15, 0.1));
  expect_refused(run_program({"convert-result", "tum", folder(), out}), "out");
  EXPECT_EQ(run_program({"convert-result", "tum", folder(), out, "--force"}).exit_code, 0);
  expect_refused(run_program({"convert-result", "tum", folder(), folder() / "in"}), "lies in");
}

}  // namespace
}  // namespace uniquadric
