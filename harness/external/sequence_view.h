#pragma once

#include <filesystem>
#include <vector>

#include "harness/external/external_variant.h"

namespace uniquadric {

/// The entries of a sequence folder that a variant may see: all but its list of hashes and, unless it asks
/// for it, the camera's poses as another system knows them. Throws InputError for links, which could lead
/// anywhere.
std::vector<std::filesystem::path> visible_entries(const std::filesystem::path& sequence,
                                                   const ExternalVariant& variant);

/// What {sequence} is, made below `folder`: a copy of those entries, or an export of them in the variant's
/// layout. Nothing of the truth is in it. Returns the folder made.
std::filesystem::path make_sequence_view(const std::filesystem::path& sequence,
                                         const ExternalVariant& variant, const std::filesystem::path& folder);

}  // namespace uniquadric
