#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace uniquadric {

/// A name for a recording that is plain in files: that of its folder, with _ for what is none of letters,
/// digits and _-. ; `recording` where the folder has no name.
std::string recording_name(const std::filesystem::path& recording);

/// One over the median interval of stamps in increasing order; `fallback_hz` for fewer than two.
double nominal_rate_hz(const std::vector<std::int64_t>& stamps_ns, double fallback_hz);

}  // namespace uniquadric
