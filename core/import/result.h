#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"

namespace uniquadric {

/// The times at which a sequence observes [ns]: those of its frames, or, without images, the ends of its
/// scans.
std::vector<std::int64_t> observed_ns(const Sequence& sequence);

/// How far from an observation a stamp may lie and still belong to it: half a frame [ns].
std::int64_t half_frame_ns(const std::vector<std::int64_t>& observed_ns);

/// Layouts of results of other programs (docs/own_system.md): native, tum, kitti-tracking, bop.
std::vector<std::string> result_layouts();

/// Reads what a program wrote about a sequence and gives each pose the stamp and number of its frame (or
/// scan): that nearest in time within half a frame. Of several poses for one frame the nearest counts, of
/// poses for none no one, and both are warned of. Throws InputError for files that cannot be read, and for a
/// result none of whose poses lies at a frame of the sequence.
Tracks read_result(const std::filesystem::path& source, const std::string& layout, const Sequence& sequence);

/// The same of tracks that are read already; `name` says in messages whose they are.
Tracks at_frames(const Tracks& tracks, const Sequence& sequence, const std::string& name);

}  // namespace uniquadric
