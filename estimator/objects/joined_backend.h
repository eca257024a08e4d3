#pragma once

#include <cstdint>
#include <map>

#include "estimator/objects/body_estimator.h"
#include "estimator/observation/body_hints.h"

namespace uniquadric {

/// How what the back end knows is given to the tracking of features.
struct JoinedOptions {
  static constexpr double envelope_margin =
      0.2;  // ours: of the semi-axes; the model is a few percent off, a quadric more
  static constexpr double envelope_slack_m = 0.02;  // ours: what a prediction over one frame is off
};

/// The bodies' estimators as perception's feedback (paper: the objects' motion priors and their quadrics'
/// envelopes). Bodies are told of once they are confirmed and while they are tracked.
class JoinedBackend final : public BodyFeedback {
 public:
  JoinedBackend(const Camera& camera, const BodyOptions& bodies, const JoinedOptions& options,
                std::uint64_t seed)
      : camera_(camera), bodies_(bodies), options_(options), seed_(seed) {}

  BodyHints hints(std::int64_t frame, std::int64_t stamp_ns) override;
  void take(const PerceivedFrame& frame) override;

 private:
  struct Body {
    BodyEstimator estimator;
    std::optional<BodyState> state;  // of the last frame
  };

  Camera camera_;
  BodyOptions bodies_;
  JoinedOptions options_;
  std::uint64_t seed_;
  std::map<int, Body> by_id_;
  Trajectory recent_;  // of the camera: the last two frames
};

}  // namespace uniquadric
