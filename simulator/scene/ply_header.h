#pragma once

#include <filesystem>
#include <string_view>

namespace uniquadric {

/// Throws InputError with file and line when the header of a PLY file announces more vertices, faces or other
/// elements than the rest of the file can hold (a byte each in binary, a figure and a line end in ascii), or
/// when its header or its rows of text are not those of PLY: assimp works through what is announced, whether
/// it is there or not. `bytes` are the file's; other files than PLY, told by their first three letters, pass,
/// but not under the name .ply: assimp looks for a header in them, of some for ever.
void check_ply_header(std::string_view bytes, const std::filesystem::path& path);

}  // namespace uniquadric
