#include "evaluation/evaluate.h"

#include <numbers>

#include "core/base/text.h"
#include "evaluation/report/poses.h"
#include "tests/evaluation/evaluate_fixture.h"

namespace uniquadric {
namespace {

TEST_F(Evaluate, TruthAgainstItselfIsZeroAndOneExactly) {
  const json result = run(root_ / "scene", truth());
  EXPECT_EQ(result["schema"], 1);
  EXPECT_EQ(result["camera"]["coverage"], 1);
  int checked = 0;
  const auto zero = [&](const json& statistics) {
    for (const char* key : {"rmse", "mean", "max", "std", "sse"})
      EXPECT_EQ(statistics.at(key), 0) << statistics;
    ++checked;
  };
  for (const char* kind : {"ape", "rpe"})
    for (const char* part : {"translation_m", "rotation_rad"}) zero(result["camera"][kind][part]);
  ASSERT_EQ(result["objects"].size(), 3u);
  for (const json& object : result["objects"]) {
    EXPECT_EQ(object["matched_id"], object["id"]);
    EXPECT_EQ(object["coverage"], 1);
    EXPECT_EQ(object["longest_gap_s"], 0);
    EXPECT_EQ(object["id_switches"], 0);
    EXPECT_EQ(object["relabel_flips"], 0);
    for (const char* kind : {"ape", "rpe", "motion_error"})
      for (const char* part : {"translation_m", "rotation_rad"}) zero(object[kind][part]);
    zero(object["ape"]["rotation_naive_rad"]);
    zero(object["d_shape_m"]);
    zero(object["ape_of_distance"]);
    for (const char* axis : {"x", "y", "z"}) zero(object["semi_axes_error_m"][axis]);
    for (const char* key : {"iou3d", "iou2d", "iou2d_ellipse"}) {
      EXPECT_EQ(object[key]["min"], 1) << key;
      EXPECT_EQ(object[key]["mean"], 1) << key;
      EXPECT_EQ(object[key]["n"], kFrames) << key;
    }
    EXPECT_EQ(object["iou3d_monte_carlo"]["mean"], 1);
    EXPECT_EQ(object["drift"]["max_translation_m"], 0);
  }
  EXPECT_EQ(checked, 4 + 3 * 12);
  for (const char* key : {"hota", "mota", "idf1"}) EXPECT_NEAR(result["tracking"][key], 1, 1e-12);
}

TEST_F(Evaluate, SameInputSameBytes) {
  run(truth(), truth());
  const std::string first = read_text(root_ / "out" / "evaluation.json"),
                    csv = read_text(root_ / "out" / "frames.csv");
  run(truth(), truth());
  EXPECT_EQ(first, read_text(root_ / "out" / "evaluation.json"));
  EXPECT_EQ(csv, read_text(root_ / "out" / "frames.csv"));
}

// The estimate's world is turned and moved, its ids are others, and a fourth track is nobody's.
TEST_F(Evaluate, PosesOfBothSidesStandInTheTruthsWorld) {
  const Pose other{exp_so3({0.2, -0.3, 1}), Eigen::Vector3d(3, -2, 1)};
  write_changed([&](Tracks& tracks) {
    for (auto& pose : tracks.camera) pose.pose = other * pose.pose;
    ObjectTrack stray = tracks.objects[0];
    stray.id = 77;
    for (auto& state : stray.states)
      state.ellipsoid.world_from_object.translation += Eigen::Vector3d(50, 0, 0);
    tracks.objects.push_back(stray);
    for (auto& object : tracks.objects)
      for (auto& state : object.states)
        state.ellipsoid.world_from_object = other * state.ellipsoid.world_from_object;
  });
  run();
  const ComparedPoses poses = read_poses(root_ / "out" / "poses.csv");
  const Tracks expected = read_tracks(truth());
  constexpr double kNineDigits = 1e-7;
  ASSERT_EQ(poses.truth.camera.size(), expected.camera.size());
  ASSERT_EQ(poses.estimate.camera.size(), expected.camera.size());
  ASSERT_EQ(poses.estimate.objects.size(), expected.objects.size());
  for (std::size_t k = 0; k < expected.camera.size(); ++k) {
    EXPECT_LT(log_se3(expected.camera[k].pose.inverse() * poses.truth.camera[k].pose).norm(), kNineDigits);
    EXPECT_LT(log_se3(expected.camera[k].pose.inverse() * poses.estimate.camera[k].pose).norm(), kNineDigits);
  }
  for (std::size_t i = 0; i < expected.objects.size(); ++i) {
    const ObjectTrack& object = poses.estimate.objects[i];
    EXPECT_EQ(object.id, expected.objects[i].id);
    ASSERT_EQ(object.states.size(), expected.objects[i].states.size());
    for (std::size_t k = 0; k < object.states.size(); ++k) {
      const Ellipsoid &a = expected.objects[i].states[k].ellipsoid, &b = object.states[k].ellipsoid;
      EXPECT_LT(log_se3(a.world_from_object.inverse() * b.world_from_object).norm(), kNineDigits);
      EXPECT_LT((a.semi_axes_m - b.semi_axes_m).norm(), kNineDigits);
      EXPECT_EQ(object.states[k].stamp_ns, expected.objects[i].states[k].stamp_ns);
    }
  }
  ASSERT_EQ(poses.unmatched.objects.size(), 1u);
  EXPECT_EQ(poses.unmatched.objects[0].id, 77);
}

TEST_F(Evaluate, OffsetsAndOtherIdsAreFound) {
  write_changed([](Tracks& tracks) {
    for (auto& object : tracks.objects)
      for (auto& state : object.states)
        state.ellipsoid.world_from_object.translation += Eigen::Vector3d(0.03, 0, 0.04);
    std::swap(tracks.objects[0].id, tracks.objects[2].id);
    std::reverse(tracks.objects.begin(), tracks.objects.end());
  });
  const json result = run();
  const std::vector<int> ids = {30, 20, 10};
  for (int i = 0; i < 3; ++i) {
    const json& object = result["objects"][i];
    EXPECT_EQ(object["matched_id"], ids[i]);
    EXPECT_NEAR(object["ape"]["translation_m"]["rmse"], 0.05, kRounding);
    EXPECT_NEAR(object["d_shape_m"]["mean"], 0.05, kRounding);
    EXPECT_LT(object["iou3d"]["mean"], 0.9);
    EXPECT_LT(object["iou2d"]["mean"], 1);
    EXPECT_NEAR(object["iou3d"]["mean"], object["iou3d_monte_carlo"]["mean"],
                5 * object["iou3d_monte_carlo"]["stderr"].get<double>());
  }
}

TEST_F(Evaluate, RenamedAxesAreUndoneByTheTrueSymmetry) {
  const Eigen::Matrix3d names =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix().array().round();
  write_changed([&](Tracks& tracks) {
    for (auto& state : tracks.objects[0].states) {
      state.ellipsoid.world_from_object.rotation =
          state.ellipsoid.world_from_object.rotation * Eigen::Quaterniond(names);
      state.ellipsoid.semi_axes_m = names.cwiseAbs().transpose() * state.ellipsoid.semi_axes_m;
    }
    for (auto& state : tracks.objects[1].states)  // a cube: a quarter turn is no error
      state.ellipsoid.world_from_object.rotation =
          state.ellipsoid.world_from_object.rotation * Eigen::Quaterniond(names);
    for (auto& state : tracks.objects[2].states)  // a ball: any constant turn is none
      state.ellipsoid.world_from_object.rotation =
          state.ellipsoid.world_from_object.rotation * exp_so3({1, 2, 0.5});
  });
  const json result = run();
  for (const json& object : result["objects"]) {
    EXPECT_NEAR(object["ape"]["rotation_rad"]["max"], 0, kRounding) << object["name"];
    EXPECT_NEAR(object["rpe"]["translation_m"]["max"], 0, kRounding) << object["name"];
    EXPECT_GT(object["ape"]["rotation_naive_rad"]["min"], 1) << object["name"];
    EXPECT_NEAR(object["iou3d"]["min"], 1, 1e-9) << object["name"];
    for (const char* axis : {"x", "y", "z"})
      EXPECT_NEAR(object["semi_axes_error_m"][axis]["max"], 0, kRounding);
  }
  EXPECT_EQ(result["objects"][2]["symmetry"], "sphere");
}

TEST_F(Evaluate, LostObjectsAndMissingFramesAreCounted) {
  write_changed([](Tracks& tracks) {
    auto& states = tracks.objects[0].states;
    states.erase(states.begin() + 5, states.begin() + 11);  // six frames missing
    states.back().status = ObjectStatus::lost;              // and the last one given up
    tracks.objects.pop_back();                              // the ball never found
  });
  const json result = run();
  const json& cuboid = result["objects"][0];
  EXPECT_NEAR(cuboid["coverage"], 23.0 / kFrames, 1e-15);
  EXPECT_EQ(cuboid["ape"]["translation_m"]["n"], 23);
  EXPECT_EQ(cuboid["rpe"]["translation_m"]["n"], 21);  // two runs of matched frames
  EXPECT_NEAR(cuboid["longest_gap_s"], 6 * kPeriodNs * 1e-9, 1e-12);
  const json& lost = result["objects"][2];
  EXPECT_TRUE(lost["matched_id"].is_null());
  EXPECT_EQ(lost["coverage"], 0);
  EXPECT_NEAR(lost["longest_gap_s"], kFrames * kPeriodNs * 1e-9, 1e-12);
  for (const char* key : {"iou3d", "iou2d", "d_shape_m", "drift", "iou3d_monte_carlo"})
    EXPECT_TRUE(lost[key].is_null()) << key;
  EXPECT_TRUE(lost["ape"]["translation_m"].is_null());
  // 53 of 90 matched, no false track: MOTA and IDF1 by hand
  EXPECT_NEAR(result["tracking"]["mota"], 53.0 / 90, 1e-12);
  EXPECT_NEAR(result["tracking"]["idf1"], 2 * 53.0 / (90 + 53), 1e-12);
}

TEST_F(Evaluate, CameraStepsDoNotBridgeAHole) {
  write_changed([](Tracks& tracks) {
    for (std::size_t i = 15; i < kFrames; ++i)
      tracks.camera[i].pose.translation.x() += 1;  // a jump in the hole
    tracks.camera.erase(tracks.camera.begin() + 10, tracks.camera.begin() + 15);
  });
  write_text(estimate() / "run.yaml", "variant: {ego: given}\n");  // no alignment
  const json camera = run()["camera"];
  EXPECT_EQ(camera["pairs"], kFrames - 5);
  EXPECT_EQ(camera["rpe"]["translation_m"]["n"], kFrames - 5 - 2);  // two runs
  EXPECT_NEAR(camera["rpe"]["translation_m"]["max"], 0, kRounding);
  EXPECT_NEAR(camera["ape"]["translation_m"]["max"], 1, kRounding);
}

TEST_F(Evaluate, NoStepBridgesAHoleOfTheTruth) {
  write_changed([](Tracks& tracks) {
    for (std::size_t i = 15; i < kFrames; ++i) {  // a jump in the hole, which the estimate goes through
      tracks.camera[i].pose.translation.x() += 1;
      tracks.objects[0].states[i].ellipsoid.world_from_object.translation.x() += 0.05;
    }
  });
  write_hole_in_truth(10, 15);
  write_text(estimate() / "run.yaml", "variant: {ego: given}\n");  // no alignment
  const json result = run();
  for (const json& figures :
       {result["camera"]["rpe"], result["objects"][0]["rpe"], result["objects"][0]["motion_error"]}) {
    EXPECT_EQ(figures["translation_m"]["n"], kFrames - 5 - 2);  // two runs
    EXPECT_LT(figures["translation_m"]["max"], 0.002);  // a turning body's motion is off by 0.05 m * 0.02
  }
  EXPECT_EQ(result["objects"][0]["ape"]["translation_m"]["n"], kFrames - 5);
}

TEST_F(Evaluate, TwoMatchedFramesGiveNoErrorFigures) {
  write_changed([](Tracks& tracks) { tracks.objects[0].states.resize(2); });
  const json object = run()["objects"][0];
  EXPECT_EQ(object["matched_frames"], 2);
  EXPECT_NEAR(object["coverage"], 2.0 / kFrames, 1e-15);
  for (const char* kind : {"ape", "rpe", "motion_error"})
    for (const auto& [part, value] : object[kind].items()) EXPECT_TRUE(value.is_null()) << kind << part;
  EXPECT_TRUE(object["drift"].is_null());
  EXPECT_EQ(object["iou3d"]["n"], 2);
}

TEST_F(Evaluate, AnEstimateThatFoundNothingHasAResult) {
  write_changed([](Tracks& tracks) {
    tracks.camera.clear();
    tracks.objects.clear();
  });
  const json result = run();
  EXPECT_EQ(result["camera"]["coverage"], 0);
  EXPECT_TRUE(result["camera"]["ape"]["translation_m"].is_null());
  ASSERT_EQ(result["objects"].size(), 3u);
  for (const json& object : result["objects"]) EXPECT_EQ(object["coverage"], 0);
  EXPECT_EQ(result["tracking"]["mota"], 0);
}

TEST_F(Evaluate, IdSwitchesAreCounted) {
  write_changed([](Tracks& tracks) {
    ObjectTrack second = tracks.objects[0];  // the cuboid's track breaks in two
    second.id = 40;
    second.states.erase(second.states.begin(), second.states.begin() + 20);
    tracks.objects[0].states.resize(20);
    tracks.objects.push_back(second);
  });
  const json result = run();
  EXPECT_EQ(result["objects"][0]["id_switches"], 1);
  EXPECT_EQ(result["objects"][0]["matched_id"], 10);
  EXPECT_NEAR(result["objects"][0]["coverage"], 20.0 / kFrames, 1e-15);
  EXPECT_EQ(result["tracking"]["unmatched_ids"], json::array({40}));
  EXPECT_NEAR(result["tracking"]["mota"], 89.0 / 90, 1e-12);
  EXPECT_NEAR(result["tracking"]["idf1"], 80.0 / 90, 1e-12);
  // HOTA by hand: all detected; association 20/30 and 10/30 for the broken track's parts
  EXPECT_NEAR(result["tracking"]["hota"], std::sqrt((20 * 20.0 / 30 + 10 * 10.0 / 30 + 60) / 90), 1e-12);
}

TEST_F(Evaluate, FramesCsvHasARowForEachTruthFrameAndObject) {
  write_changed([](Tracks& tracks) { tracks.objects.pop_back(); });
  run();
  int rows = 0, empty = 0;
  std::size_t columns = 0;
  for_each_line(
      root_ / "out" / "frames.csv",
      [&](int line, const auto& fields) {
        if (line == 1) columns = fields.size();
        EXPECT_EQ(fields.size(), columns) << line;
        if (line == 1) return;
        ++rows;
        if (fields[2] == "3" && fields[4].empty() && fields[5].empty()) ++empty;
      },
      ',');
  EXPECT_EQ(rows, 3 * kFrames);
  EXPECT_EQ(empty, kFrames);
}

TEST_F(Evaluate, TimingAndRunAreCarriedOver) {
  write_changed([](Tracks&) {});
  write_text(estimate() / "timing.csv", "frame,stage,ms\n0,fit,2\n0,read,1\n1,fit,4\n1,read,1\n");
  write_text(estimate() / "run.yaml", "seed: 5\nvariant: {name: rotbbox, window: 8}\n");
  const json result = run();
  EXPECT_EQ(result["seed"], 5);
  EXPECT_EQ(result["config"]["estimate"]["variant"]["window"], 8);
  EXPECT_EQ(result["timing_ms"]["fit"]["mean"], 3);
  EXPECT_EQ(result["timing_ms"]["frame"]["mean"], 4);
}

// A stage that runs twice in one frame and in the next not at all.
TEST_F(Evaluate, TimesAreThoseOfAFrame) {
  write_changed([](Tracks&) {});
  write_text(estimate() / "timing.csv", "frame,stage,ms\n0,fit,2\n0,fit,4\n0,read,1\n1,read,3\n");
  const json timing = run()["timing_ms"];
  EXPECT_EQ(timing["fit"]["mean"], 3);
  EXPECT_EQ(timing["fit"]["max"], 6);
  for (const char* stage : {"fit", "read", "frame"}) EXPECT_EQ(timing[stage]["n"], 2) << stage;
  EXPECT_EQ(timing["frame"]["mean"], 5);
}

}  // namespace
}  // namespace uniquadric
