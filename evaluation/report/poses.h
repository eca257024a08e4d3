#pragma once

#include <filesystem>

#include "core/sequence/tracks.h"

namespace uniquadric {

/// What `evaluate` compared, in the truth's world. Objects of `estimate` bear the true objects' ids;
/// `unmatched` holds the tracks that belong to none, under their own.
struct ComparedPoses {
  Tracks truth, estimate, unmatched;
};

/// Reads poses.csv. Throws InputError with file and line.
ComparedPoses read_poses(const std::filesystem::path& file);

}  // namespace uniquadric
