#include "core/sequence/visibility.h"

#include <fmt/format.h>

#include <limits>

#include "core/base/error.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {

const char* const kHeader = "frame,timestamp_ns,id,visible_px,silhouette_px,visible_fraction,touches_border";

}  // namespace

VisibilityTable read_visibility(const std::filesystem::path& path) {
  VisibilityTable table;
  const std::vector<std::string_view> columns = split(kHeader, ',');
  bool is_header = true;
  const auto read_line = [&](int line, const std::vector<std::string_view>& fields) {
    if (std::exchange(is_header, false)) {
      if (fields != columns) throw InputError(path, line, fmt::format("expected the header {}", kHeader));
      return;
    }
    if (fields.size() != columns.size())
      throw InputError(path, line,
                       fmt::format("expected {} columns, found {}", columns.size(), fields.size()));
    const auto fail = [&](std::size_t i) {
      throw InputError(path, line,
                       fmt::format("column {}: '{}' is not a valid value", columns[i], fields[i]));
    };
    const auto count = [&](std::size_t i, std::int64_t most) {
      const auto value = parse_integer(fields[i]);
      if (!value || *value < 0 || *value > most) fail(i);
      return static_cast<std::int64_t>(*value);
    };
    constexpr std::int64_t kAny = std::numeric_limits<std::int64_t>::max();
    const std::pair key(count(0, kAny), static_cast<int>(count(2, std::numeric_limits<int>::max())));
    const auto fraction = parse_double(fields[5]);
    if (!fraction || *fraction < 0 || *fraction > 1) fail(5);
    const ObjectVisibility row{count(3, kAny), count(4, kAny), *fraction, count(6, 1) == 1};
    if (!table.emplace(key, row).second)
      throw InputError(path, line, fmt::format("frame {}, object {} stands twice", key.first, key.second));
  };
  for_each_line(path, read_line, ',');
  if (is_header) throw InputError(path, "is empty, expected a header");
  return table;
}

std::map<int, int> count_ids(const cv::Mat& masks) {
  std::map<int, int> pixels;
  for (int v = 0; v < masks.rows; ++v)
    for (int u = 0; u < masks.cols; ++u) ++pixels[masks.at<std::uint16_t>(v, u)];
  pixels.erase(0);
  return pixels;
}

}  // namespace uniquadric
