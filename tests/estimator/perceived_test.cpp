// What perception hands over of a whole sequence, and as of when.
#include <gtest/gtest.h>

#include <map>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "drawn_sequence.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

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

// The tracker of masks has a frame's depth before its scale is found to be another, and other threads read it
// after: it stays as it was. By it the body beside the red one is farther away, and hides nothing of it,
// which an image without depth would leave open.
TEST(Robustness, ARefusedDepthStaysWhatTheTrackerOfMasksSaw) {
  const TempFolder temp;
  const Sprite behind{2,        12, {180, 60, 50},
                      {60, 90}, 3,  [](std::int64_t) { return Eigen::Vector2d(130, 60); }};
  const Sequence sequence = write_drawn_sequence(temp.path(), {kRed, behind}, 24, [](DrawnFrame& drawn) {
    if (drawn.frame.frame >= 10 && drawn.frame.frame < 16) drawn.depth *= 1.04;
  });
  PerceptionOptions options;
  options.ego = EgoSource::rgbd;
  const Perception perception = perceived(sequence, options);
  int checked = 0;
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_EQ(perception.frames()[i].depth_refused, i >= 10 && i < 16) << i;
    if (!perception.frames()[i].depth_refused) continue;
    for (const BodyObservation& body : perception.read(i).bodies) {
      if (body.id != 1 || !body.segmented) continue;
      EXPECT_TRUE(body.segmented->bbox[0].free) << i;
      ++checked;
    }
  }
  EXPECT_EQ(checked, 2);  // frames 12 and 15
}

// The red body moves, the other one does not.
TEST(Robustness, WithoutMasksWhatMovesIsFound) {
  const TempFolder temp;
  const Sprite still{2,        12, {180, 60, 50},
                     {50, 40}, 2,  [](std::int64_t) { return Eigen::Vector2d(220, 160); }};
  const Sequence sequence = write_drawn_sequence(temp.path(), {kRed, still}, 24);
  PerceptionOptions options;
  options.ego = EgoSource::given;
  options.segmentation.source = "depth_motion";
  options.aot.enabled = false;
  const Perception perception = perceived(sequence, options);
  for (std::size_t i = 0; i < 24; ++i) {
    const PerceivedFrame frame = perception.read(i);
    // Since two earlier images it went by a fifth of its width.
    EXPECT_EQ(frame.bodies.size(), i < 15 ? 0u : 1u) << i;
    for (const BodyObservation& body : frame.bodies) {
      ASSERT_TRUE(body.silhouette) << i;
      const double red_at = 60 + 2.0 * static_cast<double>(i);
      EXPECT_NEAR(-body.silhouette->bbox[2].offset_px, red_at, 1) << i;
    }
  }
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

}  // namespace
}  // namespace uniquadric
