// What is written of a body as it was known at its frames, and a lag later.
#include "estimator/objects/known_states.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/base/random.h"
#include "synthetic_perception.h"

namespace uniquadric {
namespace {

constexpr std::int64_t kStep_ns = 33'333'333, kLag_ns = 1'000'000'000;
constexpr double kNoise_m = 0.002;

// A body on a path, its poses with noise; `offset_m` of a frame: how far along x its centre was taken to be.
std::vector<RawState> raw_states(
    int frames, const std::function<Eigen::Vector3d(double)>& path,
    const std::function<double(int)>& offset_m = [](int) { return 0.0; }, double noise_m = kNoise_m) {
  RandomStream random(1, "known_states");
  std::vector<RawState> raw(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) {
    auto& [state, frame] = raw[static_cast<std::size_t>(i)];
    state.frame = frame.frame = i;
    state.stamp_ns = frame.stamp_ns = i * kStep_ns;
    state.world_from_body.translation = path(1e-9 * static_cast<double>(i * kStep_ns));
    for (int k = 0; k < 3; ++k) state.world_from_body.translation[k] += noise_m * random.normal();
    state.covariance = kNoise_m * kNoise_m * Matrix6d::Identity();
    state.shape.body_from_object.translation.x() = offset_m(i);
    state.status = ObjectStatus::active;
    frame.world_from_camera = frame.lagged_camera = frame.final_camera = Pose();
  }
  return raw;
}

Eigen::Vector3d swing(double t) {
  return {0.3 * std::sin(2 * t), 0.1 * t, 2};
}

double rmse_m(const std::vector<BodyState>& states, const std::function<Eigen::Vector3d(double)>& path) {
  double squares = 0;
  for (const BodyState& state : states)
    squares +=
        (state.world_from_body.translation - path(1e-9 * static_cast<double>(state.stamp_ns))).squaredNorm();
  return std::sqrt(squares / static_cast<double>(states.size()));
}

TEST(KnownStates, NoiseIsLessAtTheFrameAndLeastALagLater) {
  const std::vector<RawState> raw = raw_states(200, swing);
  const double noise_m = std::sqrt(3.0) * kNoise_m;
  const double causal_m = rmse_m(states_known_after(0, raw, {}), swing),
               lagged_m = rmse_m(states_known_after(kLag_ns, raw, {}), swing);
  EXPECT_LT(causal_m, 0.9 * noise_m);
  EXPECT_LT(lagged_m, 0.6 * causal_m);
}

// Nothing comes after the newest pose that could say whether it is an outlier.
TEST(KnownStates, AJumpIsFollowedAtItsFrame) {
  const auto jump = [](double t) { return Eigen::Vector3d(t < 2 ? 0 : 0.2, 0, 2); };
  for (const BodyState& state : states_known_after(0, raw_states(120, jump), {}))
    EXPECT_LT((state.world_from_body.translation - jump(1e-9 * static_cast<double>(state.stamp_ns))).norm(),
              5 * kNoise_m)
        << state.frame;
}

TEST(KnownStates, AShapeThatIsFoundOtherwiseIsTakenStepByStep) {
  constexpr double kOffset_m = 0.02;
  const auto still = [](double) { return Eigen::Vector3d(0, 0, 2); };
  const auto raw = raw_states(
      120, still, [](int i) { return i < 60 ? 0 : kOffset_m; }, 0);
  TrajectorySmootherOptions options;
  const auto x = [&](int i) {
    return states_known_after(0, raw, options)[static_cast<std::size_t>(i)].world_from_body.translation.x();
  };
  const double share = -std::expm1(-1e-9 * kStep_ns / options.settle_s);
  EXPECT_NEAR(x(59), 0, 1e-6);
  EXPECT_NEAR(x(60), share * kOffset_m, 1e-4);
  EXPECT_NEAR(x(119), kOffset_m, 1e-4);
  options.settle_s = 0;
  EXPECT_NEAR(x(60), kOffset_m, 1e-4);
}

// What is known at a time does not depend on what comes after it.
TEST(KnownStates, AreThoseOfARunThatEndsThen) {
  SyntheticOptions options;
  options.world_from_camera = [](double) { return Pose(); };
  const auto path = [](double t) {
    return Pose{exp_so3({0.2 * t, 0.1, 0.5 * t}), Eigen::Vector3d(-0.3 + 0.2 * t, 0.1 * t, 2)};
  };
  const SyntheticPerception perception =
      synthetic_perception({box_body(Eigen::Vector3d(0.3, 0.2, 0.15), path)}, options);
  BodyEstimator estimator(1, perception.camera, {}, 1);
  std::vector<RawState> raw;
  for (const PerceivedFrame& frame : perception.frames)
    if (auto state = estimator.step(frame, &frame.bodies.at(0))) raw.push_back({*state, frame});
  ASSERT_GT(raw.size(), 40u);
  const std::vector<RawState> shorter(raw.begin(), raw.begin() + 30);
  for (const std::int64_t lag_ns : {0L, 300'000'000L}) {
    const auto all = states_known_after(lag_ns, raw, {}), known = states_known_after(lag_ns, shorter, {});
    std::size_t compared = 0;
    for (std::size_t k = 0; k < known.size(); ++k) {
      if (known[k].stamp_ns + lag_ns > shorter.back().state.stamp_ns) continue;
      ++compared;
      EXPECT_EQ(all[k].world_from_body.translation, known[k].world_from_body.translation) << k;
      EXPECT_EQ(all[k].shape.semi_axes_m, known[k].shape.semi_axes_m) << k;
    }
    EXPECT_GE(compared, 15u);
  }
}

}  // namespace
}  // namespace uniquadric
