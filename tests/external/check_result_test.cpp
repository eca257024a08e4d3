// Fabricated results, each with one fault that check-result has to name, and a right one.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/files.h"
#include "core/sequence/calibration.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kFrames = 12;
constexpr double kFrame_s = 0.1;

Pose turned(const Eigen::Vector3d& rotation_vector, const Eigen::Vector3d& translation_m) {
  return {exp_so3(rotation_vector), translation_m};
}

// A camera that walks and turns, an object that moves and turns.
Pose camera_at(int i) {
  const double t = kFrame_s * i;
  return turned({0.3 + 0.5 * t, 0.4 - 0.3 * t, 0.8 * t}, {2 * t, 0.5 - t * t, 1 + 0.3 * t});
}
Pose object_at(int i) {
  const double t = kFrame_s * i;
  return turned({0.1, 0.2, 0.3 + t}, {1 + t, 0.2, 4});
}

std::string line_of(const std::string& stamp, const Pose& pose, bool wxyz = false) {
  const auto& t = pose.translation;
  const auto& q = pose.rotation;
  return wxyz ? fmt::format("{} {} {} {} {} {} {} {}\n", stamp, t.x(), t.y(), t.z(), q.w(), q.x(), q.y(),
                            q.z())
              : fmt::format("{} {} {} {} {} {} {} {}\n", stamp, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                            q.w());
}

// What is wrong with a fabricated result.
struct Fault {
  bool camera_wxyz = false, object_wxyz = false, inverse = false;
  double length = 1, size = 1, stamp_factor = 1, stamp_offset_s = 0;
};

class CheckResult : public testing::Test {
 protected:
  void SetUp() override {
    Tracks truth;
    Sequence sequence;
    sequence.name = "made";
    sequence.camera = {.width = 8, .height = 8, .fx = 8, .fy = 8, .cx = 3.5, .cy = 3.5};
    sequence.rate_hz = 1 / kFrame_s;
    sequence.given_camera.emplace();
    fs::create_directories(folder() / "truth/objects");
    fs::create_directories(folder() / "sequence/rgb");
    Trajectory object;
    for (int i = 0; i < kFrames; ++i) {
      const std::int64_t stamp_ns = i * 100'000'000;
      truth.camera.push_back({stamp_ns, camera_at(i)});
      object.push_back({stamp_ns, object_at(i)});
      SequenceFrame& frame = sequence.frames.emplace_back();
      frame.frame = i, frame.stamp_ns = stamp_ns, frame.rgb = fmt::format("rgb/{}.png", i);
      write_text(folder() / "sequence" / frame.rgb, "");
    }
    sequence.given_camera = truth.camera;
    write_sequence_index(folder() / "sequence", sequence);
    write_tum(folder() / "truth/camera.tum", truth.camera);
    write_tum(folder() / "truth/objects/1.tum", object);
    write_objects_yaml(folder() / "truth/objects.yaml", {{1, "box", {0.4, 0.3, 0.2}, "box", ""}}, "");
  }
  fs::path folder() const { return temp_.path(); }
  fs::path mine() const { return folder() / "mine"; }

  // Another world than the truth's, as a program may choose it.
  void write_result(const Fault& fault) const {
    const Pose mine_from_world = turned({0.1, -0.4, 0.2}, {3, 1, -2});
    std::string camera, object;
    for (int i = 0; i < kFrames; ++i) {
      const std::string stamp = fmt::format("{}", fault.stamp_factor * (kFrame_s * i + fault.stamp_offset_s));
      const auto scaled = [&](Pose pose) {
        pose.translation *= fault.length;
        return pose;
      };
      const Pose pose = mine_from_world * camera_at(i);
      camera += line_of(stamp, scaled(fault.inverse ? pose.inverse() : pose), fault.camera_wxyz);
      object += line_of(stamp, scaled(mine_from_world * object_at(i)), fault.object_wxyz);
    }
    fs::create_directories(mine() / "objects");
    write_text(mine() / "camera.tum", camera);
    write_text(mine() / "objects/1.tum", object);
    write_text(mine() / "objects.yaml", fmt::format("1: {{size_m: [{}, {}, {}]}}\n", 0.8 * fault.size,
                                                    0.6 * fault.size, 0.4 * fault.size));
  }
  std::string with(const char* option) const { return folder() / (option + 2); }
  ProgramRun check(const std::vector<std::string>& options) const {
    std::vector<std::string> arguments{"check-result", mine()};
    for (const std::string& option : options) {
      arguments.push_back(option);
      arguments.push_back(with(option.c_str()));
    }
    return run_program(arguments);
  }
  // One suspicion, about `file`.
  void expect_suspicion(const Fault& fault, const std::vector<std::string>& options, const std::string& file,
                        const std::string& what) const {
    write_result(fault);
    const ProgramRun run = check(options);
    EXPECT_EQ(run.exit_code, 1) << run.out << run.err;
    EXPECT_NE(run.out.find("suspicious: " + (mine() / file).string() + ": "), std::string::npos) << run.out;
    EXPECT_NE(run.out.find(what), std::string::npos) << run.out;
  }
  const TempFolder temp_;
};

TEST_F(CheckResult, ARightOneHasNone) {
  write_result({});
  for (const auto& options :
       std::vector<std::vector<std::string>>{{}, {"--sequence"}, {"--truth"}, {"--sequence", "--truth"}}) {
    const ProgramRun run = check(options);
    EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
    EXPECT_NE(run.out.find("0 suspicions"), std::string::npos) << run.out;
  }
  const ProgramRun run = check({"--sequence"});
  EXPECT_NE(run.out.find("camera: 12 poses, 0.000000000 to 1.100000000 s, 10 Hz"), std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("object 1: 12 states"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("size 0.8 x 0.6 x 0.4 m"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("12 of 12 poses lie at 12 of 12 frames (100 %)"), std::string::npos) << run.out;
}

TEST_F(CheckResult, TheTruthItselfHasNone) {
  fs::copy(folder() / "truth", mine(), fs::copy_options::recursive);
  EXPECT_EQ(check({"--sequence", "--truth"}).exit_code, 0);
}

TEST_F(CheckResult, WithoutACameraObjectsAreComparedWhereTheyStand) {
  write_result({});
  fs::remove(mine() / "camera.tum");
  const ProgramRun run = check({"--sequence"});
  EXPECT_EQ(run.exit_code, 0) << run.out;
  EXPECT_NE(run.out.find("objects are compared where they stand"), std::string::npos) << run.out;
}

TEST_F(CheckResult, NamesQuaternionsInAnotherOrder) {
  for (const char* by : {"--sequence", "--truth"})
    expect_suspicion({.camera_wxyz = true}, {by}, "camera.tum", "in the order w x y z");
  expect_suspicion({.object_wxyz = true}, {"--truth"}, "objects/1.tum", "in the order w x y z");
}

// All that is known without a reference: where the trajectory begins.
TEST_F(CheckResult, NamesAnIdentityInAnotherOrder) {
  write_result({});
  write_text(mine() / "camera.tum", "0 0 0 0 1 0 0 0\n0.1 0 0 0 0.8 0 0.6 0\n");
  const ProgramRun run = check({});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.out.find("camera.tum: the first quaternion is 1 0 0 0"), std::string::npos) << run.out;
}

TEST_F(CheckResult, NamesWorldToCamera) {
  for (const char* by : {"--sequence", "--truth"})
    expect_suspicion({.inverse = true}, {by}, "camera.tum", "world-to-camera");
  expect_suspicion({.camera_wxyz = true, .inverse = true}, {"--truth"}, "camera.tum",
                   "world-to-camera (expected is world_from_camera) with quaternions");
  EXPECT_EQ(check({}).exit_code, 0) << "without a reference it is not judged";
}

TEST_F(CheckResult, NamesMillimetres) {
  expect_suspicion({.length = 1000}, {"--truth"}, "camera.tum", "is it in metres?");
  expect_suspicion({.length = 1000}, {}, "objects/1.tum", "in millimetres?");
  expect_suspicion({.size = 1000}, {}, "objects.yaml", "are sizes in millimetres?");
  expect_suspicion({.size = 1000}, {"--truth"}, "objects.yaml", "are sizes in metres?");
}

TEST_F(CheckResult, NamesSizesOfTwiceOrHalf) {
  expect_suspicion({.size = 2}, {"--truth"}, "objects.yaml", "2.00 times the truth's: full sizes given as");
  expect_suspicion({.size = 0.5}, {"--truth"}, "objects.yaml", "0.50 times the truth's: semi-axes given as");
}

TEST_F(CheckResult, NamesStamps) {
  expect_suspicion({.stamp_offset_s = 50}, {"--sequence"}, "camera.tum", "not of the sequence: 12 of 12");
  expect_suspicion({.stamp_factor = 1e3}, {}, "camera.tum", "they look like milliseconds");
  expect_suspicion({.stamp_factor = 1e9}, {}, "camera.tum", "they look like nanoseconds");
}

// Stamps that are no seconds at all are unreadable; the message has the reason.
TEST_F(CheckResult, SaysWhyItCannotBeRead) {
  write_result({});
  write_text(mine() / "camera.tum", "1700000000000000000 0 0 0 0 0 0 1\n1700000000100000000 0 0 0 0 0 0 1\n");
  expect_refused(check({}), "they look like nanoseconds");
  fs::remove_all(mine());
  expect_refused(check({}), "is not a folder");
}

}  // namespace
}  // namespace uniquadric
