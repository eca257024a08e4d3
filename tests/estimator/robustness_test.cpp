// The whole estimator on sequences in which something is missing: it must not fail, and must not claim to
// know what it cannot.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <opencv2/core.hpp>
#include <set>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "core/sequence/tracks.h"
#include "drawn_world.h"
#include "estimator/estimate.h"
#include "estimator/perception/perceive.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kLatencyFrames = 3;
using Damage = std::function<void(DrawnFrame&)>;

const Sprite kRed{1,        11, {50, 60, 180},
                  {70, 50}, 2,  [](std::int64_t n) {
                                  return Eigen::Vector2d(60 + 2.0 * double(n), 80); }};

Sequence write_drawn_sequence(const fs::path& folder, const std::vector<Sprite>& sprites, int frames,
                              const Damage& damage = {}, const Camera& camera = drawn_camera()) {
  for (const char* name : {"rgb", "depth", "masks"}) fs::create_directories(folder / name);
  Sequence sequence;
  sequence.folder = folder;
  sequence.name = "drawn";
  sequence.camera = camera;
  sequence.rate_hz = 30;
  sequence.given_camera.emplace();
  for (int n = 0; n < frames; ++n) {
    DrawnFrame drawn = draw_world(sprites, n);
    if (damage) damage(drawn);
    cv::Mat depth;
    drawn.depth.convertTo(depth, CV_16U, sequence.depth_units_per_m);
    const std::string file = fmt::format("{:06}.png", n);
    SequenceFrame& frame = drawn.frame;
    write_png(folder / (frame.rgb = fs::path("rgb") / file), drawn.rgb);
    write_png(folder / (frame.depth = fs::path("depth") / file), depth);
    write_png(folder / (frame.masks = fs::path("masks") / file), drawn.masks);
    frame.masks_arrival_ns = draw_world({}, n + kLatencyFrames).frame.stamp_ns;
    sequence.frames.push_back(frame);
    sequence.given_camera->push_back({frame.stamp_ns, Pose{}});
  }
  write_sequence_index(folder, sequence);
  return sequence;
}

Variant windows(EgoSource ego = EgoSource::given) {
  Variant variant;
  variant.backend = Backend::windows;
  variant.perception.ego = ego;
  return variant;
}

// Sees it in a folder below the sequence's.
Perception perceived(const Sequence& sequence, const PerceptionOptions& options,
                     const char* name = "perception") {
  PerceiveOptions quiet;
  quiet.quiet = true;
  std::vector<StageTime> times;
  const fs::path folder = sequence.folder / name;
  fs::create_directories(folder);
  PerceptionWriter out(folder, perception_camera(sequence, options), {});
  perceive(sequence, options, quiet, out, times);
  return Perception(folder);
}

struct Outcome {
  Tracks tracks;
  std::map<std::string, std::string> files;
};

Outcome run(const fs::path& folder, int threads = 2, const Variant& variant = windows()) {
  const TempFolder temp;
  EstimateOptions options;
  options.quiet = true;
  options.threads = threads;
  estimate(folder, variant, options, temp.path() / "out");
  Outcome outcome{read_tracks(temp.path() / "out"), {}};
  for (const auto& entry : fs::recursive_directory_iterator(temp.path() / "out"))
    if (entry.is_regular_file() && entry.path().filename() != "timing.csv")
      outcome.files[fs::relative(entry.path(), temp.path()).string()] = read_text(entry.path());
  return outcome;
}

// Every number that a state gives is one, and no body is thin as nothing or as large as the room.
void expect_sane(const Tracks& tracks) {
  for (const ObjectTrack& track : tracks.objects)
    for (const ObjectState& state : track.states) {
      const Ellipsoid& e = state.ellipsoid;
      EXPECT_TRUE(e.world_from_object.translation.allFinite() && e.semi_axes_m.allFinite()) << state.frame;
      EXPECT_GT(e.semi_axes_m.minCoeff(), 0) << state.frame;
      EXPECT_LT(e.semi_axes_m.maxCoeff(), 5) << state.frame;
    }
}

// Carried outlines are known at their own frames; those of the segmenter three frames after theirs, which
// is when the tracker is done with them.
TEST(Robustness, WhatIsKnownWhen) {
  const TempFolder temp;
  const Sequence sequence = write_drawn_sequence(temp.path(), {kRed}, 16);
  PerceptionOptions options;
  int late = 0;
  for (const bool carries : {true, false}) {
    options.aot.enabled = carries;
    const Perception perception = perceived(sequence, options, carries ? "carried" : "segmented");
    ASSERT_EQ(perception.frames().size(), 16u);
    for (std::size_t i = 0; i < 16; ++i) {
      const PerceivedFrame frame = perception.read(i);
      EXPECT_EQ(frame.has_masks, !carries || frame.frame >= kLatencyFrames);
      ASSERT_EQ(frame.bodies.size(), frame.has_masks ? 1u : 0u) << frame.frame;
      if (frame.bodies.empty()) continue;
      const BodyObservation& body = frame.bodies[0];
      ASSERT_TRUE(body.silhouette) << frame.frame;
      EXPECT_EQ(body.silhouette->known_at_frame, frame.frame);
      EXPECT_EQ(body.silhouette->segmented, !carries);
      if (!body.segmented) continue;
      EXPECT_TRUE(carries && body.segmented->segmented);
      EXPECT_EQ(frame.frame % kLatencyFrames, 0);
      EXPECT_EQ(body.segmented->known_at_frame, frame.frame + kLatencyFrames);
      ++late;
    }
  }
  EXPECT_EQ(late, 4);  // of frames 3, 6, 9 and 12
}

// Images are as the lens makes them; points and outlines are those of an ideal one.
TEST(Robustness, ADistortingLensIsUndone) {
  const TempFolder temp;
  Camera lens = drawn_camera();
  lens.distortion = {-0.3, 0.1, 0.002, -0.001, 0};
  const Eigen::Vector2d first(8, 6), size(80, 60);  // in the image's corner, where the lens bends most
  const Sprite sprite{1, 11, {50, 60, 180}, {80, 60}, 2, [&](std::int64_t) { return first; }};
  const Sequence sequence = write_drawn_sequence(temp.path(), {sprite}, 2, {}, lens);
  PerceptionOptions options;
  options.aot.enabled = false;
  options.ego = EgoSource::given;
  const PerceivedFrame frame = perceived(sequence, options).read(1);
  ASSERT_EQ(frame.bodies.size(), 1u);
  const BodyObservation& body = frame.bodies[0];
  ASSERT_GT(body.points.cols(), 100);
  for (const auto& point : body.points.colwise()) {
    const auto pixel = lens.project(point);
    ASSERT_TRUE(pixel);
    EXPECT_GT((*pixel - first).minCoeff(), -0.5);
    EXPECT_LT((*pixel - first - size).maxCoeff(), 0.5);
  }
  Eigen::Vector2d corner = first;  // of what the outline covers, without the lens
  for (int along = 0; along <= 80; ++along)
    for (const Eigen::Vector2d& edge : {Eigen::Vector2d(along, 0), Eigen::Vector2d(0, 0.75 * along)}) {
      const Eigen::Vector3d ray = *lens.unproject(first + edge - Eigen::Vector2d(0.5, 0.5));
      corner = corner.cwiseMin(Eigen::Vector2d(lens.fx * ray.x() + lens.cx, lens.fy * ray.y() + lens.cy));
    }
  ASSERT_TRUE(body.silhouette);
  EXPECT_NEAR(-body.silhouette->bbox[2].offset_px, corner.x(), 0.5);
  EXPECT_NEAR(-body.silhouette->bbox[3].offset_px, corner.y(), 0.5);
}

TEST(Robustness, StampsMayLieBeforeZero) {
  const TempFolder temp;
  Sequence sequence = write_drawn_sequence(temp.path(), {kRed}, 12);
  for (SequenceFrame& frame : sequence.frames) {
    frame.stamp_ns -= 50'000'000'000;
    frame.masks_arrival_ns -= 50'000'000'000;
  }
  for (auto& pose : *sequence.given_camera) pose.stamp_ns -= 50'000'000'000;
  const Perception perception = perceived(sequence, PerceptionOptions{});
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(perception.frames()[i].has_masks, i >= kLatencyFrames) << i;
}

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

// While it is away the body is occluded or lost, and when it is back it is the same one.
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
  int before = 0, away = 0, after = 0;
  for (const ObjectState& state : outcome.tracks.objects[0].states) {
    const bool is_active = state.status == ObjectStatus::active || state.status == ObjectStatus::tentative;
    if (state.frame < 25) before += is_active;
    if (state.frame > 34 && state.frame < 76) {
      EXPECT_FALSE(is_active) << state.frame;
      ++away;
    }
    if (state.frame >= 100) after += is_active;
  }
  EXPECT_GE(before, 15);
  EXPECT_GE(away, 20);
  EXPECT_EQ(after, 10);
}

// Gives back what perception expects by itself.
class Echo : public BodyFeedback {
 public:
  int hinted = 0;

  BodyHints hints(std::int64_t, std::int64_t stamp_ns) override {
    BodyHints hints;
    const double steps = static_cast<double>(stamp_ns - last_ns_) / static_cast<double>(step_ns_);
    for (const auto& [id, motion] : motions_) hints[id].motion = exp_se3(steps * log_se3(motion));
    hinted += static_cast<int>(hints.size());
    return hints;
  }
  void take(const PerceivedFrame& frame) override {
    EXPECT_TRUE(frame.world_from_camera);
    step_ns_ = frame.stamp_ns - last_ns_;
    last_ns_ = frame.stamp_ns;
    motions_.clear();
    for (const BodyObservation& body : frame.bodies)
      if (body.motion) motions_[body.id] = *body.motion;
  }

 private:
  std::map<int, Pose> motions_;
  std::int64_t last_ns_ = 0, step_ns_ = 1;
};

TEST(Robustness, WithItsOwnExpectationsForHintsPerceptionIsTheSame) {
  const TempFolder temp;
  const Sequence sequence = write_drawn_sequence(temp.path() / "sequence", {kRed}, 16);
  Echo echo;
  std::map<bool, std::string> bytes;
  for (const bool joined : {false, true}) {
    PerceiveOptions run;
    run.quiet = true;
    run.feedback = joined ? &echo : nullptr;
    std::vector<StageTime> times;
    const fs::path folder = temp.path() / (joined ? "joined" : "alone");
    fs::create_directories(folder);
    PerceptionWriter out(folder, sequence.camera, {});
    perceive(sequence, {}, run, out, times);
    bytes[joined] = read_text(folder / "observations.bin");
  }
  EXPECT_GT(echo.hinted, 8);
  EXPECT_EQ(bytes[false], bytes[true]);
}

TEST(Robustness, JoinedWithTheBackEndTheBytesAreThoseOfAnyNumberOfThreads) {
  const TempFolder temp;
  Sprite blue = kRed;
  blue.id = 2;
  blue.texture = 12;
  blue.corner_px = [](std::int64_t n) { return Eigen::Vector2d(200 - 1.5 * double(n), 120); };
  write_drawn_sequence(temp.path(), {kRed, blue}, 24);
  Variant joined = windows(EgoSource::rgbd);
  joined.feedback = Feedback::backend;
  const Outcome one = run(temp.path(), 1, joined), four = run(temp.path(), 4, joined);
  EXPECT_EQ(one.files, four.files);
  ASSERT_EQ(one.tracks.objects.size(), 2u);
  expect_sane(one.tracks);
  EXPECT_NE(one.files.at("out/run.yaml").find("feedback: backend"), std::string::npos);
  EstimateOptions options;
  options.quiet = true;
  options.perception = temp.path() / "kept";
  const std::string message =
      input_error([&] { estimate(temp.path(), joined, options, temp.path() / "out"); });
  EXPECT_NE(message.find("feedback: backend"), std::string::npos) << message;
  EXPECT_FALSE(fs::exists(temp.path() / "out") || fs::exists(options.perception));
}

TEST(Robustness, ThirtyBodiesHaveTheSameBytesForAnyNumberOfThreads) {
  std::vector<Sprite> crowd;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2d home(8 + 52 * (i % 6), 6 + 47 * (i / 6));
    const double way = i % 2 ? 0.5 : -0.5;
    crowd.push_back({i + 1,
                     40U + static_cast<std::uint32_t>(i),
                     {40.F + 6 * static_cast<float>(i), 200.F - 5 * static_cast<float>(i), 90},
                     {40, 36},
                     1.5 + 0.05 * i,
                     [=](std::int64_t n) { return Eigen::Vector2d(home.x() + way * double(n), home.y()); }});
  }
  const TempFolder temp;
  write_drawn_sequence(temp.path(), crowd, 12);
  const Outcome one = run(temp.path(), 1), two = run(temp.path(), 2);
  EXPECT_EQ(one.tracks.objects.size(), 30u);
  expect_sane(one.tracks);
  EXPECT_EQ(one.files, two.files);
}

}  // namespace
}  // namespace uniquadric
