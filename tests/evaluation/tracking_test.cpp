// Figures of tracking and of motion, worked by hand.
#include <cmath>
#include <numbers>

#include "tests/evaluation/evaluate_fixture.h"

namespace uniquadric {
namespace {

// The balls' overlap is the cube of the ratio of their radii; the estimate keeps the ball alone.
class OneBall : public Evaluate {
 protected:
  void write_scaled(const std::function<double(int)>& ratio) {
    write_objects_yaml(truth() / "objects.yaml", {kObjects[2]});
    write_changed([&](Tracks& tracks) {
      auto& states = tracks.objects[0].states;
      for (std::size_t i = 0; i < states.size(); ++i)
        states[i].ellipsoid.semi_axes_m *= ratio(static_cast<int>(i));
    });
  }
};

// IoU 0.729 reaches 14 of the 19 thresholds 0.05 ... 0.95: there DetA = AssA = 1, beyond both are 0.
TEST_F(OneBall, HotaCountsTheThresholdsThatAreReached) {
  write_scaled([](int) { return 0.9; });
  const json tracking = run()["tracking"];
  EXPECT_NEAR(tracking["hota"], 14.0 / 19, 1e-12);
  EXPECT_NEAR(tracking["mota"], 1, 1e-12);
  EXPECT_NEAR(tracking["idf1"], 1, 1e-12);
}

// IoU 0.343 reaches 6 thresholds; at 0.5 each frame is a miss and a false track.
TEST_F(OneBall, BelowOneHalfIsAMissAndAFalseTrack) {
  write_scaled([](int) { return 0.7; });
  const json tracking = run()["tracking"];
  EXPECT_NEAR(tracking["hota"], 6.0 / 19, 1e-12);
  EXPECT_NEAR(tracking["mota"], -1, 1e-12);
  EXPECT_NEAR(tracking["idf1"], 0, 1e-12);
}

// 20 frames at 0.729, 10 at 0.343. Up to 0.30: all 30 match, HOTA 1. From 0.35 to 0.70 (8 thresholds): TP 20,
// DetA = 20 / (30 + 30 - 20), AssA = 20 / (30 + 30 - 20), HOTA 1/2. At 0.5: 20 hits, 10 misses, 10 false;
// MOTA (20 - 10) / 30.
TEST_F(OneBall, HotaOfATrackThatIsGoodInTwoThirdsOfTheFrames) {
  write_scaled([](int i) { return i < 20 ? 0.9 : 0.7; });
  const json tracking = run()["tracking"];
  EXPECT_NEAR(tracking["hota"], (6 + 8 * 0.5) / 19, 1e-12);
  EXPECT_NEAR(tracking["mota"], 1.0 / 3, 1e-12);
  EXPECT_NEAR(tracking["idf1"], 2 * 20.0 / 60, 1e-12);
}

// Two tracks swap the cube and the ball after 10 of 30 frames. All is found, each object's tracks hold 10 and
// 20 frames. AssA: a pair of n common frames has n / (30 + 30 - n); of 60 hits 2 * 10 are in pairs of 10, 2 *
// 20 in pairs of 20.
TEST_F(Evaluate, SwappedTracks) {
  write_changed([](Tracks& tracks) {
    for (int i = 10; i < kFrames; ++i)
      std::swap(tracks.objects[1].states[i].ellipsoid, tracks.objects[2].states[i].ellipsoid);
    tracks.objects.erase(tracks.objects.begin());
  });
  write_objects_yaml(truth() / "objects.yaml", {kObjects[1], kObjects[2]});
  const json result = run();
  const double association = (20 * 10.0 / 50 + 40 * 20.0 / 40) / 60;
  EXPECT_NEAR(result["tracking"]["hota"], std::sqrt(association), 1e-12);
  EXPECT_NEAR(result["tracking"]["mota"], 58.0 / 60, 1e-12);
  EXPECT_NEAR(result["tracking"]["idf1"], 40.0 / 60, 1e-12);
  for (const json& object : result["objects"]) EXPECT_EQ(object["id_switches"], 1);
}

// A false track of 12 frames beside three perfect ones, far from everything.
TEST_F(Evaluate, AFalseTrackCounts) {
  write_changed([](Tracks& tracks) {
    ObjectTrack ghost = tracks.objects[0];
    ghost.id = 40;
    ghost.states.resize(12);
    for (ObjectState& state : ghost.states) state.ellipsoid.world_from_object.translation.x() += 100;
    tracks.objects.push_back(ghost);
  });
  const json result = run();
  EXPECT_NEAR(result["tracking"]["mota"], (90.0 - 12) / 90, 1e-12);
  EXPECT_NEAR(result["tracking"]["idf1"], 2 * 90.0 / (90 + 102), 1e-12);
  EXPECT_NEAR(result["tracking"]["hota"], std::sqrt(90.0 / 102), 1e-12);
  EXPECT_EQ(result["tracking"]["unmatched_ids"], json::array({40}));
  EXPECT_EQ(result["tracking"]["false_bodies"], 1);
}

class FalseBodies : public Evaluate {
 protected:
  // The three true tracks and a ghost of twelve states far off, all of `status` but the last, of `last`.
  void write_ghost(ObjectStatus status, ObjectStatus last) {
    write_changed([&](Tracks& tracks) {
      ObjectTrack ghost = tracks.objects[0];
      ghost.id = 40;
      ghost.states.resize(12);
      for (ObjectState& state : ghost.states) {
        state.ellipsoid.world_from_object.translation.x() += 100;
        state.status = status;
      }
      ghost.states.back().status = last;
      tracks.objects.push_back(ghost);
    });
  }
  void remove_true_objects() {
    write_objects_yaml(truth() / "objects.yaml", {});
    for (const auto& object : kObjects)
      fs::remove(truth() / "objects" / (std::to_string(object.id) + ".tum"));
  }
  json false_bodies() { return run()["tracking"]["false_bodies"]; }
};

TEST_F(FalseBodies, AreTracksThatTheEstimateStandsBy) {
  using enum ObjectStatus;
  write_ghost(tentative, tentative);
  const json tracking = run()["tracking"];
  EXPECT_EQ(tracking["unmatched_ids"], json::array({40}));
  EXPECT_EQ(tracking["false_bodies"], 0);
  for (const ObjectStatus last : {active, occluded}) {
    write_ghost(tentative, last);
    EXPECT_EQ(false_bodies(), 1) << to_string(last);
  }
}

TEST_F(FalseBodies, AreAllTracksOfASceneWithoutObjects) {
  using enum ObjectStatus;
  write_ghost(active, active);
  remove_true_objects();
  const json result = run();
  EXPECT_EQ(result["tracking"]["false_bodies"], 4);
  EXPECT_TRUE(result["objects"].empty());
  write_truth();
  write_ghost(tentative, tentative);
  remove_true_objects();
  EXPECT_EQ(false_bodies(), 3);
  fs::remove_all(estimate());
  write_changed([](Tracks& tracks) { tracks.objects.clear(); });
  EXPECT_EQ(false_bodies(), 0);
}

TEST_F(FalseBodies, AreNotCountedWhereTheTruthDoesNotNameAll) {
  write_ghost(ObjectStatus::active, ObjectStatus::active);
  const std::string yaml = read_text(truth() / "objects.yaml");
  write_text(truth() / "objects.yaml", yaml + "labels: partial\n");
  EXPECT_TRUE(false_bodies().is_null());
  write_text(truth() / "objects.yaml", yaml);
  EXPECT_EQ(false_bodies(), 1);
  remove_true_objects();
  fs::remove(truth() / "objects.yaml");  // no truth of objects at all
  EXPECT_TRUE(false_bodies().is_null());
}

// Of an estimate at twice the truth's rate, through a hole of the truth, every other state is at a frame, or
// none: what is at no frame is neither hit nor false.
TEST_F(Evaluate, StatesBetweenTheTruthsFramesAreNoFalseTracks) {
  const auto double_rate = [](Tracks& tracks) {
    for (ObjectTrack& track : tracks.objects) {
      std::vector<ObjectState> twice;
      for (ObjectState state : track.states)
        for (const std::int64_t later_ns : {std::int64_t{0}, kPeriodNs / 2}) {
          state.frame = std::ssize(twice);
          twice.push_back(state);
          twice.back().stamp_ns += later_ns;
        }
      track.states = twice;
    }
  };
  write_changed(double_rate);
  const auto expect_perfect = [&] {
    const json tracking = run()["tracking"];
    for (const char* key : {"hota", "mota", "idf1"}) EXPECT_NEAR(tracking[key], 1, 1e-12) << key;
  };
  expect_perfect();
  write_hole_in_truth(10, 15);
  expect_perfect();
}

// The camera's frames are the truth's, in those without an object too: what is seen there is false.
TEST_F(Evaluate, AStateAtAFrameWithoutObjectsIsFalse) {
  write_changed([](Tracks&) {});
  for (const auto& object : kObjects) {
    const fs::path file = truth() / "objects" / (std::to_string(object.id) + ".tum");
    Trajectory poses = read_tum(file);
    poses.resize(20);
    write_tum(file, poses);
  }
  EXPECT_NEAR(run()["tracking"]["mota"], (60.0 - 30) / 60, 1e-12);
}

// A body frame 0.05 m beside the true one: its own error, none of the motion.
TEST_F(Evaluate, ABodyOffsetIsNoMotionError) {
  write_changed([](Tracks& tracks) {
    const Pose offset = {exp_so3({0.1, 0.2, 0}), Eigen::Vector3d(0.03, 0, 0.04)};
    for (ObjectState& state : tracks.objects[0].states)
      state.ellipsoid.world_from_object = state.ellipsoid.world_from_object * offset;
  });
  const json cuboid = run()["objects"][0];
  EXPECT_NEAR(cuboid["ape"]["translation_m"]["rmse"], 0.05, kRounding);
  EXPECT_NEAR(cuboid["ape"]["rotation_rad"]["rmse"], std::hypot(0.1, 0.2), kRounding);
  for (const char* part : {"translation_m", "rotation_rad"})
    EXPECT_NEAR(cuboid["motion_error"][part]["max"], 0, kRounding) << part;
  EXPECT_GT(cuboid["rpe"]["translation_m"]["max"], 1e-4);  // which is not free of it
}

// Each step slips by 2 mm along the body's x and turns by 1 mrad too much: every relative figure is that, the
// drift what adds up over 29 steps.
TEST_F(Evaluate, DriftAddsUp) {
  write_changed([](Tracks& tracks) {
    auto& states = tracks.objects[0].states;
    const std::vector<ObjectState> truth = states;
    for (std::size_t i = 1; i < states.size(); ++i) {
      const Pose step =
          relative_pose(truth[i - 1].ellipsoid.world_from_object, truth[i].ellipsoid.world_from_object);
      const Pose slip = {exp_so3({0.001, 0, 0}), Eigen::Vector3d(0.002, 0, 0)};
      states[i].ellipsoid.world_from_object = states[i - 1].ellipsoid.world_from_object * step * slip;
    }
  });
  const json cuboid = run()["objects"][0];
  EXPECT_NEAR(cuboid["rpe"]["translation_m"]["rmse"], 0.002, kRounding);
  EXPECT_NEAR(cuboid["rpe"]["rotation_rad"]["rmse"], 0.001, kRounding);
  EXPECT_NEAR(cuboid["motion_error"]["translation_m"]["mean"], 0.002, 1e-3);
  EXPECT_EQ(cuboid["drift"]["alignment"], "first");
  EXPECT_NEAR(cuboid["drift"]["max_translation_m"], 29 * 0.002, 0.01);
  EXPECT_NEAR(cuboid["drift"]["max_angle_deg"].get<double>() * std::numbers::pi / 180, 29 * 0.001, 3e-3);
  EXPECT_EQ(cuboid["ape"]["translation_m"]["min"], 0);
}

}  // namespace
}  // namespace uniquadric
