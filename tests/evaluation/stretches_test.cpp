// Axes are renamed a stretch of states at a time.
#include "evaluation/stretches.h"

#include <cmath>
#include <numbers>

#include "evaluation/align/shape_symmetry.h"
#include "evaluation/trajectory/pose_error.h"
#include "tests/evaluation/evaluate_fixture.h"
#include "tests/evaluation/visibility_fixture.h"

namespace uniquadric {
namespace {

using std::numbers::pi;
constexpr ShapeSymmetry kBox{BodySymmetry::box, 2}, kRound{BodySymmetry::revolution, 2},
    kSphere{BodySymmetry::sphere, 2}, kNone{BodySymmetry::none, 2};
constexpr double kTurned = 1e-7;  // rad: angles of products of rotations, near zero

TEST(Stretches, EndAtHolesAndWhereTheObjectIsHidden) {
  const StretchFrame seen{true, false, false}, hidden{true, true, false}, lost{}, after{true, false, true};
  using Starts = std::vector<std::size_t>;
  EXPECT_EQ(later_stretch_starts({}), Starts{});
  EXPECT_EQ(later_stretch_starts({seen, seen, seen}), Starts{});
  EXPECT_EQ(later_stretch_starts({lost, seen, seen, lost}), Starts{});
  EXPECT_EQ(later_stretch_starts({seen, lost, lost, seen, seen, lost, seen}), (Starts{1, 3}));
  EXPECT_EQ(later_stretch_starts({seen, hidden, hidden, seen, seen}), (Starts{1, 3}));
  EXPECT_EQ(later_stretch_starts({seen, seen, after, seen}), Starts{2});
}

TEST(Stretches, AReportedOcclusionCountsUnlessTheTruthSeesTheObject) {
  std::vector<ObjectFrame> frames(4);
  for (int i = 0; i < 4; ++i) frames[i].frame = 2 * i;
  frames[1].visible_fraction = 0.5;
  frames[2].visible_fraction = 0.4;
  frames[3].visible = false;
  const std::vector<std::optional<ObjectStatus>> statuses(4, ObjectStatus::occluded);
  // A row between frames 2 and 4 says that nothing is seen of object 7, one between 4 and 6 of another.
  const VisibilityTable table = {{{3, 7}, {0, 100, 0, false}}, {{5, 8}, {0, 100, 0, false}}};
  const auto found = stretch_frames(7, frames, statuses, table);
  ASSERT_EQ(found.size(), 4u);
  const std::vector<bool> hidden = {true, false, true, true}, before = {false, false, true, false};
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(found[i].has_state) << i;
    EXPECT_EQ(found[i].is_hidden, hidden[i]) << i;
    EXPECT_EQ(found[i].was_hidden_before, before[i]) << i;
  }
}

std::vector<Ellipsoid> turning(const Eigen::Vector3d& semi_axes_m, int frames) {
  std::vector<Ellipsoid> track;
  for (int i = 0; i < frames; ++i)
    track.push_back({{exp_so3({0.03 * i, 0.2, 0.1 * i}), {0.1 * i, 0, 2}}, semi_axes_m});
  return track;
}

// Errors [rad] of an estimate whose own frame is turned by turn(i) in frame i.
std::vector<double> errors_rad(const ShapeSymmetry& symmetry, const std::vector<Ellipsoid>& truth,
                               const std::vector<std::size_t>& starts,
                               const std::function<Eigen::Quaterniond(std::size_t)>& turn) {
  std::vector<Ellipsoid> estimate = truth;
  for (std::size_t i = 0; i < truth.size(); ++i)
    estimate[i].world_from_object.rotation = truth[i].world_from_object.rotation * turn(i);
  const SettledTrack settled = settle_axes(symmetry, estimate, truth, starts);
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.size(); ++i)
    errors.push_back(absolute_angle_rad(truth[i].world_from_object, settled.estimate[i].world_from_object));
  return errors;
}

const Eigen::Quaterniond kSpun = exp_so3({0, 0, 1}), kUpsideDown = exp_so3({pi, 0, 0});

TEST(SettleStretches, ALongStretchFitsItsOwnFreeRotation) {
  const auto turn = [](std::size_t i) { return i < 10 ? kSpun : kSpun * kUpsideDown * exp_so3({0, 0, 2}); };
  for (const auto& [symmetry, axes] :
       {std::pair(kRound, Eigen::Vector3d(1, 1, 2)), std::pair(kSphere, Eigen::Vector3d(1, 1, 1))})
    for (const double error : errors_rad(symmetry, turning(axes, 20), {10}, turn)) EXPECT_LT(error, kTurned);
}

// Nine frames: the end is right, the spin of 1 rad since the longer stretch is charged.
TEST(SettleStretches, AShortStretchOfACanSettlesItsEndAlone) {
  const auto truth = turning({1, 1, 2}, 21);
  const auto after = errors_rad(kRound, truth, {12}, [](std::size_t i) {
    return i < 12 ? Eigen::Quaterniond::Identity() : kSpun * kUpsideDown;
  });
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_NEAR(after[i], i < 12 ? 0 : 1, kTurned) << i;
  const auto before = errors_rad(kRound, truth, {9}, [](std::size_t i) {
    return i >= 9 ? Eigen::Quaterniond::Identity() : kSpun * kUpsideDown;
  });
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_NEAR(before[i], i >= 9 ? 0 : 1, kTurned) << i;
}

TEST(SettleStretches, AShortStretchTakesTheTurnOfTheLongerOne) {
  const auto same = [](std::size_t) { return kSpun; };
  for (const std::vector<std::size_t>& starts :
       {std::vector<std::size_t>{16}, {4}, {4, 16}, {3, 6, 9, 12, 15, 18}})
    for (const double error : errors_rad(kRound, turning({1, 1, 2}, 20), starts, same))
      EXPECT_LT(error, kTurned) << starts.size();
  const auto ball = errors_rad(kSphere, turning({1, 1, 1}, 20), {15}, [](std::size_t i) {
    return i < 15 ? kUpsideDown : kUpsideDown * exp_so3({0.3, 0.4, 0});
  });
  for (std::size_t i = 0; i < 20; ++i) EXPECT_NEAR(ball[i], i < 15 ? 0 : 0.5, kTurned) << i;
}

TEST(SettleStretches, ABoxIsRenamedAStretchAtATime) {
  const auto half = [](std::size_t i) {
    return i < 17 ? Eigen::Quaterniond::Identity() : Eigen::Quaterniond(0, 1, 0, 0);
  };
  const auto truth = turning({3, 2, 1}, 20);
  for (const double error : errors_rad(kBox, truth, {17}, half)) EXPECT_LT(error, kTurned);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_NEAR(errors_rad(kBox, truth, {}, half)[i], i < 17 ? 0 : pi, kTurned) << i;
    EXPECT_NEAR(errors_rad(kNone, truth, {17}, half)[i], i < 17 ? 0 : pi, kTurned) << i;
    const auto tilted = [](std::size_t k) { return exp_so3({0, k < 17 ? 0 : 0.5, 0}); };
    EXPECT_NEAR(errors_rad(kBox, truth, {17}, tilted)[i], i < 17 ? 0 : 0.5, kTurned) << i;
  }
}

TEST(SettleStretches, FlipsAreCountedAgainstTheStretch) {
  const auto truth = turning({1, 1, 1}, 20);
  auto estimate = truth;
  for (std::size_t i = 8; i < 20; ++i)
    estimate[i].world_from_object.rotation = truth[i].world_from_object.rotation * exp_so3({0, 0, pi / 2});
  EXPECT_EQ(settle_axes(kBox, estimate, truth).relabel_flips, 8);
  EXPECT_EQ(settle_axes(kBox, estimate, truth, {8}).relabel_flips, 0);
  EXPECT_EQ(settle_axes(kBox, estimate, truth, {5}).relabel_flips, 3);
}

// One object of the cuboid's poses, whose estimate comes back turned from frame 15 on.
class ComesBack : public VisibilityFixture {
 protected:
  static constexpr int kGone = 10, kBack = 15;

  void write_object(const std::string& shape, const Eigen::Vector3d& semi_axes_m,
                    const Eigen::Quaterniond& turn, const std::function<void(Tracks&)>& change) {
    write_objects_yaml(truth() / "objects.yaml", {{1, "Thing", semi_axes_m, shape, ""}});
    write_changed([&](Tracks& tracks) {
      tracks.objects.resize(1);
      auto& states = tracks.objects[0].states;
      for (ObjectState& state : states) {
        state.ellipsoid.semi_axes_m = semi_axes_m;
        Eigen::Quaterniond& q = state.ellipsoid.world_from_object.rotation;
        if (state.frame >= kBack) q = q * turn;
      }
      change(tracks);
    });
  }
  json thing() { return run()["objects"][0]; }

  static void lose(Tracks& tracks) {
    auto& states = tracks.objects[0].states;
    states.erase(states.begin() + kGone, states.begin() + kBack);
  }
  static void occlude(Tracks& tracks) {
    for (int i = kGone; i < kBack; ++i) tracks.objects[0].states[i].status = ObjectStatus::occluded;
  }
  static void keep(Tracks&) {}
};

// Turned end for end about some axis across the can, and about the can's own.
const Eigen::Quaterniond kTurnedCan = exp_so3({0, 0, 0.7}) * exp_so3({pi, 0, 0}) * exp_so3({0, 0, 0.2});
const Eigen::Vector3d kCan_m(0.1, 0.1, 0.2);

TEST_F(ComesBack, ACanThatWasLostMayComeBackEndForEnd) {
  write_object("cylinder", kCan_m, kTurnedCan, lose);
  const json can = thing();
  EXPECT_LT(can["ape"]["rotation_rad"]["max"], kRounding);
  EXPECT_NEAR(can["ape"]["rotation_naive_rad"]["max"], pi, kRounding);
  EXPECT_LT(can["rpe"]["rotation_rad"]["max"], kRounding);
  EXPECT_EQ(can["rpe"]["rotation_rad"]["n"], 23);
}

TEST_F(ComesBack, AFlipInFullViewIsCharged) {
  write_object("cylinder", kCan_m, kTurnedCan, keep);
  const json can = thing();
  EXPECT_NEAR(can["ape"]["rotation_rad"]["rmse"], pi * std::sqrt(0.5), kRounding);  // 15 of 30 frames
  EXPECT_NEAR(can["rpe"]["rotation_rad"]["max"], pi, kRounding);
  write_visibility([](int) { return View{}; });
  write_object("cylinder", kCan_m, kTurnedCan, occlude);  // whatever the estimate says of it
  EXPECT_NEAR(thing()["ape"]["rotation_rad"]["rmse"], pi * std::sqrt(0.5), kRounding);
}

// States go on while the object is hidden: the poses are right by their names, the turn is still a motion.
TEST_F(ComesBack, AFlipBehindAnOcclusionIsARelativeErrorOnce) {
  const auto expect_one = [&](const char* what) {
    const json can = thing();
    EXPECT_LT(can["ape"]["rotation_rad"]["max"], kRounding) << what;
    EXPECT_NEAR(can["rpe"]["rotation_rad"]["rmse"], pi / std::sqrt(29), kRounding) << what;
    EXPECT_NEAR(can["motion_error"]["rotation_rad"]["rmse"], pi / std::sqrt(29), kRounding) << what;
  };
  write_object("cylinder", kCan_m, kTurnedCan, occlude);
  expect_one("reported");
  write_visibility([](int i) { return i >= kGone && i < kBack ? View{0, 1000} : View{}; });
  write_object("cylinder", kCan_m, kTurnedCan, keep);
  expect_one("known to the truth");
}

// The free turns of the stretches differ by the noise of their first frames: no relative error comes of it.
TEST_F(ComesBack, NewNamesAreNoRelativeError) {
  write_visibility([](int i) { return i == kGone ? View{0, 1000} : View{}; });
  write_object("cylinder", kCan_m, Eigen::Quaterniond::Identity(), [](Tracks& tracks) {
    for (ObjectState& state : tracks.objects[0].states) {  // spins by 5 mrad a frame too much
      Eigen::Quaterniond& q = state.ellipsoid.world_from_object.rotation;
      q = q * exp_so3({0, 0, 0.005 * static_cast<double>(state.frame)});
    }
  });
  const json can = thing();
  constexpr double kTrueTurn_rad =
      5e-4;  // by which a step's error differs as the body turns; the fits by 0.05
  EXPECT_NEAR(can["rpe"]["rotation_rad"]["max"], 0.005, kTrueTurn_rad);
  EXPECT_NEAR(can["rpe"]["rotation_rad"]["min"], 0.005, kTrueTurn_rad);
  EXPECT_LT(can["ape"]["rotation_rad"]["max"], 0.075);  // of 29 steps: each stretch is settled by itself
}

TEST_F(ComesBack, WithTheHiddenFramesOutOfTheTruthToo) {
  write_visibility([](int i) { return i >= kGone && i < kBack ? View{0, 1000} : View{}; });
  write_object("cylinder", kCan_m, kTurnedCan, keep);
  EvaluateOptions options;
  options.iou_samples = 2000;
  options.force = true;
  options.objects.in_view = true;
  uniquadric::evaluate(truth(), estimate(), options, root_ / "out");
  const json can = json::parse(read_text(root_ / "out/evaluation.json"))["objects"][0];
  EXPECT_EQ(can["frames"], 25);
  EXPECT_LT(can["ape"]["rotation_rad"]["max"], kRounding);
}

TEST_F(ComesBack, ABoxMayComeBackAsItsSymmetrySays) {
  const Eigen::Quaterniond half = exp_so3({0, pi, 0});
  write_object("mesh", {0.3, 0.2, 0.1}, half, lose);
  EXPECT_LT(thing()["ape"]["rotation_rad"]["max"], kRounding);
  write_object("mesh", {0.3, 0.2, 0.1}, half * exp_so3({0, 0.5, 0}), lose);
  EXPECT_NEAR(thing()["ape"]["rotation_rad"]["max"], 0.5, kRounding);
  ObjectDescription unsymmetrical{1, "Thing", {0.3, 0.2, 0.1}, "mesh", ""};
  unsymmetrical.symmetry = BodySymmetry::none;
  write_object("mesh", {0.3, 0.2, 0.1}, half, lose);
  write_objects_yaml(truth() / "objects.yaml", {unsymmetrical});
  EXPECT_NEAR(thing()["ape"]["rotation_rad"]["max"], pi, kRounding);
}

// A cube of unequal estimated sides is a quarter off while it is occluded: other names, the same sides.
TEST_F(ComesBack, NewNamesAreNoChangeOfSize) {
  write_object("box", {0.2, 0.2, 0.2}, Eigen::Quaterniond::Identity(), [](Tracks& tracks) {
    occlude(tracks);
    for (ObjectState& state : tracks.objects[0].states) {
      state.ellipsoid.semi_axes_m = {0.2, 0.22, 0.18};
      Eigen::Quaterniond& q = state.ellipsoid.world_from_object.rotation;
      if (state.status == ObjectStatus::occluded) q = q * exp_so3({pi / 2, 0, 0});
    }
  });
  const json cube = thing();
  EXPECT_LT(cube["ape"]["rotation_rad"]["max"], kRounding);
  EXPECT_NEAR(cube["semi_axes_change_occluded_max"], 0, 1e-12);
}

}  // namespace
}  // namespace uniquadric
