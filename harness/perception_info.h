#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace uniquadric {

/// Whether a folder is a kept perception (docs/formats.md).
bool is_perception(const std::filesystem::path& folder);

/// What it holds, as text: key, camera, frames and bodies. Throws InputError.
std::string describe_perception(const std::filesystem::path& folder);

/// Reads all of it: a line for each thing that is damaged, missing or none of its files; none when all is
/// well.
std::vector<std::string> check_perception(const std::filesystem::path& folder);

}  // namespace uniquadric
