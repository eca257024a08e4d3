// Recordings in other tools' layouts, made of a simulated scene by a writer that shares nothing with the
// program, through import, estimate and evaluate.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/base/text.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "tests/harness/program.h"
#include "tests/support/recorded_world.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

RecordedWorld world_of(const fs::path& data) {
  const Sequence sequence = open_sequence(data / "sequence");
  const Tracks truth = read_tracks(data / "truth");
  const Camera& camera = sequence.camera;
  RecordedWorld world;
  world.width = camera.width, world.height = camera.height;
  world.fx = camera.fx, world.fy = camera.fy, world.cx = camera.cx, world.cy = camera.cy;
  world.camera_from_imu = sequence.imu->camera_from_imu.matrix();
  for (const SequenceFrame& frame : sequence.frames) {
    world.stamps_ns.push_back(frame.stamp_ns);
    world.colors.push_back(read_rgb(sequence, frame));
    world.depths_m.push_back(read_depth(sequence, frame));
    world.ids.push_back(read_masks(sequence, frame));
  }
  for (const StampedPose& pose : truth.camera) world.camera.push_back({pose.stamp_ns, pose.pose.matrix()});
  for (const ObjectTrack& track : truth.objects)
    for (const ObjectState& state : track.states)
      world.objects[track.id].push_back({state.stamp_ns, state.ellipsoid.world_from_object.matrix()});
  for (const ImuSample& sample : read_imu_csv(sequence.folder / "imu.csv"))
    world.imu.push_back({sample.stamp_ns, sample.angular_velocity_radps, sample.specific_force_mps2});
  return world;
}

// What a camera `baseline_m` to the right of one sees of the surfaces that the first one sees.
cv::Mat seen_from_the_right(const cv::Mat& color, const cv::Mat& depth_m, double bf) {
  constexpr double kOneSurface_px = 2;  // of disparity, between neighbours
  cv::Mat image = cv::Mat::zeros(color.size(), CV_8UC3), nearest = cv::Mat::zeros(color.size(), CV_64FC1);
  for (int v = 0; v < color.rows; ++v)
    for (int u = 0; u + 1 < color.cols; ++u) {
      const double d0 = bf / depth_m.at<float>(v, u), d1 = bf / depth_m.at<float>(v, u + 1);
      if (!(std::abs(d0 - d1) < kOneSurface_px)) continue;
      const double begin = u - d0, end = u + 1 - d1;
      for (int x = std::max(0, static_cast<int>(std::ceil(begin))); x <= end; ++x) {
        if (d0 < nearest.at<double>(v, x)) continue;
        nearest.at<double>(v, x) = d0;
        const double part = end > begin ? (x - begin) / (end - begin) : 0;
        for (int k = 0; k < 3; ++k)
          image.at<cv::Vec3b>(v, x)[k] = cv::saturate_cast<unsigned char>(
              (1 - part) * color.at<cv::Vec3b>(v, u)[k] + part * color.at<cv::Vec3b>(v, u + 1)[k]);
      }
    }
  return image;
}

class ImportedRecording : public testing::Test {
 protected:
  ImportedRecording() {
    write_text(folder() / "scene.yaml", small_scene_yaml() + "imu: {}\n");
    ok({"simulate", folder() / "scene.yaml", folder() / "data", "--frames", "8", "--quiet"});
    world_ = world_of(folder() / "data");
    // as the recordings' own names are
    std::string sizes = read_text(folder() / "data/truth/objects.yaml");
    sizes.replace(sizes.find("\"box\""), 5, "\"box1\"").replace(sizes.find("\"ball\""), 6, "\"box2\"");
    write_text(folder() / "sizes.yaml", sizes);
  }
  void ok(const std::vector<std::string>& arguments) const {
    const ProgramRun run = run_program(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  // What `evaluate` says of an estimate of `data`, each in a folder of its own.
  json evaluated(const std::string& data) const {
    const fs::path at = folder() / data;
    ok({"info", at, "--check"});
    const fs::path variant = folder() / "variant.yaml";  // eight frames are too few to see what moves
    write_text(
        variant,
        "schema: 1\nname: every_part\nego: {source: given}\nbackend: single_frame\npoints: {smooth_px: 0}\n"
        "segmentation: {moving_parts: {ratio: 0}}\nshape: {axis_naming: previous, obb: {fit: "
        "surface, inlier_distance: surface, axis_rule: blend_best}}\n");
    ok({"estimate", at / "sequence", folder() / (data + "_estimate"), "--variant", variant, "--quiet"});
    ok({"evaluate", at / "truth", folder() / (data + "_estimate"), folder() / (data + "_evaluation"),
        "--quiet"});
    return json::parse(read_text(folder() / (data + "_evaluation/evaluation.json")));
  }
  const fs::path& folder() const { return temp_.path(); }

  TempFolder temp_;
  RecordedWorld world_;
};

TEST_F(ImportedRecording, OfTheRawOxfordMultimotionLayoutIsEstimatedAndEvaluated) {
  write_omd_raw(world_, folder() / "recording");
  ok({"import", "omd", folder() / "recording", folder() / "omd", "--objects", folder() / "sizes.yaml",
      "--quiet"});
  const json evaluation = evaluated("omd");
  EXPECT_EQ(evaluation["camera"]["pairs"], 8);
  ASSERT_EQ(evaluation["objects"].size(), 2u);
  const json& box =
      evaluation["objects"][0];  // the other stands still: motion does not tell it from the room
  EXPECT_EQ(box["name"], "box1");
  EXPECT_GT(box["coverage"], 0.8);
  EXPECT_GT(box["iou3d"]["mean"], 0.5);
  EXPECT_LT(box["ape"]["translation_m"]["rmse"], 0.05);  // m: of a centre seen from one side
  double worst_m = 0;  // but in the last frame, where the ball beside it is in its mask
  for_each_line(
      folder() / "omd_evaluation/frames.csv",
      [&](int, const std::vector<std::string_view>& fields) {
        if (fields[3] == "box1" && fields[0] != "7" && !fields[5].empty())
          worst_m = std::max(worst_m, *parse_double(fields[5]));
      },
      ',');
  EXPECT_GT(worst_m, 0);
  EXPECT_LT(worst_m, 0.06);
}

TEST_F(ImportedRecording, OfTheProcessedOxfordMultimotionLayoutIsEstimatedAsTheSequenceItCameFrom) {
  write_omd_processed(world_, folder() / "recording", 5000);
  ok({"import", "omd", folder() / "recording", folder() / "omd", "--objects", folder() / "sizes.yaml",
      "--depth", "metric", "--quiet"});
  const json evaluation = evaluated("omd"), direct = evaluated("data");
  for (const std::size_t k : {0, 1}) {
    const json &object = evaluation["objects"][k], &expected = direct["objects"][k];
    EXPECT_EQ(object["coverage"], 1.0);  // its masks come at once, the segmenter's later: other outlines
    EXPECT_NEAR(object["iou3d"]["mean"].get<double>(), expected["iou3d"]["mean"].get<double>(), 0.05);
    EXPECT_NEAR(object["ape"]["translation_m"]["rmse"].get<double>(),
                expected["ape"]["translation_m"]["rmse"].get<double>(), 0.005);
  }
}

TEST_F(ImportedRecording, OfEurocIsEstimatedAndEvaluated) {
  constexpr double kBaseline_m = 0.15;
  world_.right_from_left(0, 3) = -kBaseline_m;
  for (std::size_t i = 0; i < world_.colors.size(); ++i)
    world_.right_colors.push_back(
        seen_from_the_right(world_.colors[i], world_.depths_m[i], world_.fx * kBaseline_m));
  write_euroc_layout(world_, folder() / "recording");
  ok({"import", "euroc", folder() / "recording", folder() / "euroc", "--quiet"});
  const json evaluation = evaluated("euroc");
  EXPECT_EQ(evaluation["camera"]["pairs"], 8);
  EXPECT_TRUE(evaluation["objects"].empty());
  EXPECT_GT(evaluation["config"]["estimate"]["frames_with_states"], 4);  // something moved in its depth
}

}  // namespace
}  // namespace uniquadric
