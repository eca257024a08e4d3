#include "core/base/apart.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"

namespace uniquadric {
namespace fs = std::filesystem;
namespace {

fs::path resolved(const fs::path& path) {
  const fs::path whole = fs::weakly_canonical(fs::absolute(path));
  return whole.has_filename() ? whole : whole.parent_path();  // without a slash at its end
}

bool holds(const fs::path& folder, const fs::path& path) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

}  // namespace

void require_apart(const fs::path& out, const std::vector<fs::path>& inputs) {
  if (out.empty()) return;
  const fs::path target = resolved(out);
  for (const fs::path& input : inputs) {
    if (input.empty()) continue;
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
