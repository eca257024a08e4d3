#include "core/base/apart.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"

namespace uniquadric {
namespace fs = std::filesystem;
namespace {

fs::path resolved(const fs::path& path) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(fs::absolute(path), error);
  if (error) throw InputError(path, fmt::format("cannot be resolved: {}", error.message()));
  return whole.has_filename() ? whole : whole.parent_path();  // without a slash at its end
}

// Reading from a pipe or a terminal, as <(...) of a shell gives one, is over when writing begins.
bool is_pipe(const fs::path& path) {
  std::error_code error;
  const fs::file_type type = fs::status(path, error).type();
  return type == fs::file_type::fifo || type == fs::file_type::character || type == fs::file_type::socket;
}

}  // namespace

bool holds(const fs::path& folder, const fs::path& path) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

void require_apart(const fs::path& out, const std::vector<fs::path>& inputs) {
  if (out.empty()) return;
  const fs::path target = resolved(out);
  for (const fs::path& input : inputs) {
    if (input.empty() || is_pipe(input)) continue;
    const fs::path source = resolved(input);
    const char* how = target == source        ? "is"
                      : holds(target, source) ? "holds"
                      : holds(source, target) ? "lies inside"
                                              : nullptr;
    if (how)
      throw InputError(out,
                       fmt::format("{} the input {}; give another place to write to", how, input.string()));
  }
}

}  // namespace uniquadric
