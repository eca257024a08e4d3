// The whole estimator on sequences in which something is missing: it must not fail, and must not claim to
// know what it cannot.
#include <gtest/gtest.h>

#include <map>
#include <opencv2/core.hpp>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "drawn_sequence.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

TEST(Robustness, NoMaskEverIsNoObject) {
  const TempFolder temp;
  write_drawn_sequence(temp.path(), {kRed}, 12, [](DrawnFrame& drawn) { drawn.masks.setTo(0); });
  const Outcome outcome = run(temp.path());
  EXPECT_TRUE(outcome.tracks.objects.empty());
  EXPECT_EQ(outcome.tracks.camera.size(), 12u);
}

TEST(Robustness, NoDepthEverIsNoState) {
  const TempFolder temp;
  write_drawn_sequence(temp.path(), {kRed}, 12, [](DrawnFrame& drawn) { drawn.depth.setTo(0); });
  const Outcome outcome = run(temp.path());
  EXPECT_TRUE(outcome.tracks.objects.empty());
}

TEST(Robustness, DepthImagesWithoutDepthAreToldAndCounted) {
  for (const EgoSource ego : {EgoSource::given, EgoSource::rgbd})
    for (const int first : {0, 8, 12}) {
      const TempFolder temp;
      write_drawn_sequence(temp.path(), {kRed}, 12, [&](DrawnFrame& drawn) {
        if (drawn.frame.frame >= first) drawn.depth.setTo(0);
      });
      testing::internal::CaptureStderr();
      const Outcome outcome = run(temp.path(), 2, windows(ego));
      const std::string said = testing::internal::GetCapturedStderr(),
                        told = " of 12 depth images hold no depth";
      const int blank = 12 - first;
      EXPECT_EQ(said.find("warning: " + std::to_string(blank) + told) != std::string::npos, blank > 0)
          << said;
      EXPECT_EQ(said.find(told) != std::string::npos, blank > 0) << said;
      EXPECT_EQ(said.find("no measurements"), std::string::npos) << said;
      const ConfigNode counts = ConfigNode::parse(outcome.files.at("out/run.yaml"), "run.yaml");
      EXPECT_EQ(counts.get<int>("frames_without_depth"), blank);
    }
}

// Equal images that come as time goes on; the same camera at rest has noise.
TEST(Robustness, ACameraThatFrozeIsToldOf) {
  for (const bool is_frozen : {false, true}) {
    const TempFolder temp;
    cv::Mat held;
    write_drawn_sequence(temp.path(), {kRed}, 12, [&](DrawnFrame& drawn) {
      if (drawn.frame.frame == 4) held = drawn.rgb.clone();
      if (is_frozen && drawn.frame.frame > 4 && drawn.frame.frame < 9) held.copyTo(drawn.rgb);
    });
    testing::internal::CaptureStderr();
    run(temp.path());
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_EQ(said.find("the same colour image") != std::string::npos, is_frozen) << said;
    EXPECT_EQ(said.find("warning: frames 4 to 8 have the same colour image, as of a camera that froze\n") !=
                  std::string::npos,
              is_frozen)
        << said;
  }
}

// Without its list of masks another segmenter takes over, which nobody asked for.
TEST(Robustness, MasksThatNoListNamesAreToldOf) {
  const TempFolder temp;
  write_drawn_sequence(temp.path(), {kRed}, 3);
  const auto said = [&] {
    testing::internal::CaptureStderr();
    run(temp.path());
    return testing::internal::GetCapturedStderr();
  };
  const fs::path list = temp.path() / "masks.txt";
  const std::string warning =
      "warning: " + list.string() +
      ": is not there or names no masks: the images in masks/ are not used, bodies are segmented by "
      "depth_motion\n";
  EXPECT_EQ(said().find("masks.txt"), std::string::npos);
  fs::remove(list);
  EXPECT_NE(said().find(warning), std::string::npos);
  write_text(list, "");
  EXPECT_NE(said().find(warning), std::string::npos);
  fs::remove(list);
  Variant listed = windows();
  listed.perception.segmentation.source = "sequence";
  const std::string refusal = input_error([&] { estimate(temp.path(), listed, {}, temp.path() / "out"); });
  EXPECT_EQ(refusal,
            list.string() + ": is not there or names no masks, which the variant's segmentation asks for");
  fs::remove_all(temp.path() / "masks");
  EXPECT_EQ(said().find("masks.txt"), std::string::npos);
}

TEST(Robustness, ADepthScaleThatCannotBeIsWarnedOf) {
  const TempFolder temp;
  write_drawn_sequence(temp.path(), {kRed}, 3, [](DrawnFrame&) {});
  const auto said = [&](const char* find, const std::string& by) {
    const auto file = temp.path() / "sequence.yaml";
    std::string text = read_text(file);
    text.replace(text.find(find), std::string(find).size(), by);
    write_text(file, text);
    testing::internal::CaptureStderr();
    run(temp.path());
    return testing::internal::GetCapturedStderr();
  };
  const std::string warning = "sequence.yaml: depth.units_per_m: ";
  EXPECT_EQ(said("units_per_m: ", "units_per_m: ").find(warning), std::string::npos);
  EXPECT_NE(said("units_per_m: ", "units_per_m: 0.000").find(warning), std::string::npos);
}

TEST(Robustness, OneBlackFrameCostsNoTrackAndLittlePrecision) {
  const TempFolder temp;
  const auto blacken = [](DrawnFrame& drawn) {
    if (drawn.frame.frame == 20) drawn.rgb.setTo(0);
  };
  write_drawn_sequence(temp.path(), {kRed}, 36, blacken);
  const Outcome outcome = run(temp.path());
  expect_sane(outcome.tracks);
  ASSERT_EQ(outcome.tracks.objects.size(), 1u);
  const auto& states = outcome.tracks.objects[0].states;
  ASSERT_GE(states.size(), 32u);
  int checked = 0;
  for (const ObjectState& state : states) {
    if (state.frame < 12) continue;
    // its middle: 69 of its 70 columns are between the outer ones' centres
    const double x = (60 + 2.0 * double(state.frame) + 34.5 - drawn_camera().cx) / drawn_camera().fx * 2;
    EXPECT_NEAR(state.ellipsoid.world_from_object.translation.x(), x, 0.03) << state.frame;  // m
    ++checked;
  }
  EXPECT_EQ(checked, 24);
}

// A sensor that fails for two frames measures nothing in them: the body goes on under its id, and no other
// one begins.
TEST(Robustness, BadDepthImagesInARowCostNoBody) {
  const std::map<std::string, std::pair<Damage, Damage>> failures = {
      {"none, then all cut off",
       {[](DrawnFrame& f) { f.depth.setTo(0); }, [](DrawnFrame& f) { f.depth.setTo(1e6); }}},
      {"another scale", {[](DrawnFrame& f) { f.depth *= 1.5; }, [](DrawnFrame& f) { f.depth *= 1.5; }}},
      {"one value", {[](DrawnFrame& f) { f.depth.setTo(3); }, [](DrawnFrame& f) { f.depth.setTo(3); }}}};
  for (const auto& [what, damage] : failures) {
    const TempFolder temp;
    write_drawn_sequence(temp.path(), {kRed}, 36, [&](DrawnFrame& drawn) {
      if (drawn.frame.frame == 20) damage.first(drawn);
      if (drawn.frame.frame == 21) damage.second(drawn);
    });
    const Outcome outcome = run(temp.path(), 2, windows(EgoSource::rgbd));
    expect_sane(outcome.tracks);
    EXPECT_EQ(outcome.tracks.camera.size(), 36u) << what;
    ASSERT_EQ(outcome.tracks.objects.size(), 1u) << what;
    const auto& states = outcome.tracks.objects[0].states;
    ASSERT_GE(states.size(), 32u) << what;
    EXPECT_EQ(states.back().frame, 35) << what;
    const double first_x = states[8].ellipsoid.world_from_object.translation.x(),
                 last_x = states.back().ellipsoid.world_from_object.translation.x();
    const double way = 2.0 * double(35 - states[8].frame) / drawn_camera().fx * 2;
    EXPECT_NEAR(std::abs(last_x - first_x), way, 0.03) << what;  // m
    for (const ObjectState& state : states)
      EXPECT_TRUE(state.status == ObjectStatus::tentative || state.status == ObjectStatus::active)
          << what << state.frame;
  }
}

// The second image is refused in the first one's favour, with which its frame has no place in the new map.
TEST(Robustness, AFirstDepthImageThatIsWrongCostsAMomentAlone) {
  for (const double factor : {0.5, 2.0}) {
    const TempFolder temp;
    write_drawn_sequence(temp.path(), {kRed}, 36, [&](DrawnFrame& drawn) {
      if (drawn.frame.frame == 0) drawn.depth *= factor;
    });
    const Outcome outcome = run(temp.path(), 2, windows(EgoSource::rgbd));
    EXPECT_GE(outcome.tracks.camera.size(), 34u) << factor;
    ASSERT_GE(outcome.tracks.objects.size(), 1u) << factor;
    const auto& last = outcome.tracks.objects.back().states.back();
    EXPECT_EQ(last.frame, 35) << factor;
    EXPECT_EQ(last.status, ObjectStatus::active) << factor;
    const ConfigNode run = ConfigNode::parse(outcome.files.at("out/run.yaml"), "run.yaml");
    EXPECT_EQ(run.get<int>("frames_without_depth"), 1) << factor;
    EXPECT_EQ(run.get<int>("ego_restarts"), 0) << factor;
  }
}

// From frame 20 on all is 30 % further away and 30 % faster: the same images, and no depth that fits.
TEST(Robustness, AStepOfTheDepthsScaleIsToldAndLeavesTheCameraAPose) {
  const TempFolder temp;
  write_drawn_sequence(temp.path(), {kRed}, 70, [&](DrawnFrame& drawn) {
    if (drawn.frame.frame >= 20) drawn.depth *= 1.3;
  });
  testing::internal::CaptureStderr();
  const Outcome outcome = run(temp.path(), 2, windows(EgoSource::rgbd));
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("lost its map 1 times, and went on"), std::string::npos) << said;
  ASSERT_GE(outcome.tracks.camera.size(), 55u);
  EXPECT_EQ(outcome.tracks.camera.back().stamp_ns, draw_world({}, 69).frame.stamp_ns);
  EXPECT_EQ(ConfigNode::parse(outcome.files.at("out/run.yaml"), "run.yaml").get<int>("ego_restarts"), 1);
}

// Less than half of the frames, but more than a second.
TEST(Robustness, ALongTimeWithoutACameraPoseIsTold) {
  const TempFolder temp;
  Sequence sequence = write_drawn_sequence(temp.path(), {}, 90);
  auto& poses = *sequence.given_camera;
  poses.erase(poses.begin() + 30, poses.begin() + 61);
  write_sequence_index(temp.path(), sequence);
  testing::internal::CaptureStderr();
  run(temp.path());
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("the camera has no pose for 1.1 s (frames 30 to 60)"), std::string::npos) << said;
}

// The camera that follows itself: nothing to follow is no pose; a black frame has none, and the next ones do.
TEST(Robustness, TheCamerasOwnWayIsLostWhereNothingIsSeenAndFoundAgain) {
  const TempFolder temp;
  const auto blacken = [](DrawnFrame& drawn) {
    if (drawn.frame.frame == 8) drawn.rgb.setTo(0);
  };
  write_drawn_sequence(temp.path() / "black", {kRed}, 16, blacken);
  const Outcome black = run(temp.path() / "black", 2, windows(EgoSource::rgbd));
  EXPECT_EQ(black.tracks.camera.size(), 15u);
  for (const auto& [stamp_ns, pose] : black.tracks.camera)
    EXPECT_LT((pose.translation - black.tracks.camera[0].pose.translation).norm(),
              0.01);  // m: it stands still
  write_drawn_sequence(temp.path() / "blind", {kRed}, 6, [](DrawnFrame& drawn) { drawn.depth.setTo(0); });
  const Outcome blind = run(temp.path() / "blind", 2, windows(EgoSource::rgbd));
  EXPECT_TRUE(blind.tracks.camera.empty());
  EXPECT_TRUE(blind.tracks.objects.empty());
}

TEST(Robustness, StampsThatStandTwiceAreRefused) {
  const TempFolder temp;
  Sequence sequence = write_drawn_sequence(temp.path() / "sequence", {kRed}, 4);
  sequence.frames[2].stamp_ns = sequence.frames[1].stamp_ns;
  write_sequence_index(temp.path() / "sequence", sequence);
  const std::string message =
      input_error([&] { estimate(temp.path() / "sequence", windows(), {}, temp.path() / "out"); });
  EXPECT_NE(message.find("rgb.txt:4"), std::string::npos) << message;
  EXPECT_FALSE(fs::exists(temp.path() / "out"));
}

// While it is away the body is occluded or lost, and when it is back it is the same one, where it is and as
// large as it is. It is flat, and depth leaves open how thick it is.
TEST(Robustness, ABodyThatLeavesAndReturnsIsTheSameAndNeverActiveMeanwhile) {
  Sprite visitor = kRed;
  visitor.corner_px = [](std::int64_t n) {  // out at the right by frame 40, in again from 70
    return Eigen::Vector2d(n < 55 ? 160 + 5.0 * double(n) : 160 + 5.0 * double(110 - n), 80);
  };
  const TempFolder temp;
  write_drawn_sequence(temp.path(), {visitor}, 110);
  const Outcome outcome = run(temp.path());
  expect_sane(outcome.tracks);
  ASSERT_EQ(outcome.tracks.objects.size(), 1u);
  int before = 0, away = 0, lost = 0, after = 0;
  for (const ObjectState& state : outcome.tracks.objects[0].states) {
    const bool is_active = state.status == ObjectStatus::active || state.status == ObjectStatus::tentative;
    if (state.frame < 25) before += is_active;
    lost += state.status == ObjectStatus::lost;
    if (state.frame > 34 && state.frame < 76) {
      EXPECT_FALSE(is_active) << state.frame;
      ++away;
    }
    if (state.frame < 100) continue;
    after += is_active;
    const Eigen::Vector2d across_px(visitor.size.width - 1, visitor.size.height - 1);
    const auto ray = drawn_camera().unproject(visitor.corner_px(state.frame) + across_px / 2);
    const Eigen::Vector3d off = state.ellipsoid.world_from_object.translation - visitor.depth_m * ray.value();
    EXPECT_LT(off.head<2>().norm(), 0.005) << state.frame;  // m: two thirds of a pixel
    EXPECT_LT(std::abs(off.z()), 0.03) << state.frame;
    const Eigen::Quaterniond turn = state.ellipsoid.world_from_object.rotation;
    EXPECT_GT(std::abs((turn * Eigen::Vector3d::UnitZ()).z()), std::cos(0.02)) << state.frame;
    EXPECT_GT(std::abs((turn * Eigen::Vector3d::UnitX()).x()), std::cos(0.02)) << state.frame;
    const Eigen::Vector2d expected_m = across_px / 2 * visitor.depth_m / drawn_camera().fx;
    EXPECT_NEAR(state.ellipsoid.semi_axes_m.x(), expected_m.x(), 0.008) << state.frame;  // m: a pixel
    EXPECT_NEAR(state.ellipsoid.semi_axes_m.y(), expected_m.y(), 0.008) << state.frame;
  }
  EXPECT_GE(before, 15);
  EXPECT_GE(lost, 1);
  EXPECT_LE(away, 15);  // where it is out of sight nobody says how it goes on
  EXPECT_EQ(after, 10);
}

}  // namespace
}  // namespace uniquadric
