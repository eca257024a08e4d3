#include "core/import/result.h"

#include <gtest/gtest.h>

#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

constexpr std::int64_t kFrame_ns = 100'000'000;

// Ten frames a second.
Sequence sequence_of(int frames) {
  Sequence sequence;
  for (int i = 0; i < frames; ++i) {
    sequence.frames.emplace_back().frame = i;
    sequence.frames.back().stamp_ns = i * kFrame_ns;
  }
  return sequence;
}

StampedPose pose_at(std::int64_t stamp_ns, double x) {
  StampedPose pose;
  pose.stamp_ns = stamp_ns;
  pose.pose.translation.x() = x;
  return pose;
}

TEST(Result, PosesGetTheStampsOfTheirFrames) {
  Tracks tracks;
  tracks.camera = {pose_at(40'000'000, 0), pose_at(149'000'000, 1), pose_at(310'000'000, 3)};
  ObjectTrack track{5, "", {}};
  track.states.emplace_back().stamp_ns = 299'000'000;
  tracks.objects = {track};
  const Tracks placed = at_frames(tracks, sequence_of(4), "mine");
  ASSERT_EQ(placed.camera.size(), 3u);
  EXPECT_EQ(placed.camera[0].stamp_ns, 0);
  EXPECT_EQ(placed.camera[1].stamp_ns, kFrame_ns);
  EXPECT_EQ(placed.camera[2].stamp_ns, 3 * kFrame_ns);
  ASSERT_EQ(placed.objects.size(), 1u);
  EXPECT_EQ(placed.objects[0].states[0].frame, 3);
  EXPECT_EQ(placed.objects[0].states[0].stamp_ns, 3 * kFrame_ns);
}

// Two for one frame: the nearer; beyond half a frame: for none.
TEST(Result, OnePoseAFrameWithinHalfAFrame) {
  Tracks tracks;
  tracks.camera = {pose_at(20'000'000, 1), pose_at(45'000'000, 2), pose_at(210'000'000, 3),
                   pose_at(400'000'000, 4)};
  const Tracks placed = at_frames(tracks, sequence_of(3), "mine");
  ASSERT_EQ(placed.camera.size(), 2u);
  EXPECT_EQ(placed.camera[0].pose.translation.x(), 1);
  EXPECT_EQ(placed.camera[1].pose.translation.x(), 3);
}

// As truths and exports have it: a scan's frame is at its end.
TEST(Result, WithoutImagesAFrameIsTheEndOfItsScan) {
  Sequence sequence;
  sequence.lidar.emplace().rate_hz = 10;
  for (int i = 0; i < 3; ++i) sequence.scans.push_back({i * kFrame_ns, ""});
  Tracks tracks;
  tracks.camera = {pose_at(104'000'000, 1), pose_at(300'000'000, 3)};
  const Tracks placed = at_frames(tracks, sequence, "mine");
  ASSERT_EQ(placed.camera.size(), 2u);
  EXPECT_EQ(placed.camera[0].stamp_ns, kFrame_ns);
  EXPECT_EQ(placed.camera[1].stamp_ns, 3 * kFrame_ns);
}

TEST(Result, OfAnotherSequenceIsRefused) {
  Tracks tracks;
  tracks.camera = {pose_at(5'000'000'000, 1)};
  EXPECT_EQ(input_error([&] { at_frames(tracks, sequence_of(3), "mine"); }),
            "mine: none of its 1 poses lies within half a frame of the sequence's stamps (0.000000000 to "
            "0.200000000 s): of "
            "another sequence, clock or unit");
  EXPECT_EQ(input_error([&] { at_frames({}, sequence_of(3), "mine"); }), "mine: holds no pose");
}

}  // namespace
}  // namespace uniquadric
