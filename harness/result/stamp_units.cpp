#include "harness/result/stamp_units.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "core/base/text.h"
#include "evaluation/statistics/statistics.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// ours: no sensor or keyframes are slower than one pose in 5 s, or faster than 1000 a second
constexpr double kLongestStep_s = 5, kShortestStep_ns = 1e6;

// The column of a header line; 0 where the name is not there.
std::size_t column_of(const std::vector<std::string_view>& header, std::string_view name) {
  const auto place = std::ranges::find(header, name);
  return place == header.end() ? 0 : static_cast<std::size_t>(place - header.begin());
}

std::vector<double> read_stamps(const fs::path& file) {
  const bool is_csv = file.extension() == ".csv";
  std::vector<double> stamps;
  std::size_t column = 0;
  for_each_line(
      file,
      [&](int line, const std::vector<std::string_view>& fields) {
        if (is_csv && line == 1) column = column_of(fields, "timestamp_ns");
        const auto stamp = column < fields.size() ? parse_double(fields[column]) : std::nullopt;
        if (stamp) stamps.push_back(*stamp);
      },
      is_csv ? ',' : ' ');
  return stamps;
}

// Between neighbours in time; of fewer than two stamps nothing.
std::optional<double> median_step(std::vector<double> stamps) {
  std::ranges::sort(stamps);
  stamps.erase(std::ranges::unique(stamps).begin(), stamps.end());
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i) steps.push_back(stamps[i] - stamps[i - 1]);
  if (steps.empty()) return std::nullopt;
  return interpolated_quantile(std::move(steps), 0.5);
}

const char* unit_of_seconds_step(double step) {
  return step < kLongestStep_s ? nullptr
         : step < 5e3          ? "milliseconds"
         : step < 5e6          ? "microseconds"
                               : "nanoseconds";
}

const char* unit_of_ns_step(double step) {
  return step >= kShortestStep_ns ? nullptr
         : step < 1               ? "seconds"
         : step < 1e3             ? "milliseconds"
                                  : "microseconds";
}

std::vector<fs::path> stamped_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const char* name : {"camera.tum", "objects.csv"})
    if (fs::is_regular_file(folder / name)) files.push_back(folder / name);
  if (fs::is_directory(folder / "objects"))
    for (const auto& entry : fs::directory_iterator(folder / "objects"))
      if (entry.path().extension() == ".tum") files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

}  // namespace

std::vector<std::string> stamp_unit_faults(const fs::path& folder) {
  std::vector<std::string> faults;
  for (const fs::path& file : stamped_files(folder)) {
    const auto step = median_step(read_stamps(file));
    if (!step) continue;
    const bool is_csv = file.extension() == ".csv";
    const char* unit = is_csv ? unit_of_ns_step(*step) : unit_of_seconds_step(*step);
    if (unit)
      faults.push_back(fmt::format("{}: stamps step by {:.4g}: they look like {}, expected are {}",
                                   file.string(), *step, unit, is_csv ? "nanoseconds" : "seconds"));
  }
  return faults;
}

}  // namespace uniquadric
