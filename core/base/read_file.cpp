#include "core/base/read_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>

#include "core/base/error.h"

namespace uniquadric {
namespace fs = std::filesystem;

namespace {

void require_at_most(const fs::path& path, std::uintmax_t bytes, const FileBound& bound) {
  if (bytes > bound.most_bytes)
    throw InputError(
        path, fmt::format("is longer than {} MiB, the most of {}", bound.most_bytes >> 20, bound.kind));
}

}  // namespace

void require_regular_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) throw InputError(path, "is a folder, expected a file");
  if (!fs::status_known(status) || !fs::exists(status))
    throw InputError(path, fmt::format("cannot be read: {}", std::strerror(error ? error.value() : ENOENT)));
  if (!fs::is_regular_file(status)) throw InputError(path, "is not a regular file");
}

void require_file(const fs::path& path, const FileBound& bound) {
  require_regular_file(path);
  std::error_code error;
  if (const std::uintmax_t bytes = fs::file_size(path, error); !error) require_at_most(path, bytes, bound);
}

std::string read_file(const fs::path& path, const FileBound& bound) {
  require_file(path, bound);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, fmt::format("cannot be read: {}", std::strerror(errno)));
  std::error_code error;
  const std::uintmax_t told = fs::file_size(path, error);
  const std::size_t step = error ? 0 : std::min<std::uintmax_t>(told, bound.most_bytes);
  std::string text;
  while (in) {  // once and for all, unless it grows, or is one of /proc, which says it has no bytes
    const std::size_t begin = text.size(), more = begin == 0 ? step + 1 : std::size_t{1} << 16;
    text.resize(begin + more);
    in.read(text.data() + begin, static_cast<std::streamsize>(more));
    text.resize(begin + static_cast<std::size_t>(in.gcount()));
    require_at_most(path, text.size(), bound);
  }
  if (in.bad()) throw InputError(path, "read failed");
  return text;
}

}  // namespace uniquadric
