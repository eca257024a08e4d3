#include "harness/estimate_text.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "core/sequence/tracks.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

ObjectTrack track_of(int id, int states, ObjectMotion motion) {
  ObjectTrack track{id, "", {}};
  for (int i = 0; i < states; ++i) {
    ObjectState state;
    state.frame = i;
    state.stamp_ns = i * 100;
    state.ellipsoid.semi_axes_m = {0.1, 0.2, 0.3};
    track.states.push_back(state);
  }
  track.states.back().motion = motion;
  return track;
}

TEST(EstimateText, SaysWhatWasFoundAndWhatFramesLack) {
  const TempFolder temp;
  Tracks tracks;
  for (int i = 0; i < 20; ++i) tracks.camera.push_back({i * 100, Pose{}});
  tracks.objects = {track_of(3, 4, ObjectMotion::moving), track_of(7, 12, ObjectMotion::at_rest),
                    track_of(12, 2, ObjectMotion::moving)};
  tracks.objects[1].states[5].status = tracks.objects[1].states[6].status = ObjectStatus::occluded;
  tracks.objects[1].states[7].status = ObjectStatus::lost;
  write_estimate(temp.path(), tracks);
  const auto text_with = [&](int without_pose) {
    write_text(temp.path() / "run.yaml",
               "frames: 20\nframes_without_pose: " + std::to_string(without_pose) +
                   "\nframes_without_depth: 2\nframes_without_masks: 3\nvariant:\n  name: some\n");
    return estimate_text(temp.path());
  };
  EXPECT_EQ(text_with(1),
            "object  frames  occluded   motion\n"
            "3            4         0  dynamic\n"
            "7           11         2   static\n"
            "12           2         0  dynamic\n"
            "3 objects with states: 1 static, 2 dynamic, 0 undecided\n"
            "20 frames, 1 without pose, 2 without depth, 3 without masks\n");
  tracks.objects.clear();
  std::filesystem::remove_all(temp.path() / "objects");
  write_estimate(temp.path(), tracks);
  EXPECT_EQ(text_with(0),
            "no object with states\n20 frames, 0 without pose, 2 without depth, 3 without masks\n");
  write_text(temp.path() / "run.yaml",
             "frames: 39\nframes_are: scans\nframes_without_pose: 13\nframes_without_depth: 0\n"
             "frames_without_masks: 13\nvariant:\n  name: some\n");
  EXPECT_EQ(estimate_text(temp.path()), "no object with states\n39 scans, 13 without pose\n");
}

}  // namespace
}  // namespace uniquadric
