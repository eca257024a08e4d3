#pragma once

#include <filesystem>
#include <string>

namespace uniquadric {

/// What a folder or file is (sequence, truth, estimate, evaluation, results, scene, variant, bench,
/// trajectory) and what it holds, as text. Reads it as the other commands do, so that their errors show here
/// too. Throws InputError for what is none of these.
std::string describe(const std::filesystem::path& path);

}  // namespace uniquadric
