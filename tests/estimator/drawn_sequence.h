#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "drawn_world.h"
#include "estimator/estimate.h"
#include "estimator/perception/perceive.h"

namespace uniquadric {

namespace fs = std::filesystem;

inline constexpr int kLatencyFrames = 3;  ///< of the masks
using Damage = std::function<void(DrawnFrame&)>;

/// A body that goes to the right.
extern const Sprite kRed;

/// Writes and returns a sequence of drawn frames with given poses of a camera at rest, each as `damage`
/// leaves it.
Sequence write_drawn_sequence(const fs::path& folder, const std::vector<Sprite>& sprites, int frames,
                              const Damage& damage = {}, const Camera& camera = drawn_camera());

/// The dual sliding window, all else by default.
Variant windows(EgoSource ego = EgoSource::given);

/// Sees it in a folder below the sequence's.
Perception perceived(const Sequence& sequence, const PerceptionOptions& options,
                     const char* name = "perception");

struct Outcome {
  Tracks tracks;
  std::map<std::string, std::string> files;  ///< but the times
};

Outcome run(const fs::path& folder, int threads = 2, const Variant& variant = windows());

/// Every number that a state gives is one, and no body is thin as nothing or as large as the room.
void expect_sane(const Tracks& tracks);

}  // namespace uniquadric
