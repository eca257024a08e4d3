#pragma once

#include <filesystem>
#include <string>

namespace uniquadric {

/// What an estimate holds, as lines of plain text: a table of the objects with states, frames (or scans, of a
/// LiDAR alone) with what they lack (as run.yaml counts it), and of the objects how many are static and
/// dynamic, as their last states say. Throws InputError for a folder that is no estimate of this program.
std::string estimate_text(const std::filesystem::path& estimate);

}  // namespace uniquadric
