// The depth that was recovered of features, through the whole of evaluate.
#include "evaluation/feature_depth.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "tests/evaluation/evaluate_fixture.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

constexpr const char* kHeader = "frame,timestamp_ns,body,track,u_px,v_px,depth_m,depth_sigma_m\n";

// z in the camera where a pixel's line of sight enters a box: by slabs.
std::optional<double> depth_of_box(const Pose& camera_from_box, const Eigen::Vector3d& half_m,
                                   const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d from = camera_from_box.inverse().translation,
                        ray = camera_from_box.rotation.conjugate() * *Camera{}.unproject(pixel);
  const Eigen::Array3d a = (-half_m - from).array() / ray.array(), b = (half_m - from).array() / ray.array();
  const double enters = a.min(b).maxCoeff(), leaves = a.max(b).minCoeff();
  return enters > 0 && enters < leaves ? std::optional(enters) : std::nullopt;
}

class FeatureDepth : public Evaluate {
 protected:
  // Of a box: a grid of pixels about its middle in each frame, `off_m` too deep; each third has none.
  void write_features(double off_m, int id = 1) {
    std::string text = kHeader;
    for (int i = 0; i < kFrames; ++i) {
      const Pose camera_from_box = camera_pose(i).inverse() * object_pose(id, i);
      const Eigen::Vector2d middle = *Camera{}.project(camera_from_box.translation);
      for (int k = 0; k < 49; ++k) {
        const Eigen::Vector2d pixel = middle + 15.0 * Eigen::Vector2d(k % 7 - 3, k / 7 - 3);
        const auto depth_m = depth_of_box(camera_from_box, kObjects[id - 1].semi_axes_m, pixel);
        depth_m ? ++on_ : ++off_;
        const bool has_depth = k % 3 != 0;
        recovered_ += depth_m && has_depth;
        text += fmt::format("{},{},{},{},{},{},", i, i * kPeriodNs, 10 * id, k, pixel.x(), pixel.y());
        text += has_depth ? fmt::format("{},0.01\n", depth_m.value_or(3) + off_m) : ",\n";
      }
    }
    write_text(estimate() / "features.csv", text);
  }
  std::uint64_t on_ = 0, off_ = 0, recovered_ = 0;
};

// The estimated poses are off, which the depth is not to blame for.
TEST_F(FeatureDepth, IsThatOfTheTrueSurfaceAlongTheLineOfSight) {
  write_changed([](Tracks& tracks) {
    for (auto& object : tracks.objects)
      for (auto& state : object.states)
        state.ellipsoid.world_from_object.translation += Eigen::Vector3d(0.05, 0, 0.04);
  });
  write_features(0.02);
  const json objects = run()["objects"];
  const json& depth = objects[0]["feature_depth"];
  constexpr double kSingle = 2e-6;  // [m] of rays in floats
  ASSERT_GT(on_, 500u);
  ASSERT_GT(off_, 100u);
  EXPECT_EQ(depth["sightings"], on_ + off_);
  EXPECT_EQ(depth["off_body"], off_);
  EXPECT_EQ(depth["error_m"]["n"], recovered_);
  EXPECT_DOUBLE_EQ(depth["coverage"], double(recovered_) / double(on_));
  EXPECT_NEAR(depth["error_m"]["min"], 0.02, kSingle);
  EXPECT_NEAR(depth["error_m"]["max"], 0.02, kSingle);
  EXPECT_NEAR(depth["error_m"]["quantile_90"], 0.02, kSingle);
  EXPECT_TRUE(objects[1]["feature_depth"].is_null());
}

// Rows are fewer than true objects where one is not scored.
TEST_F(FeatureDepth, IsThatOfTheObjectOfItsRow) {
  write_changed([](Tracks&) {});
  write_features(0.02, 2);
  std::vector<ObjectDescription> objects = kObjects;
  objects[0].is_scored = false;
  write_objects_yaml(truth() / "objects.yaml", objects);
  const json depth = run()["objects"][0]["feature_depth"];
  EXPECT_EQ(depth["off_body"], off_);
  EXPECT_NEAR(depth["error_m"]["max"], 0.02, 2e-6);
}

TEST_F(FeatureDepth, OfOtherTimesAndBodiesIsPassedOver) {
  write_changed([](Tracks&) {});
  write_text(estimate() / "features.csv",
             std::string(kHeader) + "0,900000000000,10,1,320,240,3,0.1\n0,0,77,1,320,240,3,0.1\n");
  const json objects = run()["objects"];
  for (const json& object : objects) EXPECT_TRUE(object["feature_depth"].is_null());
}

TEST_F(FeatureDepth, RowsThatAreNoneAreRefusedByLine) {
  write_changed([](Tracks&) {});
  const auto refused = [&](const std::string& rows, const std::string& what) {
    write_text(estimate() / "features.csv", rows);
    const std::string message = input_error([&] { run(); });
    EXPECT_NE(message.find("features.csv:" + what), std::string::npos) << message;
  };
  refused("frame,u,v\n", "1: expected the header");
  refused(kHeader + std::string("0,0,10,1,320,240,3\n"), "2: expected 8 columns, found 7");
  refused(kHeader + std::string("0,0,10,1,320,nan,3,0.1\n"), "2: 'nan' is no number");
  refused(kHeader + std::string("0,0,10,1,320,1e30,3,0.1\n"), "2: '1e30' is no number");
  refused(kHeader + std::string("0,0,10,1,,240,3,0.1\n"), "2: expected whole numbers, a pixel");
  refused(kHeader + std::string("0,0,1e3,1,320,240,3,0.1\n"), "2: expected whole numbers");
  refused(kHeader + std::string("0,0,99999999999,1,320,240,3,0.1\n"), "2: expected whole numbers");
  refused(kHeader + std::string("0,0,10,1,320,240,-3,0.1\n"), "2: expected whole numbers");
}

}  // namespace
}  // namespace uniquadric
