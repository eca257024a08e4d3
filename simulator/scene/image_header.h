#pragma once

#include <filesystem>
#include <string_view>

namespace uniquadric {

/// Throws InputError when an image file's header announces more than 8192 pixels a side: decoded, a few
/// kilobytes of PNG can fill the memory. Reads PNG and JPEG headers; what other formats announce is known
/// only to their decoder, which has a limit of its own (OpenCV: 2^30 pixels).
void check_texture_size(std::string_view bytes, const std::filesystem::path& path);

/// The same for pixels at hand.
void check_texture_size(int width, int height, const std::filesystem::path& path);

}  // namespace uniquadric
