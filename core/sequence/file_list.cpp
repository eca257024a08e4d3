#include "core/sequence/file_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {
constexpr std::int64_t kMaxDepthOffsetNs = 20'000'000;
}  // namespace

std::vector<ListedFile> read_file_list(const std::filesystem::path& folder, const std::string& name,
                                       bool has_arrival) {
  const std::filesystem::path path = folder / name;
  std::vector<ListedFile> files;
  for_each_line(path, [&](int line, const std::vector<std::string_view>& fields) {
    if (fields.size() != (has_arrival ? 3u : 2u))
      throw InputError(path, line,
                       has_arrival ? "expected: timestamp filename arrival" : "expected: timestamp filename");
    ListedFile entry;
    try {
      entry.stamp_ns = parse_stamp_ns(fields[0]);
      entry.arrival_ns = has_arrival ? parse_stamp_ns(fields[2]) : entry.stamp_ns;
    } catch (const std::invalid_argument& e) {
      throw InputError(path, line, e.what());
    }
    entry.file = std::filesystem::path(fields[1]);
    if (!files.empty() && entry.stamp_ns <= files.back().stamp_ns)
      throw InputError(
          path, line,
          fmt::format("timestamp {} does not come after {}", fields[0], format_stamp(files.back().stamp_ns)));
    if (entry.file.is_absolute() || std::ranges::find(entry.file, "..") != entry.file.end())
      throw InputError(path, line, fmt::format("{} leads out of the folder", entry.file.string()));
    std::error_code too_long;
    if (!std::filesystem::is_regular_file(folder / entry.file, too_long))
      throw InputError(path, line, fmt::format("file {} is missing", entry.file.string()));
    files.push_back(entry);
  });
  return files;
}

void associate_depth(std::vector<SequenceFrame>& frames, const std::vector<ListedFile>& depth) {
  std::size_t next = 0;
  for (auto& frame : frames) {
    const auto distance = [&](std::size_t i) { return std::abs(depth[i].stamp_ns - frame.stamp_ns); };
    while (next + 1 < depth.size() && distance(next + 1) <= distance(next)) ++next;
    if (next >= depth.size() || distance(next) > kMaxDepthOffsetNs) continue;
    frame.depth = depth[next++].file;
  }
}

}  // namespace uniquadric
