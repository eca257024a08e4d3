#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/sequence/sequence.h"

namespace uniquadric {

/// One line of a list of files (rgb.txt, depth.txt, masks.txt).
struct ListedFile {
  std::int64_t stamp_ns = 0;
  std::int64_t arrival_ns = 0;  ///< of masks.txt; elsewhere the stamp
  std::filesystem::path file;   ///< relative to the list's folder
};

/// Reads `name` in `folder`: lines `timestamp filename`, with `has_arrival` `timestamp filename arrival`.
/// Throws InputError with the line for malformed lines, stamps that do not increase and files that are
/// missing or lead out of the folder.
std::vector<ListedFile> read_file_list(const std::filesystem::path& folder, const std::string& name,
                                       bool has_arrival);

/// Gives each frame the nearest depth image within 0.02 s (TUM RGB-D's rule), each image at most once.
void associate_depth(std::vector<SequenceFrame>& frames, const std::vector<ListedFile>& depth);

}  // namespace uniquadric
