#include "evaluation/association/object_choice.h"

#include <gtest/gtest.h>

#include "evaluation/association/tracking_scores.h"
#include "evaluation/object_presence.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

constexpr std::int64_t kFrame_ns = 100'000'000;

// A box of 1 m whose centre is at (x, y) + frame * step, in frames `first` to `last`.
ObjectTrack moving(int id, const std::string& name, double x, double y, double step_m, int first = 0,
                   int last = 9) {
  ObjectTrack track{id, name, {}};
  for (int frame = first; frame <= last; ++frame) {
    ObjectState& state = track.states.emplace_back();
    state.frame = frame;
    state.stamp_ns = frame * kFrame_ns;
    state.ellipsoid.semi_axes_m = {0.5, 0.5, 0.5};
    state.ellipsoid.world_from_object.translation = {x + step_m * frame, y, 0};
  }
  return track;
}

std::optional<TrackingScores> scores(const std::vector<ObjectTrack>& truth,
                                     const std::vector<ObjectTrack>& estimate, Unlabelled unlabelled,
                                     bool labels_are_partial) {
  Tracks t, e;
  t.objects = truth, e.objects = estimate;
  ObjectOverlaps overlaps = overlap_objects(t, e, kFrame_ns / 4);
  drop_unlabelled(unlabelled, labels_are_partial, match_objects(overlaps), overlaps);
  return tracking_scores(overlaps);
}

TEST(ObjectChoice, ReadsBackAsItWasWritten) {
  for (const char* text : {"all", "moving", "moving,in_view", "car,cyclist", "moving,in_view,car"})
    EXPECT_EQ(to_string(parse_object_choice(text)), text);
  EXPECT_EQ(parse_object_choice("labelled"), ObjectChoice{});
  EXPECT_EQ(parse_object_choice("Car_7").classes, std::vector<std::string>{"car"});
  EXPECT_THROW(parse_object_choice("moving,,car"), InputError);
}

TEST(ObjectChoice, AClassIsANameWithoutItsNumber) {
  EXPECT_EQ(class_of("car_12"), "car");
  EXPECT_EQ(class_of("Traffic_cone_3"), "traffic_cone");
  EXPECT_EQ(class_of("cube"), "cube");
  EXPECT_EQ(class_of("box_a"), "box_a");
}

// A label's jitter is no motion: farther than the smallest side is.
TEST(ObjectChoice, MovingIsWhatLeavesItsPlace) {
  const std::vector<ObjectTrack> truth = {moving(1, "car_1", 0, 0, 0.2), moving(2, "car_2", 9, 0, 0.1),
                                          moving(3, "van_3", 0, 9, 0.2)};
  EXPECT_EQ(scored_objects(truth, parse_object_choice("all")), (std::vector<bool>{true, true, true}));
  EXPECT_EQ(scored_objects(truth, parse_object_choice("moving")), (std::vector<bool>{true, false, true}));
  EXPECT_EQ(scored_objects(truth, parse_object_choice("moving,car")),
            (std::vector<bool>{true, false, false}));
}

// A right track with a second one where no label is: half of all states are false, or nobody knows.
TEST(Unlabelled, StatesOfNoLabelAreFalseOrIgnored) {
  const std::vector<ObjectTrack> truth = {moving(1, "car_1", 0, 0, 0.2)};
  const std::vector<ObjectTrack> estimate = {moving(5, "", 0, 0, 0.2), moving(6, "", 30, 0, 0)};
  EXPECT_EQ(scores(truth, estimate, Unlabelled::counted_false, true)->mota, 0);
  EXPECT_EQ(scores(truth, estimate, Unlabelled::ignored, false)->mota, 1);
}

// Followed on after its labels ended: not scored as present, whatever other states are.
TEST(Unlabelled, ATrackAfterItsObjectLeftIsNotFalse) {
  const std::vector<ObjectTrack> truth = {moving(1, "car_1", 0, 0, 0.2, 0, 4),
                                          moving(2, "car_2", 30, 0, 0.2)};
  const std::vector<ObjectTrack> estimate = {moving(5, "", 0, 0, 0.2), moving(6, "", 30, 0, 0.2)};
  EXPECT_EQ(scores(truth, estimate, Unlabelled::counted_false, true)->mota, 1);
  EXPECT_LT(scores(truth, estimate, Unlabelled::counted_false, false)->mota, 1);
}

TEST(Unlabelled, InViewLeavesOutStatesThatNobodyCanSee) {
  VisibilityTable visibility;
  visibility[{3, 1}].visible_fraction = 0;
  const auto seen = only_in_view({moving(1, "car_1", 0, 0, 0.2)}, visibility);
  ASSERT_EQ(seen[0].states.size(), 9u);
  EXPECT_EQ(seen[0].states[3].frame, 4);
}

}  // namespace
}  // namespace uniquadric
