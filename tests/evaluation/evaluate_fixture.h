#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/files.h"
#include "core/sequence/calibration.h"
#include "core/sequence/tracks.h"
#include "evaluation/evaluate.h"

namespace uniquadric {

namespace fs = std::filesystem;
using nlohmann::json;
inline constexpr int kFrames = 30;
inline constexpr std::int64_t kPeriodNs = 33'333'333;
inline constexpr double kRounding = 1e-7;  // rotations written to text and read back, near zero

inline Pose camera_pose(int i) {
  return {exp_so3({0, 0.002 * i, 0.01}), Eigen::Vector3d(0.01 * i, 0.1, -0.2 + 0.0005 * i * i)};
}
inline Pose object_pose(int id, int i, double turn_rad = 0.02) {
  return {exp_so3({0.3 * id, turn_rad * i, 0.4}), Eigen::Vector3d(0.8 * id - 1.5, 0.01 * i, 3)};
}

inline const std::vector<ObjectDescription> kObjects = {{1, "Cuboid", {0.3, 0.2, 0.1}, "box", ""},
                                                        {2, "Cube", {0.2, 0.2, 0.2}, "box", ""},
                                                        {3, "Ball", {0.25, 0.25, 0.25}, "ball", ""}};

// A folder of its own for each test, removed afterwards.
class Evaluate : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            (std::string("evaluate_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(root_);
    write_truth();
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path truth() const { return root_ / "scene" / "truth"; }
  fs::path estimate() const { return root_ / "estimate"; }

  void write_truth(std::int64_t period_ns = kPeriodNs, double turn_rad = 0.02) {
    fs::create_directories(truth() / "objects");
    Trajectory camera;
    for (int i = 0; i < kFrames; ++i) camera.push_back({i * period_ns, camera_pose(i)});
    write_tum(truth() / "camera.tum", camera);
    write_camera_yaml(truth() / "camera.yaml", Camera{});
    write_objects_yaml(truth() / "objects.yaml", kObjects);
    for (const auto& object : kObjects) {
      Trajectory poses;
      for (int i = 0; i < kFrames; ++i) poses.push_back({i * period_ns, object_pose(object.id, i, turn_rad)});
      write_tum(truth() / "objects" / (std::to_string(object.id) + ".tum"), poses);
    }
  }

  // The truth without the frames from `first` up to `end`, of the camera as of all objects.
  void write_hole_in_truth(int first, int end) {
    const auto cut = [&](const fs::path& file) {
      Trajectory poses = read_tum(file);
      poses.erase(poses.begin() + first, poses.begin() + end);
      write_tum(file, poses);
    };
    cut(truth() / "camera.tum");
    for (const auto& object : kObjects) cut(truth() / "objects" / (std::to_string(object.id) + ".tum"));
  }

  // The truth under other ids (10 for 1, ...), changed by `change`.
  void write_changed(const std::function<void(Tracks&)>& change) {
    Tracks tracks = read_tracks(truth());
    for (auto& object : tracks.objects) object.id *= 10;
    change(tracks);
    fs::create_directories(estimate());
    write_estimate(estimate(), tracks);
  }

  json run(const fs::path& truth_folder, const fs::path& estimate_folder) {
    EvaluateOptions options;
    options.iou_samples = 2000;
    options.force = true;
    uniquadric::evaluate(truth_folder, estimate_folder, options, root_ / "out");
    return json::parse(read_text(root_ / "out" / "evaluation.json"));
  }
  json run() { return run(truth(), estimate()); }

  fs::path root_;
};

}  // namespace uniquadric
