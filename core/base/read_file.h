#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace uniquadric {

/// The most bytes that a file of one kind has; a longer one is a mistake, or made to fill the memory.
struct FileBound {
  std::size_t most_bytes;
  const char* kind;  ///< for messages: "a text file"
};

// ours: some times the longest that a recording or a report has
inline constexpr FileBound kTextFile{std::size_t{512} << 20, "a text file"};
inline constexpr FileBound kYamlFile{std::size_t{16} << 20, "a YAML file"};
inline constexpr FileBound kImageFile{std::size_t{512} << 20, "an image"};
inline constexpr FileBound kMeshFile{std::size_t{1} << 30, "a mesh file"};
inline constexpr FileBound kScanFile{std::size_t{256} << 20, "a scan"};
inline constexpr FileBound kPointFile{std::size_t{1} << 31, "a file of points"};

/// Throws InputError unless `path` leads to a regular file: not to a folder, pipe, device or socket.
void require_regular_file(const std::filesystem::path& path);

/// Throws as require_regular_file, and for a file longer than its bound.
void require_file(const std::filesystem::path& path, const FileBound& bound);

/// The whole file. Throws InputError as require_file, and when it cannot be read.
std::string read_file(const std::filesystem::path& path, const FileBound& bound);

}  // namespace uniquadric
