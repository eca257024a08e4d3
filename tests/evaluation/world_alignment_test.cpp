#include "evaluation/world_alignment.h"

#include <cmath>

#include "core/base/error.h"
#include "tests/evaluation/evaluate_fixture.h"

namespace uniquadric {
namespace {

constexpr double kMoved = 1e-9;  // m or rad: a move of metres there and back, and its fit

// An evaluation whose estimate says that it found its camera's poses itself.
class World : public Evaluate {
 protected:
  json run_aligned(const char* run_yaml = "variant: {ego: {source: rgbd}}\n",
                   std::optional<AlignmentKind> kind = std::nullopt) {
    write_text(estimate() / "run.yaml", run_yaml);
    EvaluateOptions options;
    options.iou_samples = 100;
    options.force = true;
    options.alignment = kind;
    uniquadric::evaluate(truth(), estimate(), options, root_ / "out");
    return json::parse(read_text(root_ / "out" / "evaluation.json"));
  }
};

const Pose kMove = {exp_so3({0.4, -2.1, 0.9}), Eigen::Vector3d(5, -3, 2)};

void move_world(Tracks& tracks, const Pose& move, double scale = 1) {
  const Alignment alignment{scale, move};
  tracks = in_true_world({AlignmentKind::sim3, alignment, 1}, tracks);
}

// Frames of unknown bodies are anybody's choice: one transform a body, from the right, takes that back.
TEST_F(World, ABodysOwnFrameIsNoErrorWhereItIsAligned) {
  const Pose offset = {exp_so3({0.02, -0.05, 0.03}), {0.23, -0.1, 0.04}};
  write_changed([&](Tracks& tracks) {
    for (auto& object : tracks.objects)
      for (auto& state : object.states)
        state.ellipsoid.world_from_object = state.ellipsoid.world_from_object * offset;
  });
  write_text(estimate() / "run.yaml", "variant: {ego: given}\n");
  for (const BodyFrame kind : {BodyFrame::none, BodyFrame::first, BodyFrame::fit}) {
    EvaluateOptions options;
    options.iou_samples = 100;
    options.force = true;
    options.body_frame = kind;
    uniquadric::evaluate(truth(), estimate(), options, root_ / "out");
    const json result = json::parse(read_text(root_ / "out" / "evaluation.json"));
    EXPECT_EQ(result["config"]["evaluate"]["body_frame"], to_string(kind));
    const json& cuboid = result["objects"][0];
    const double expected_m = kind == BodyFrame::none ? offset.translation.norm() : 0;
    EXPECT_NEAR(cuboid["ape"]["translation_m"]["rmse"], expected_m, kMoved) << to_string(kind);
    EXPECT_EQ(double(cuboid["rpe"]["translation_m"]["max"]) < kMoved, kind != BodyFrame::none);
    EXPECT_NEAR(cuboid["motion_error"]["translation_m"]["max"], 0, kMoved);
    EXPECT_LT(cuboid["iou3d"]["max"], 0.9);
  }
}

// Least squares of shifts is their mean, of turns about one axis too.
TEST(BodyFrameOffset, FitIsTheMeanWhereFirstIsTheFirst) {
  std::vector<Pose> reference, estimate;
  for (const double k : {-1.0, 0.0, 1.0, 2.0}) {
    reference.push_back({exp_so3({0.3, k, -k}), {k, 2 * k, 1}});
    estimate.push_back(reference.back() * Pose{exp_so3({0, 0, 0.1 * k}), {0.1 * k, 0, 0}}.inverse());
  }
  const Pose first = body_frame_offset(BodyFrame::first, reference, estimate);
  EXPECT_NEAR(first.translation.x(), -0.1, 1e-12);
  EXPECT_NEAR(log_so3(first.rotation).z(), -0.1, 1e-12);
  const Pose fit = body_frame_offset(BodyFrame::fit, reference, estimate);
  EXPECT_NEAR((fit.translation - Eigen::Vector3d(0.05, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(log_so3(fit.rotation).z(), 0.05, 1e-12);
  EXPECT_TRUE(body_frame_offset(BodyFrame::fit, {}, {}).translation.isZero());
}

TEST_F(World, ATruthMovedAsAWholeHasNoError) {
  write_changed([](Tracks& tracks) { move_world(tracks, kMove); });
  for (const auto& kind : {std::optional<AlignmentKind>(), std::optional(AlignmentKind::first),
                           std::optional(AlignmentKind::se3), std::optional(AlignmentKind::poses)}) {
    const json result = run_aligned("variant: {ego: {source: rgbd}}\n", kind);
    EXPECT_EQ(result["alignment"]["kind"], kind ? to_string(*kind) : "poses");
    for (const char* figure : {"ape", "rpe"})
      for (const char* part : {"translation_m", "rotation_rad"})
        EXPECT_NEAR(result["camera"][figure][part]["max"], 0, kRounding) << figure << part;
    ASSERT_EQ(result["objects"].size(), 3u);
    for (const json& object : result["objects"]) {
      EXPECT_EQ(object["coverage"], 1);
      for (const char* figure : {"ape", "rpe", "motion_error"})
        for (const char* part : {"translation_m", "rotation_rad"})
          EXPECT_NEAR(object[figure][part]["max"], 0, kRounding) << figure << part;
      EXPECT_NEAR(object["ape"]["rotation_naive_rad"]["max"], 0, kRounding);
      for (const char* figure : {"iou3d", "iou2d_ellipse"}) EXPECT_NEAR(object[figure]["min"], 1, 1e-6);
    }
    EXPECT_NEAR(result["tracking"]["hota"], 1, 1e-12);
  }
}

TEST_F(World, TheTransformIsReportedAndCarriesTheEstimateBack) {
  write_changed([](Tracks& tracks) { move_world(tracks, kMove); });
  const json found = run_aligned()["alignment"]["truth_from_estimate"];
  const auto t = found["position_m"].get<std::vector<double>>();
  const auto q = found["quaternion_xyzw"].get<std::vector<double>>();
  const Pose back =
      Pose{Eigen::Quaterniond(q[3], q[0], q[1], q[2]), Eigen::Vector3d(t[0], t[1], t[2])} * kMove;
  EXPECT_NEAR(back.translation.norm(), 0, kRounding);
  EXPECT_NEAR(rotation_angle(back.rotation.toRotationMatrix()), 0, kRounding);
  EXPECT_EQ(found["scale"], 1);
}

TEST_F(World, GivenCameraPosesAreNotAligned) {
  const Pose shift = {Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.3, 0, 0)};
  write_changed([&](Tracks& tracks) { move_world(tracks, shift); });
  int cases = 0;
  for (const char* yaml : {"variant: {ego: given}\n", "variant: {ego: {source: given}}\n"}) {
    const json result = run_aligned(yaml);
    EXPECT_EQ(result["alignment"]["kind"], "none");
    EXPECT_NEAR(result["camera"]["ape"]["translation_m"]["rmse"], 0.3, kRounding);
    EXPECT_NEAR(result["objects"][0]["ape"]["translation_m"]["rmse"], 0.3, kRounding);
    ++cases;
  }
  for (const char* yaml : {"seed: 1\n", "variant: {ego: {source: rgbd}}\n", "variant: superquadric\n"}) {
    EXPECT_EQ(run_aligned(yaml)["alignment"]["kind"], "poses") << yaml;
    ++cases;
  }
  EXPECT_EQ(cases, 5);
}

TEST_F(World, TheCameraAlignsAndTheObjectsDoNot) {
  // A left error of the objects alone stays: no fit of its own per object.
  write_changed([](Tracks& tracks) {
    const Pose shift = {Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0.05, 0)};
    for (ObjectState& state : tracks.objects[0].states)
      state.ellipsoid.world_from_object = shift * state.ellipsoid.world_from_object;
    move_world(tracks, kMove);
  });
  const json result = run_aligned();
  EXPECT_NEAR(result["camera"]["ape"]["translation_m"]["max"], 0, kRounding);
  EXPECT_NEAR(result["objects"][0]["ape"]["translation_m"]["rmse"], 0.05, kRounding);
  EXPECT_NEAR(result["objects"][1]["ape"]["translation_m"]["max"], 0, kRounding);
}

TEST_F(World, AScaledWorldScalesItsObjects) {
  write_changed([](Tracks& tracks) { move_world(tracks, kMove, 0.5); });
  const json result = run_aligned("seed: 1\n", AlignmentKind::sim3);
  EXPECT_NEAR(result["alignment"]["truth_from_estimate"]["scale"], 2, 1e-6);
  EXPECT_NEAR(result["objects"][0]["iou3d"]["min"], 1, 1e-5);
  EXPECT_NEAR(result["objects"][0]["semi_axes_error_m"]["x"]["max"], 0, 1e-6);
}

// Centres off by 0.03 m of the true world against sigmas of 0.01 along each axis, in a world of half the
// size.
TEST_F(World, AScaledWorldScalesWhatItsObjectsState) {
  write_changed([](Tracks& tracks) {
    for (ObjectState& state : tracks.objects[0].states) {
      state.ellipsoid.world_from_object.translation.y() += 0.03;
      state.ellipsoid.semi_axes_m.x() += 0.01;
    }
    move_world(tracks, kMove, 0.5);
    for (ObjectState& state : tracks.objects[0].states) state.covariance_diagonal.setConstant(0.005 * 0.005);
  });
  const json cuboid = run_aligned("seed: 1\n", AlignmentKind::sim3)["objects"][0]["consistency"];
  EXPECT_NEAR(cuboid["translation"]["rmse"], std::sqrt(3.0), 1e-4);
  EXPECT_NEAR(cuboid["semi_axes"]["rmse"], 1 / std::sqrt(3.0), 1e-4);
  EXPECT_NEAR(cuboid["rotation"]["rmse"], 0, 1e-4);
}

TEST_F(World, AnotherUnitIsWarnedOfUnlessAScaleIsFitted) {
  const auto said = [&](AlignmentKind kind) {
    testing::internal::CaptureStderr();
    run_aligned("seed: 1\n", kind);
    return testing::internal::GetCapturedStderr();
  };
  write_changed([](Tracks& tracks) { move_world(tracks, kMove, 1000); });
  EXPECT_NE(said(AlignmentKind::poses).find("camera.tum: positions spread over "), std::string::npos);
  EXPECT_NE(said(AlignmentKind::poses).find("objects.csv: no object overlaps a true one; the semi-axes'"),
            std::string::npos);
  EXPECT_EQ(said(AlignmentKind::sim3), "");
  write_changed([](Tracks& tracks) { move_world(tracks, kMove, 0.5); });
  EXPECT_EQ(said(AlignmentKind::poses), "");
}

TEST_F(World, SeThreeRefusesACameraOnALine) {
  write_changed([](Tracks& tracks) {
    for (std::size_t i = 0; i < tracks.camera.size(); ++i)
      tracks.camera[i].pose.translation = Eigen::Vector3d(0.01 * static_cast<double>(i), 0, 0);
  });
  EXPECT_THROW(run_aligned("seed: 1\n", AlignmentKind::se3), InputError);
  EXPECT_EQ(run_aligned()["camera"]["pairs"], kFrames);  // `poses` takes the rotation from the orientations
}

TEST(WorldAlignment, TheLeverIsTheObjectsMeanDistance) {
  Tracks truth;
  truth.camera = {{0, {}}, {1, {}}};
  EXPECT_EQ(object_distance_m(truth), 1);
  for (const double z : {2.0, 6.0}) {
    ObjectState state;
    state.stamp_ns = z > 3;
    state.ellipsoid.world_from_object.translation.z() = z;
    truth.objects.push_back({1, "", {state}});
  }
  EXPECT_EQ(object_distance_m(truth), 4);
}

// Half a millimetre of error turns a world by much when only the positions of a nearly straight path fix it:
// what `poses` is for.
TEST(WorldAlignment, PosesHoldTheWorldOnANearlyStraightPath) {
  Tracks truth, estimate;
  ObjectTrack object{1, "", {}};
  for (int i = 0; i < 100; ++i) {
    const double x = 0.01 * i, bow = 4 * x * (1 - x);
    const Pose camera = {exp_so3({0, 0.3 * x, 0}), Eigen::Vector3d(x, 0.0025 * bow, 0)};
    truth.camera.push_back({i, camera});
    const Pose error = {exp_so3({0.001 * bow, 0, 0}), Eigen::Vector3d(0, 0, 0.0005 * bow)};
    estimate.camera.push_back(
        {i, {camera.rotation * error.rotation, camera.translation + error.translation}});
    ObjectState state;
    state.stamp_ns = i;
    state.ellipsoid.world_from_object.translation = Eigen::Vector3d(0.5, 0, 3);
    object.states.push_back(state);
  }
  truth.objects = {object};
  const auto shift_m = [&](AlignmentKind kind) {
    const Pose& pose = truth.objects[0].states[0].ellipsoid.world_from_object;
    const Pose moved = align_world(kind, truth, estimate, 0).truth_from_estimate * pose;
    return (moved.translation - pose.translation).norm();
  };
  EXPECT_LT(shift_m(AlignmentKind::poses), 0.003);  // 3 m times the orientations' mean error
  EXPECT_GT(shift_m(AlignmentKind::se3), 0.3);
}

}  // namespace
}  // namespace uniquadric
