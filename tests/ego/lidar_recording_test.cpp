// Recordings with a LiDAR, as real ones are, through estimate().
#include <gtest/gtest.h>

#include "core/base/files.h"
#include "core/sequence/tracks.h"
#include "estimator/estimate.h"
#include "tests/ego/room_recording.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Variant lidar_variant() {
  Variant variant;
  variant.perception.ego = EgoSource::lidar;
  variant.perception.aot.enabled = false;
  return variant;
}

Variant lidar_only_variant() {
  return load_variant(fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/lidar_only.yaml");
}

Tracks estimated(const fs::path& sequence, const Variant& variant, const fs::path& out) {
  EstimateOptions options;
  options.quiet = options.force = true;
  options.threads = 1;
  estimate(sequence, variant, options, out);
  return read_tracks(out);
}

class LidarRecording : public testing::Test {
 protected:
  LidarRecording() {
    recording_.room.range_sigma_m = 0.01;
    recording_.room.points = 8000;
    recording_.room.pattern = LidarRoom::Pattern::forward;
    recording_.room.start_ns = 20'000'000'000;
  }
  Tracks estimated(const Variant& variant) {
    write_recording(temp_.path() / "sequence", recording_);
    return uniquadric::estimated(temp_.path() / "sequence", variant, temp_.path() / "out");
  }
  std::string written() const {
    return read_text(temp_.path() / "out/camera.tum") + read_text(temp_.path() / "out/objects.csv");
  }

  TempFolder temp_;
  RoomRecording recording_;
};

// Ego motion, depth of a body under its mask, and bodies of a LiDAR alone.
TEST_F(LidarRecording, ClocksThatAreApartAreOneByTheOptions) {
  constexpr std::int64_t kLidar_ns = 3'000'000'000, kImu_ns = -40'000'000;
  for (const bool has_images : {true, false}) {
    recording_.has_images = recording_.has_imu = has_images;
    recording_.room.mover_half_m = has_images ? Eigen::Vector3d::Zero() : Eigen::Vector3d(0.7, 0.5, 0.6);
    recording_.room.mover_start_m = {5, -1.4, -1.88};
    recording_.room.mover_velocity_mps = {-1.5, 0.3, 0};
    recording_.room.vigour = has_images ? 1 : 0.3;
    Variant variant = has_images ? lidar_variant() : lidar_only_variant();
    variant.perception.scan_objects.clusters.tolerance_m = 0.3;
    variant.perception.scan_objects.clusters.max_extent_m = 4;
    recording_.lidar_clock_ns = recording_.imu_clock_ns = 0;
    const Tracks plain = estimated(variant);
    EXPECT_FALSE(plain.objects.empty()) << has_images;
    EXPECT_GT(plain.camera.size(), 15u) << has_images;
    const std::string expected = written();
    recording_.lidar_clock_ns = kLidar_ns, recording_.imu_clock_ns = kImu_ns;
    variant.perception.lidar_time_offset_ns = kLidar_ns;
    variant.perception.lidar.imu_time_offset_ns = kImu_ns;
    estimated(variant);
    EXPECT_EQ(written(), expected) << has_images;
  }
}

}  // namespace
}  // namespace uniquadric
