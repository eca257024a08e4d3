// What evaluate refuses or warns of, by file and line.

#include "core/base/error.h"
#include "evaluation/evaluate.h"
#include "evaluation/run_record.h"
#include "tests/evaluation/evaluate_fixture.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

// Only what says of both sides that they are of two scenes is refused.
TEST_F(Evaluate, AnEstimateOfAnotherSceneIsRefused) {
  write_changed([](Tracks&) {});
  const auto evaluate_of = [&](const std::string& truth_hash, const std::string& run_yaml) {
    write_objects_yaml(truth() / "objects.yaml", kObjects, truth_hash);
    write_text(estimate() / "run.yaml", run_yaml);
    run();
  };
  const std::string message = input_error([&] { evaluate_of("123e4567", "scene_hash: \"123e4568\"\n"); });
  EXPECT_EQ(message, estimate().string() + ": is of another scene: its scene_hash is 123e4568, that of " +
                         truth().string() + " is 123e4567");
  EXPECT_FALSE(fs::exists(root_ / "out"));
  EXPECT_NO_THROW(evaluate_of("123e4567", "scene_hash: \"123e4567\"\n"));
  EXPECT_NO_THROW(evaluate_of("123e4567", "sequence: other\n"));
  EXPECT_NO_THROW(evaluate_of("123e4567", "[a, list]\n"));
  EXPECT_NO_THROW(evaluate_of("", "scene_hash: \"123e4568\"\n"));
  write_objects_yaml(truth() / "objects.yaml", kObjects, "123e4567");
  const fs::path other = root_ / "other";
  fs::copy(truth(), other, fs::copy_options::recursive);
  EXPECT_NO_THROW(run(truth(), other));  // a truth for an estimate
  write_objects_yaml(other / "objects.yaml", kObjects, "123e4568");
  EXPECT_THROW(run(truth(), other), InputError);
}

// What `evaluate` says on stderr of an estimate that was moved in time, or numbered otherwise.
TEST_F(Evaluate, StampsThatDoNotFitTheTruthsFramesAreNamed) {
  const auto said = [&](const std::function<void(Tracks&)>& change) {
    write_changed(change);
    testing::internal::CaptureStderr();
    run();
    return testing::internal::GetCapturedStderr();
  };
  const auto warning = [&](const std::string& file, const std::string& what) {
    return "warning: " + (estimate() / file).string() + ": " + what + "\n";
  };
  const auto shift = [](ObjectTrack& object, std::int64_t by_ns) {
    for (auto& state : object.states) state.stamp_ns += by_ns;
  };
  const std::string
      near =
          " from the truth's frames (median), and are compared with the nearest; a shifted clock "
          "moves every error",
      far = " stamps lie more than 10 ms from every frame of the truth, and are compared with none";
  write_objects_yaml(truth() / "objects.yaml", kObjects, "a_scene");
  EXPECT_EQ(said([](Tracks&) {}), "");
  EXPECT_EQ(said([&](Tracks& tracks) { shift(tracks.objects[0], 100'000); }), "");  // rounded
  EXPECT_EQ(said([&](Tracks& tracks) { shift(tracks.objects[1], kPeriodNs / 2); }),
            warning("objects/20.tum", "30 of 30" + far));
  EXPECT_EQ(said([&](Tracks& tracks) { tracks.objects[2].states.back().stamp_ns += 20'000'000; }),
            warning("objects/30.tum", "1 of 30" + far));
  EXPECT_EQ(
      said([&](Tracks& tracks) {
        for (auto& pose : tracks.camera) pose.stamp_ns += 8'000'000;
        shift(tracks.objects[0], -8'000'000);
      }),
      warning("camera.tum", "stamps lie 8 ms" + near) + warning("objects/10.tum", "stamps lie 8 ms" + near));
  for (const std::size_t poses : {0, 1, 2})
    EXPECT_EQ(
        said([&](Tracks& tracks) { tracks.camera.resize(poses); }),
        warning("camera.tum", "holds " + std::to_string(poses) +
                                  " of the 3 poses that the camera's errors and an alignment need at "
                                  "least; objects are compared where they stand in the estimate's world"));
  const auto from_1 = [](Tracks& tracks) {
    for (auto& state : tracks.objects[1].states) ++state.frame;
  };
  EXPECT_EQ(said(from_1),
            warning("objects.csv",
                    "the frame of 30 of 90 rows is not the truth's at their stamp (object 20 at "
                    "0.000000000 s: frame 1, which is the truth's 0); rows are compared by their stamps"));
  write_objects_yaml(truth() / "objects.yaml", kObjects);  // a recording's truth may have holes
  EXPECT_EQ(said(from_1), "");
  EXPECT_EQ(said([&](Tracks& tracks) {
              auto& states = tracks.objects[2].states;
              states.back().frame += 1;
              states.insert(states.end() - 1, states[kFrames - 2]);
              states[kFrames - 1].frame += 1;
              states[kFrames - 1].stamp_ns += 5'000'000;
            }),
            warning("objects/30.tum",
                    "1 of 31 stamps lie beside another that is nearer to the truth's frame, and are "
                    "compared with none"));
}

TEST(RunRecord, SaysWhetherPosesWereGivenWhateverItHolds) {
  for (const char* given :
       {R"({"variant": {"ego": "given"}})", R"({"variant": {"ego": {"source": "given"}}})"})
    EXPECT_TRUE(camera_was_given(given)) << given;
  for (const char* other :
       {"null", "[]", "{}", R"({"variant": [1]})", R"({"variant": {"ego": [1]}})", R"({"variant": "given"})"})
    EXPECT_FALSE(camera_was_given(other)) << other;
}

TEST_F(Evaluate, RefusesBadInputAndWritesNothing) {
  write_changed([](Tracks& tracks) {
    for (auto& state : tracks.camera) state.stamp_ns += 1'000'000'000'000;  // of another day
  });
  EXPECT_THROW(run(), InputError);
  write_changed([](Tracks&) {});
  write_text(estimate() / "timing.csv", "frame,stage,ms\n0,fit,fast\n");
  EXPECT_THROW(run(), InputError);
  EXPECT_THROW(run(root_ / "absent", estimate()), InputError);
  EXPECT_FALSE(fs::exists(root_ / "out"));
  EXPECT_FALSE(fs::exists(root_ / "out.partial"));
}

TEST_F(Evaluate, StatesBeyondAnyWorldAreRefusedByFileAndLine) {
  write_changed([](Tracks& tracks) {
    tracks.objects[1].states[6].ellipsoid.world_from_object.translation.x() = 1e308;
  });
  const std::string message = input_error([&] { run(); });
  EXPECT_NE(message.find("20.tum:8: '1e+308' is further than"), std::string::npos) << message;
  EXPECT_FALSE(fs::exists(root_ / "out"));
}

// What is just let in gives figures, and no file says that one is not finite.
TEST_F(Evaluate, OfTheFarthestAndLargestStatesAllFiguresAreFinite) {
  for (const bool camera_too : {false, true}) {
    write_changed([&](Tracks& tracks) {
      if (camera_too) tracks.camera[3].pose.translation.y() = -kMostCoordinate_m;
      for (auto& state : tracks.objects[1].states) state.ellipsoid.semi_axes_m = {1, 1e3, 1e6};
      for (auto& state : tracks.objects[2].states) state.ellipsoid.semi_axes_m = {1e-9, 1e-6, 1e-3};
      tracks.objects[0].states[6].ellipsoid.world_from_object.translation.x() = kMostCoordinate_m;
    });
    const json result = run();
    const json& far = camera_too ? result["camera"] : result["objects"][0];
    EXPECT_GT(far["ape"]["translation_m"]["max"], 0.4 * kMostCoordinate_m);
    for (const char* file : {"frames.csv", "poses.csv"}) {
      const std::string text = read_text(root_ / "out" / file);
      for (const char* bad : {",inf", ",-inf", ",nan", ",-nan"})
        EXPECT_EQ(text.find(bad), std::string::npos) << file << bad;
    }
  }
}

}  // namespace
}  // namespace uniquadric
