#include <gtest/gtest.h>

#include <map>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/calibration.h"
#include "estimator/perception/perception_files.h"
#include "synthetic_perception.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

SyntheticPerception two_frames() {
  SyntheticOptions options;
  options.frames = 2;
  options.world_from_camera = [](double t) { return Pose{Eigen::Quaterniond::Identity(), {0, 0, t}}; };
  const SyntheticBody box = box_body({0.3, 0.2, 0.1}, [](double) {
    return Pose{exp_so3({0.3, 0.5, 0.1}), {0.1, 0.1, 2}};
  });
  SyntheticPerception perception = synthetic_perception({box}, options);
  perception.frames[1].bodies[0].motion = exp_se3((Vector6d() << 1, 2, 3, 0.1, 0.2, 0.3).finished());
  perception.frames[1].bodies[0].contact = ContactPlane{{0, 0.6, -0.8}, 1.5, 0.002};
  perception.frames[1].world_from_camera.reset();
  perception.frames[0].lagged_camera = Pose{exp_so3({0.1, 0, 0}), {1, 2, 3}};
  perception.frames[0].final_camera = Pose{exp_so3({0, 0.1, 0}), {4, 5, 6}};
  perception.frames[1].bodies[0].colors = Eigen::Matrix3Xf::Constant(3, 7, 42.5F);
  perception.frames[1].bodies[0].features.back().rim = true;
  perception.frames[0].has_masks = true;
  perception.frames[1].depth_refused = true;
  perception.frames[0].depth_changed = true;
  perception.frames[0].bodies[0].silhouette->support[3].free = false;
  Silhouette late = *perception.frames[0].bodies[0].silhouette;
  late.segmented = true;
  late.known_at_frame = 1;
  perception.frames[0].bodies[0].segmented = late;
  return perception;
}

void write(const fs::path& folder, const std::vector<PerceivedFrame>& frames, const Camera& camera) {
  fs::create_directories(folder);
  PerceptionWriter out(folder, camera, {"its key", "its sequence", "its hash"});
  CameraTrajectories camera_path;
  for (const PerceivedFrame& frame : frames) {
    out.add(frame);
    if (frame.world_from_camera && !frame.camera_came_late)
      camera_path.causal.push_back({frame.stamp_ns, *frame.world_from_camera});
    if (frame.lagged_camera) camera_path.fixed_lag.push_back({frame.stamp_ns, *frame.lagged_camera});
    if (frame.final_camera) camera_path.final.push_back({frame.stamp_ns, *frame.final_camera});
  }
  out.finish(camera_path, 2, DepthBias{0.006, 0.0005}, 6);
}

void read_all(const fs::path& folder) {
  const Perception perception(folder);
  for (std::size_t i = 0; i < perception.frames().size(); ++i) perception.read(i);
}

TEST(PerceptionFiles, ReadBackAndWrittenAgainTheyAreTheSameBytes) {
  const TempFolder temp;
  const fs::path first = temp.path() / "first", second = temp.path() / "second";
  const SyntheticPerception perception = two_frames();
  write(first, perception.frames, perception.camera);
  const Perception back(first);
  ASSERT_EQ(back.frames().size(), 2u);
  const std::vector<PerceivedFrame> frames{back.read(0), back.read(1)};
  write(second, frames, back.camera());
  for (const char* file : {"observations.bin", "camera.tum", "camera.yaml", "perception.yaml"})
    EXPECT_EQ(read_text(first / file), read_text(second / file)) << file;
  EXPECT_EQ(back.source().key, "its key");
  EXPECT_EQ(back.source().sequence, "its sequence");
  EXPECT_EQ(back.source().sequence_hash, "its hash");
  EXPECT_TRUE(back.frames()[0].has_masks);
  EXPECT_FALSE(back.frames()[1].has_masks);
  EXPECT_FALSE(back.frames()[0].depth_refused);
  EXPECT_TRUE(back.frames()[1].depth_refused);
  EXPECT_TRUE(back.frames()[0].depth_changed);
  EXPECT_FALSE(back.frames()[1].depth_changed);
  EXPECT_EQ(back.ego_restarts(), 2);
  EXPECT_EQ(back.depth_bias()->per_m, 0.006);
  EXPECT_EQ(back.depth_bias()->sigma_per_m, 0.0005);
  EXPECT_EQ(back.depth_edge_width_px(), 6);
  EXPECT_EQ(frames[0].world_from_camera->translation, perception.frames[0].world_from_camera->translation);
  EXPECT_EQ(frames[0].lagged_camera->translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(frames[0].final_camera->translation, Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(frames[0].camera_came_late);
  EXPECT_FALSE(frames[1].world_from_camera);
  const BodyObservation &a = perception.frames[1].bodies[0], &b = frames[1].bodies[0];
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.colors, b.colors);
  EXPECT_EQ(a.features.back().pixel, b.features.back().pixel);
  EXPECT_FALSE(b.features.front().rim);
  EXPECT_TRUE(b.features.back().rim);
  EXPECT_EQ(a.motion->translation, b.motion->translation);
  EXPECT_EQ(a.contact->normal, b.contact->normal);
  EXPECT_EQ(a.contact->offset_m, b.contact->offset_m);
  EXPECT_EQ(a.contact->noise_m, b.contact->noise_m);
  EXPECT_EQ(a.silhouette->rot_bbox.angle_rad, b.silhouette->rot_bbox.angle_rad);
  EXPECT_FALSE(frames[0].bodies[0].silhouette->support[3].free);
  ASSERT_TRUE(frames[0].bodies[0].segmented);
  EXPECT_EQ(frames[0].bodies[0].segmented->known_at_frame, 1);
  EXPECT_FALSE(frames[1].bodies[0].segmented);
}

TEST(PerceptionFiles, SayWhyTheyCannotBeWritten) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  const TempFolder temp;
  fs::create_symlink("/dev/full", temp.path() / "observations.bin");
  try {
    PerceptionWriter(temp.path(), Camera(), {"key", "", ""});
    ADD_FAILURE() << "written";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("observations.bin: cannot be written: No space left"),
              std::string::npos)
        << e.what();
  }
}

TEST(PerceptionFiles, KnowTheirOwn) {
  const TempFolder temp;
  const SyntheticPerception perception = two_frames();
  write(temp.path(), perception.frames, perception.camera);
  fs::create_directories(temp.path() / "masks");
  for (const char* own : {"timing.csv", "masks/000001.png", "masks/1234567.png"})
    write_text(temp.path() / own, "");
  EXPECT_TRUE(foreign_files(temp.path()).empty());
  for (const char* other : {"notes.txt", "masks/000001.jpg", "masks/a.png"})
    write_text(temp.path() / other, "");
  EXPECT_EQ(foreign_files(temp.path()),
            (std::vector<fs::path>{"masks/000001.jpg", "masks/a.png", "notes.txt"}));
}

TEST(PerceptionFiles, ANumberOfFramesThatTheyAreNotIsRefused) {
  const TempFolder temp;
  const SyntheticPerception perception = two_frames();
  write(temp.path() / "kept", perception.frames, perception.camera);
  const fs::path file = temp.path() / "kept" / "perception.yaml";
  std::string text = read_text(file);
  text.replace(text.find("frames: 2"), 9, "frames: 5");
  write_text(file, text);
  EXPECT_THROW(Perception(temp.path() / "kept"), InputError);
}

TEST(PerceptionFiles, AnotherCameraThanTheirsIsRefused) {
  const TempFolder temp;
  const SyntheticPerception perception = two_frames();
  write(temp.path() / "kept", perception.frames, perception.camera);
  const fs::path file = temp.path() / "kept/camera.yaml";
  Camera other = read_camera_yaml(file);
  other.fx *= 1.01;
  write_camera_yaml(file, other);
  EXPECT_NE(input_error([&] { Perception(temp.path() / "kept"); }).find("camera.yaml: has changed"),
            std::string::npos);
}

TEST(PerceptionFiles, DamagedFilesAreRefusedWhereverTheyEndOrDiffer) {
  const TempFolder temp;
  const SyntheticPerception perception = two_frames();
  write(temp.path(), perception.frames, perception.camera);
  EXPECT_NO_THROW(read_all(temp.path()));
  const fs::path file = temp.path() / "observations.bin";
  const std::string whole = read_text(file);
  for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 300) {
    write_text(file, whole.substr(0, at));
    EXPECT_THROW(read_all(temp.path()), InputError) << at;
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0x40);
    write_text(file, changed);
    EXPECT_THROW(read_all(temp.path()), InputError) << at;
  }
}

}  // namespace
}  // namespace uniquadric
