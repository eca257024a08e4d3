#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/sequence/sequence.h"

namespace uniquadric {

/// What is wrong with a sequence's depth scale: the median depth of up to five of its depth images, evenly
/// spaced, lies beyond 100 m or below 1 cm, which no depth camera measures. Nothing where there is no depth;
/// images that cannot be read are left to who reads them all.
std::optional<std::string> depth_scale_fault(const Sequence& sequence);

/// `depth.units_per_m` of the sequence.yaml in the folder of a depth image (of a folder of them: in it), or
/// else in the one above; nothing without such a file, or where it says nothing of depth. Throws InputError
/// for a file that cannot be read.
std::optional<double> stated_depth_units_per_m(const std::filesystem::path& images);

}  // namespace uniquadric
