// Objects that the truth shows and does not score.
#include "tests/evaluation/evaluate_fixture.h"

namespace uniquadric {
namespace {

class Unscored : public Evaluate {
 protected:
  // The cube (2) is there and not scored, as a hand is that holds a thing.
  void leave_out_cube() {
    std::vector<ObjectDescription> objects = kObjects;
    objects[1].is_scored = false;
    write_objects_yaml(truth() / "objects.yaml", objects);
  }
  static std::vector<int> ids(const json& result) {
    std::vector<int> ids;
    for (const json& object : result["objects"]) ids.push_back(object["id"]);
    return ids;
  }
  static void expect_perfect(const json& result) {
    EXPECT_EQ(ids(result), (std::vector{1, 3}));
    for (const json& object : result["objects"]) EXPECT_EQ(object["ape"]["translation_m"]["max"], 0);
    for (const char* key : {"hota", "mota", "idf1"}) EXPECT_NEAR(result["tracking"][key], 1, 1e-12) << key;
    EXPECT_EQ(result["tracking"]["false_bodies"], 0);
    EXPECT_EQ(result["tracking"]["unmatched_ids"], json::array());
    EXPECT_EQ(result["estimated_objects"].size(), 2u);
  }
};

TEST_F(Unscored, ATrackOfItIsNeitherScoredNorFalse) {
  write_changed([](Tracks&) {});
  leave_out_cube();
  expect_perfect(run());
}

// The same track is a false body where the truth does not have the object at all.
TEST_F(Unscored, WithoutTheObjectItsTrackIsFalse) {
  write_changed([](Tracks&) {});
  write_objects_yaml(truth() / "objects.yaml", {kObjects[0], kObjects[2]});
  const json result = run();
  EXPECT_EQ(ids(result), (std::vector{1, 3}));
  EXPECT_EQ(result["tracking"]["false_bodies"], 1);
}

TEST_F(Unscored, ItIsNotMissed) {
  write_changed([](Tracks& tracks) { tracks.objects.erase(tracks.objects.begin() + 1); });
  leave_out_cube();
  expect_perfect(run());
}

TEST_F(Unscored, TheTruthAgainstItselfIsPerfect) {
  leave_out_cube();
  expect_perfect(run(truth(), truth()));
}

// Its track ends and another one, which overlaps it in all frames, goes on: both belong to it.
TEST_F(Unscored, NorIsASecondTrackOfItFalse) {
  write_changed([](Tracks& tracks) {
    ObjectTrack again = tracks.objects[1];
    again.id = 40;
    for (ObjectState& state : again.states) state.ellipsoid.semi_axes_m *= 0.9;
    tracks.objects[1].states.resize(20);
    tracks.objects.push_back(again);
  });
  leave_out_cube();
  expect_perfect(run());
}

// A second track of what is scored stays false, also where the two objects touch.
TEST_F(Unscored, ASecondTrackOfAScoredObjectIsFalse) {
  write_changed([](Tracks& tracks) {
    ObjectTrack again = tracks.objects[0];
    again.id = 40;
    for (ObjectState& state : again.states) {
      state.ellipsoid.semi_axes_m.setConstant(0.7);  // reaches the cube beside it
      state.ellipsoid.world_from_object.translation.x() -= 0.2;
    }
    tracks.objects.push_back(again);
  });
  leave_out_cube();
  const json tracking = run()["tracking"];
  EXPECT_EQ(tracking["unmatched_ids"], json::array({40}));
  EXPECT_EQ(tracking["false_bodies"], 1);
  EXPECT_NEAR(tracking["mota"], (60.0 - 30) / 60, 1e-12);
}

// The camera's figures remain of a scene that has nothing to score.
TEST_F(Unscored, ASceneOfUnscoredObjectsAloneHasNoRow) {
  write_changed([](Tracks&) {});
  std::vector<ObjectDescription> objects = kObjects;
  for (ObjectDescription& object : objects) object.is_scored = false;
  write_objects_yaml(truth() / "objects.yaml", objects);
  const json result = run();
  EXPECT_TRUE(result["objects"].empty());
  EXPECT_TRUE(result["tracking"]["hota"].is_null());
  EXPECT_EQ(result["tracking"]["false_bodies"], 0);
}

}  // namespace
}  // namespace uniquadric
