#include "evaluation/align/shape_symmetry.h"

#include "evaluation/object_evaluation.h"

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/geometry/box_symmetry.h"
#include "evaluation/trajectory/pose_error.h"
#include "tests/evaluation/evaluate_fixture.h"
#include "tests/evaluation/random_ellipsoid.h"

namespace uniquadric {
namespace {

using std::numbers::pi;
constexpr double kTurned = 1e-7;  // rad: acos-free angles of products of rotations, near zero
constexpr ShapeSymmetry kBox{BodySymmetry::box, 2}, kRound{BodySymmetry::revolution, 2},
    kSphere{BodySymmetry::sphere, 2}, kNone{BodySymmetry::none, 2};

std::vector<Ellipsoid> tumbling(const Eigen::Vector3d& semi_axes_m, int frames = 20) {
  RandomStream random(3, "tumbling");
  std::vector<Ellipsoid> track;
  for (int i = 0; i < frames; ++i) track.push_back({{random_rotation(random), {0.1 * i, 0, 2}}, semi_axes_m});
  return track;
}

// The body turned in its own frame; frame i by turn(i).
std::vector<Ellipsoid> turned(std::vector<Ellipsoid> track, const std::function<Eigen::Vector3d(int)>& turn) {
  for (std::size_t i = 0; i < track.size(); ++i) {
    Eigen::Quaterniond& q = track[i].world_from_object.rotation;
    q = q * exp_so3(turn(static_cast<int>(i)));
  }
  return track;
}
std::vector<Ellipsoid> turned(const std::vector<Ellipsoid>& track, const Eigen::Vector3d& turn) {
  return turned(track, [&](int) { return turn; });
}

std::vector<double> errors_rad(const ShapeSymmetry& symmetry, const std::vector<Ellipsoid>& estimate,
                               const std::vector<Ellipsoid>& truth) {
  const SettledTrack settled = settle_axes(symmetry, estimate, truth);
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.size(); ++i)
    errors.push_back(
        absolute_error(truth[i].world_from_object, settled.estimate[i].world_from_object).rotation_rad);
  return errors;
}
double worst_rad(const ShapeSymmetry& symmetry, const std::vector<Ellipsoid>& estimate,
                 const std::vector<Ellipsoid>& truth) {
  const auto errors = errors_rad(symmetry, estimate, truth);
  return *std::max_element(errors.begin(), errors.end());
}

TEST(SettleAxes, AnyNamesOfABoxAreUndone) {
  const auto truth = tumbling({0.3, 0.2, 0.1});
  int cases = 0;
  for (const auto& P : box_rotations()) {
    std::vector<Ellipsoid> renamed;
    for (const Ellipsoid& e : truth) renamed.push_back(relabel_axes(e, P));
    EXPECT_LT(worst_rad(kBox, renamed, truth), kTurned);
    EXPECT_EQ(settle_axes(kBox, renamed, truth).relabel_flips, 0);
    for (const Ellipsoid& e : settle_axes(kBox, renamed, truth).estimate)
      EXPECT_EQ(e.semi_axes_m, truth[0].semi_axes_m);
    ++cases;
  }
  EXPECT_EQ(cases, 24);
}

TEST(SettleAxes, ABoxMayBeTurnedWithinFivePercentOfItsAxesOnly) {
  const Eigen::Vector3d quarter(0, 0, pi / 2), half(pi, 0, 0), eighth(0, 0, pi / 4);
  const auto near_cube = tumbling({1, 1.03, 1}), square = tumbling({1, 1, 2}), flat = tumbling({3, 2, 1});
  EXPECT_LT(worst_rad(kBox, turned(near_cube, quarter), near_cube), kTurned);
  EXPECT_LT(worst_rad(kBox, turned(square, quarter), square), kTurned);
  EXPECT_LT(worst_rad(kBox, turned(flat, half), flat), kTurned);
  for (const auto& truth : {near_cube, square}) {  // halfway between two names
    EXPECT_NEAR(worst_rad(kBox, turned(truth, eighth), truth), pi / 4, kTurned);
  }
  for (const double angle : {0.1, 0.5, 0.7})
    EXPECT_NEAR(worst_rad(kBox, turned(flat, Eigen::Vector3d(0, angle, 0)), flat), angle, kTurned);
  EXPECT_NEAR(worst_rad(kBox, turned(near_cube, Eigen::Vector3d(0, 0.3, 0)), near_cube), 0.3, kTurned);
}

TEST(SettleAxes, OneRotationATrack) {
  const auto truth = tumbling({1, 1, 1});
  // A cube that is renamed after 12 of 20 frames: the greater part decides, the rest is wrong by a quarter.
  const auto estimate = turned(truth, [](int i) { return Eigen::Vector3d(0, 0, i < 12 ? pi / 2 : 0); });
  const auto errors = errors_rad(kBox, estimate, truth);
  for (std::size_t i = 0; i < errors.size(); ++i) EXPECT_NEAR(errors[i], i < 12 ? 0 : pi / 2, kTurned) << i;
  EXPECT_EQ(settle_axes(kBox, estimate, truth).relabel_flips, 8);
}

TEST(SettleAxes, ARoundBodyTurnsFreelyAboutItsAxisAlone) {
  const auto truth = tumbling({1, 1, 2});
  EXPECT_LT(worst_rad(kRound, turned(truth, Eigen::Vector3d(0, 0, 1)), truth), kTurned);
  EXPECT_LT(
      worst_rad(kRound, turned(turned(truth, Eigen::Vector3d(0, 0, 1)), Eigen::Vector3d(pi, 0, 0)), truth),
      kTurned);  // upside down
  EXPECT_NEAR(worst_rad(kRound, turned(truth, Eigen::Vector3d(0.2, 0, 0)), truth), 0.2, kTurned);
  EXPECT_NEAR(worst_rad(kBox, turned(truth, Eigen::Vector3d(0, 0, 0.4)), truth), 0.4, kTurned);
  const auto along_x = tumbling({2, 1, 1});
  EXPECT_LT(worst_rad({BodySymmetry::revolution, 0}, turned(along_x, Eigen::Vector3d(1, 0, 0)), along_x),
            kTurned);
}

// A ball whose estimate spins too fast by 10 mrad a frame. The free rotation is that of the first ten frames,
// the mean of 0 to 90 mrad; frame i is off by |i - 4.5| times 10 mrad.
TEST(SettleAxes, ABallsErrorIsItsSpinSinceTheFirstTenFrames) {
  const auto truth = tumbling({1, 1.02, 1}, 50);
  const Eigen::Vector3d odd(2, 1, -1);
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 2) / 3;
  const auto estimate = turned(turned(truth, [&](int i) -> Eigen::Vector3d { return 0.01 * i * axis; }), odd);
  const auto errors = errors_rad(kSphere, estimate, truth);
  for (std::size_t i = 0; i < errors.size(); ++i)
    EXPECT_NEAR(errors[i], 0.01 * std::abs(static_cast<double>(i) - 4.5), 1e-6) << i;
}

TEST(SettleAxes, WithoutSymmetryEverythingCounts) {
  const auto truth = tumbling({1, 1, 1});
  EXPECT_NEAR(worst_rad(kNone, turned(truth, Eigen::Vector3d(0, 0, pi / 2)), truth), pi / 2, kTurned);
  EXPECT_EQ(worst_rad(kNone, truth, truth), 0);
}

TEST(SettleAxes, AFewFramesAreEnough) {
  for (const int frames : {0, 1, 3}) {
    const auto truth = tumbling({1, 1, 1}, frames);
    for (const auto& symmetry : {kBox, kRound, kSphere, kNone})
      for (const double error : errors_rad(symmetry, truth, truth)) EXPECT_EQ(error, 0);
  }
}

TEST(ShapeSymmetry, ComesFromShapeAndAxesUnlessStated) {
  struct Case {
    const char* shape;
    Eigen::Vector3d axes;
    std::optional<BodySymmetry> stated;
    BodySymmetry expected;
    int axis;
  };
  const std::vector<Case> cases = {
      {"box", {1, 1, 1}, {}, BodySymmetry::box, 2},
      {"mesh", {1, 1, 2}, {}, BodySymmetry::box, 2},
      {"mesh", {1, 1, 2}, BodySymmetry::revolution, BodySymmetry::revolution, 2},
      {"mesh", {2, 1.04, 1}, BodySymmetry::revolution, BodySymmetry::revolution, 0},
      {"mesh", {1, 1, 1}, BodySymmetry::sphere, BodySymmetry::sphere, 2},
      {"mesh", {1, 2, 3}, BodySymmetry::none, BodySymmetry::none, 2},
      {"ball", {1, 1, 1}, {}, BodySymmetry::sphere, 2},
      {"ball", {1, 1, 1}, BodySymmetry::box, BodySymmetry::box, 2},
      {"ellipsoid", {1, 1.02, 0.98}, {}, BodySymmetry::sphere, 2},
      {"ellipsoid", {1, 2, 1}, {}, BodySymmetry::revolution, 1},
      {"ellipsoid", {1, 2, 3}, {}, BodySymmetry::box, 2},
      {"cylinder", {1, 1, 3}, {}, BodySymmetry::revolution, 2},
      {"cylinder", {1, 1, 1}, {}, BodySymmetry::revolution, 2},  // as high as wide
      {"cylinder", {1, 2, 2}, {}, BodySymmetry::box, 2},         // an oval one
      {"skateboard", {1, 1, 1}, {}, BodySymmetry::box, 2},
  };
  for (const Case& c : cases) {
    const ShapeSymmetry found = shape_symmetry(c.shape, c.stated, c.axes);
    EXPECT_EQ(to_string(found.kind), std::string(to_string(c.expected)))
        << c.shape << " " << c.axes.transpose();
    if (found.kind == BodySymmetry::revolution) {
      EXPECT_EQ(found.axis, c.axis) << c.shape << " " << c.axes.transpose();
    }
  }
  EXPECT_EQ(cases.size(), 15u);
}

// Through the whole evaluation: the key of objects.yaml decides how a turned can is judged.
TEST_F(Evaluate, TheTruthStatesASymmetry) {
  std::vector<ObjectDescription> objects = {{1, "Can", {0.1, 0.1, 0.2}, "mesh", "can.obj"}};
  write_changed([](Tracks& tracks) {
    tracks.objects.resize(1);
    for (ObjectState& state : tracks.objects[0].states) {
      state.ellipsoid.semi_axes_m = {0.1, 0.1, 0.2};
      Eigen::Quaterniond& q = state.ellipsoid.world_from_object.rotation;
      q = q * exp_so3({0, 0, 0.6});
    }
  });
  struct Case {
    std::optional<BodySymmetry> stated;
    double error_rad;
  };
  int cases = 0;
  for (const Case& c : {Case{std::nullopt, 0.6}, Case{BodySymmetry::box, 0.6}, Case{BodySymmetry::none, 0.6},
                        Case{BodySymmetry::revolution, 0}}) {
    objects[0].symmetry = c.stated;
    write_objects_yaml(truth() / "objects.yaml", objects);
    const json object = run()["objects"][0];
    EXPECT_EQ(object["symmetry"], to_string(c.stated.value_or(BodySymmetry::box)));
    EXPECT_NEAR(object["ape"]["rotation_rad"]["rmse"], c.error_rad, kRounding);
    EXPECT_NEAR(object["ape"]["rotation_naive_rad"]["rmse"], 0.6, kRounding);
    ++cases;
  }
  EXPECT_EQ(cases, 4);
}

TEST_F(Evaluate, SymmetriesThatCannotBeAreRefused) {
  const auto refused = [&](const std::string& rest) {
    write_text(truth() / "objects.yaml", "schema: 1\nobjects:\n  - {id: 1, name: a, " + rest + "}\n");
    try {
      read_objects_yaml(truth() / "objects.yaml");
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(refused("semi_axes_m: [1, 1, 1], symmetry: cube")
                .find("objects.yaml:3: objects[0].symmetry: expected box"),
            std::string::npos);
  EXPECT_NE(refused("semi_axes_m: [1, 1.2, 1.4], symmetry: revolution").find("symmetry: does not go with"),
            std::string::npos);
  EXPECT_NE(refused("semi_axes_m: [1, 1, 1.2], symmetry: sphere").find("symmetry: does not go with"),
            std::string::npos);
  for (const char* fine :
       {"semi_axes_m: [1, 1.2, 1.4], symmetry: none", "semi_axes_m: [1, 1, 2], symmetry: revolution",
        "semi_axes_m: [1, 1.03, 1], symmetry: sphere", "semi_axes_m: [1, 2, 3]"})
    EXPECT_EQ(refused(fine), "accepted") << fine;
}

// A can's box may be turned about the can's own axis alone.
TEST(ShapeSymmetry, ABoxAboutABodyOfRevolutionMayTurn) {
  const Ellipsoid truth{{Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2).normalized(), {1, 2, 3}}, {1, 1, 3}};
  const auto turned = [&](double angle_rad, const Eigen::Vector3d& axis) {
    Ellipsoid estimate = truth;
    estimate.world_from_object.rotation =
        truth.world_from_object.rotation * Eigen::AngleAxisd(angle_rad, axis);
    return estimate;
  };
  const Ellipsoid about_z = turned(0.7, Eigen::Vector3d::UnitZ()),
                  about_x = turned(0.7, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(symmetric_box_iou(truth, about_z, kRound), 1, 1e-9);
  EXPECT_LT(symmetric_box_iou(truth, about_z, kBox), 0.86);
  EXPECT_LT(symmetric_box_iou(truth, about_x, kRound), 0.6);
  const Ellipsoid ball{truth.world_from_object, {1, 1, 1}};
  EXPECT_NEAR(symmetric_box_iou(ball, {about_x.world_from_object, {1, 1, 1}}, {BodySymmetry::sphere, 2}), 1,
              1e-9);
}

}  // namespace
}  // namespace uniquadric
