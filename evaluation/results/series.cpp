#include "evaluation/results/series.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

std::optional<double> parse_optional(const fs::path& file, int line, std::string_view column,
                                     std::string_view field) {
  if (field.empty()) return std::nullopt;
  const auto value = parse_double(field);
  if (!value)
    throw InputError(file, line, fmt::format("column {}: '{}' is not a finite number", column, field));
  return value;
}

// Adds the rows of frames.csv to the series of their objects.
class FramesReader {
 public:
  FramesReader(fs::path file, const std::vector<NamedObject>& objects)
      : file_(std::move(file)), objects_(objects) {
    for (const NamedObject& object : objects) series_.push_back({object.subject, {}, {}, {}, object.id});
  }

  std::vector<ObjectSeries> read() {
    for_each_line(
        file_,
        [this](int line, const std::vector<std::string_view>& fields) {
          header_.empty() ? read_header(line, fields) : read_row(line, fields);
        },
        ',');
    if (header_.empty()) throw InputError(file_, "is empty, expected a header");
    return std::move(series_);
  }

 private:
  void read_header(int line, const std::vector<std::string_view>& fields) {
    header_.assign(fields.begin(), fields.end());
    for (const char* required : {"frame", "timestamp_ns", "object_id"})
      if (column(required) == header_.size())
        throw InputError(file_, line, fmt::format("expected a header with the column {}", required));
    frame_ = column("frame"), stamp_ = column("timestamp_ns"), id_ = column("object_id");
    for (std::size_t i = 0; i < header_.size(); ++i)
      if (i != frame_ && i != stamp_ && i != id_ && header_[i] != "name" && header_[i] != "matched_id")
        values_.push_back(i);
  }

  void read_row(int line, const std::vector<std::string_view>& fields) {
    if (fields.size() != header_.size())
      throw InputError(file_, line,
                       fmt::format("expected {} columns, found {}", header_.size(), fields.size()));
    const auto integer = [&](std::size_t i) {
      const auto value = parse_integer(fields[i]);
      if (!value)
        throw InputError(file_, line, fmt::format("column {}: '{}' is no integer", header_[i], fields[i]));
      return *value;
    };
    const auto object =
        std::find_if(objects_.begin(), objects_.end(), [&](const auto& o) { return o.id == integer(id_); });
    if (object == objects_.end())
      throw InputError(file_, line, fmt::format("object {} is not in evaluation.json", fields[id_]));
    ObjectSeries& series = series_[static_cast<std::size_t>(object - objects_.begin())];
    if (const auto stamp = integer(stamp_); !series.stamps_ns.empty() && stamp <= series.stamps_ns.back())
      throw InputError(file_, line,
                       fmt::format("timestamp {} does not come after {}", stamp, series.stamps_ns.back()));
    series.frames.push_back(integer(frame_));
    series.stamps_ns.push_back(integer(stamp_));
    for (const std::size_t i : values_)
      series.columns[header_[i]].push_back(parse_optional(file_, line, header_[i], fields[i]));
  }

  std::size_t column(std::string_view name) const {
    return static_cast<std::size_t>(std::find(header_.begin(), header_.end(), name) - header_.begin());
  }

  fs::path file_;
  const std::vector<NamedObject>& objects_;
  std::vector<ObjectSeries> series_;
  std::vector<std::string> header_;
  std::vector<std::size_t> values_;
  std::size_t frame_ = 0, stamp_ = 0, id_ = 0;
};

}  // namespace

std::vector<ObjectSeries> read_series(const fs::path& file, const std::vector<NamedObject>& objects) {
  return FramesReader(file, objects).read();
}

}  // namespace uniquadric
