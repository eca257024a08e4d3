#include "estimator/window/short_window.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr int kPoints = 30;

// Points of a body at rest 1.5 m before the camera, as frame `i` shows them.
struct Body {
  Camera camera;
  std::vector<Eigen::Vector3d> points;

  Body() {
    RandomStream random(1, "body");
    for (int k = 0; k < kPoints; ++k)
      points.push_back({random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(1.4, 1.6)});
  }

  PerceivedFrame frame(int i) const {
    PerceivedFrame frame;
    frame.frame = i;
    frame.stamp_ns = i * 400'000'000LL;  // each a keyframe
    frame.world_from_camera = Pose{};
    return frame;
  }

  BodyObservation seen() const {
    BodyObservation body;
    body.id = 1;
    body.silhouette.emplace();
    for (int k = 0; k < kPoints; ++k)
      body.features.push_back({k, *camera.project(points[k]), points[k].z(), 0.002});
    return body;
  }
};

// A track that slides onto another point, without depth there: its landmark is given up after three
// keyframes, and with it what older keyframes saw of it.
TEST(ShortWindow, ALandmarkThatIsGivenUpLeavesNoSightings) {
  const Body body;
  RandomStream random(2, "test");
  ShortWindow window(body.camera, {});
  window.start(body.frame(0), body.seen(), Pose{});
  for (int i = 1; i < 8; ++i) {
    BodyObservation seen = body.seen();
    if (i > 2) {
      seen.features[0].pixel.x() += 25;
      seen.features[0].depth_m = 0;
    }
    const auto found = window.find(body.frame(i), seen, Pose{}, false, random);
    ASSERT_TRUE(found);
    const BodyPose pose = window.take(body.frame(i), seen, *found);
    ASSERT_TRUE(pose.keyframe);
    EXPECT_LT(pose.world_from_body.translation.norm(), 1e-6);
  }
  for (const BodyKeyframe& keyframe : window.keyframes())
    for (const Feature& feature : keyframe.features) EXPECT_NE(feature.track, 0) << keyframe.frame;
}

}  // namespace
}  // namespace uniquadric
