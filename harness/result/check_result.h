#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace uniquadric {

/// What a look at a result found.
struct ResultCheck {
  std::string text;                     ///< what is there and what will be scored, for people
  std::vector<std::string> suspicions;  ///< what looks wrong, a line each, naming the file
};

/// Looks at an estimate folder as a program wrote it. With `sequence` (a folder, or empty) it says which
/// poses lie at its frames; with `truth` (a folder, or empty) lengths, sizes and conventions of poses are
/// judged by it, else those of poses by the sequence's given camera. Throws InputError for what cannot be
/// read; where the stamps' unit may be why, the message says so.
ResultCheck check_result(const std::filesystem::path& folder, const std::filesystem::path& sequence,
                         const std::filesystem::path& truth);

}  // namespace uniquadric
