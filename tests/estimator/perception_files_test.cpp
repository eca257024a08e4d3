#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/files.h"
#include "estimator/perception/perception.h"
#include "synthetic_perception.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Perception two_frames() {
  SyntheticOptions options;
  options.frames = 2;
  options.world_from_camera = [](double t) { return Pose{Eigen::Quaterniond::Identity(), {0, 0, t}}; };
  const SyntheticBody box = box_body({0.3, 0.2, 0.1}, [](double) {
    return Pose{exp_so3({0.3, 0.5, 0.1}), {0.1, 0.1, 2}};
  });
  Perception perception = synthetic_perception({box}, options);
  perception.frames[1].bodies[0].motion = exp_se3((Vector6d() << 1, 2, 3, 0.1, 0.2, 0.3).finished());
  perception.frames[1].world_from_camera.reset();
  perception.frames[0].has_masks = true;
  perception.frames[0].bodies[0].silhouette->support[3].free = false;
  Silhouette late = *perception.frames[0].bodies[0].silhouette;
  late.segmented = true;
  late.known_at_frame = 1;
  perception.frames[0].bodies[0].segmented = late;
  return perception;
}

TEST(PerceptionFiles, ReadBackAndWrittenAgainTheyAreTheSameBytes) {
  const TempFolder temp;
  const fs::path first = temp.path() / "first", second = temp.path() / "second";
  for (const fs::path& folder : {first, second}) fs::create_directories(folder);
  const Perception perception = two_frames();
  write_perception(first, perception);
  const Perception back = read_perception(first);
  write_perception(second, back);
  for (const char* file : {"observations.bin", "camera.tum", "camera.yaml", "perception.yaml"})
    EXPECT_EQ(read_text(first / file), read_text(second / file)) << file;
  ASSERT_EQ(back.frames.size(), 2u);
  EXPECT_EQ(back.key, "synthetic");
  EXPECT_FALSE(back.frames[1].world_from_camera);
  const BodyObservation &a = perception.frames[1].bodies[0], &b = back.frames[1].bodies[0];
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.features.back().pixel, b.features.back().pixel);
  EXPECT_EQ(a.motion->translation, b.motion->translation);
  EXPECT_EQ(a.silhouette->rot_bbox.angle_rad, b.silhouette->rot_bbox.angle_rad);
  EXPECT_FALSE(back.frames[0].bodies[0].silhouette->support[3].free);
  ASSERT_TRUE(back.frames[0].bodies[0].segmented);
  EXPECT_EQ(back.frames[0].bodies[0].segmented->known_at_frame, 1);
  EXPECT_FALSE(back.frames[1].bodies[0].segmented);
}

TEST(PerceptionFiles, DamagedFilesAreRefusedWhereverTheyEnd) {
  const TempFolder temp;
  write_perception(temp.path(), two_frames());
  const fs::path file = temp.path() / "observations.bin";
  const std::string whole = read_text(file);
  int refused = 0;
  for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 50) {
    write_text(file, whole.substr(0, size));
    EXPECT_THROW(read_perception(temp.path()), InputError) << size;
    ++refused;
  }
  EXPECT_GE(refused, 50);
  std::string greedy = whole;
  for (int i = 8; i < 16; ++i) greedy[i] = '\x7f';  // more frames than fit in any memory
  write_text(file, greedy);
  EXPECT_THROW(read_perception(temp.path()), InputError);
}

}  // namespace
}  // namespace uniquadric
