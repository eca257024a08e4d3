#include "core/base/resource_usage.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr const char* kHeader = "wall_time_s,cpu_time_s,peak_memory_mb";

double clock_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

void write_usage(const fs::path& folder, const ResourceUsage& usage) {
  write_text(folder / kUsageFile, fmt::format("{}\n{:.3f},{:.3f},{:.1f}\n", kHeader, usage.wall_time_s,
                                              usage.cpu_time_s, usage.peak_memory_mb));
}

std::optional<ResourceUsage> read_usage(const fs::path& folder) {
  const fs::path file = folder / kUsageFile;
  if (!fs::exists(file)) return std::nullopt;
  int row = 0;
  double values[3] = {};
  for_each_line(
      file,
      [&](int line, const std::vector<std::string_view>& fields) {
        if (row == 0 && fields != split(kHeader, ','))
          throw InputError(file, line, fmt::format("expected the header {}", kHeader));
        if (row == 1 && fields.size() != std::size(values))
          throw InputError(file, line, fmt::format("expected 3 columns, found {}", fields.size()));
        for (std::size_t i = 0; row == 1 && i < std::size(values); ++i) {
          const auto value = parse_double(fields[i]);
          if (!value || *value < 0)
            throw InputError(file, line, fmt::format("'{}' is no number of at least 0", fields[i]));
          values[i] = *value;
        }
        ++row;
      },
      ',');
  if (row != 2) throw InputError(file, "expected a header and one row");
  return ResourceUsage{values[0], values[1], values[2]};
}

ResourceUsage operator+(const ResourceUsage& a, const ResourceUsage& b) {
  return {a.wall_time_s + b.wall_time_s, a.cpu_time_s + b.cpu_time_s,
          std::max(a.peak_memory_mb, b.peak_memory_mb)};
}

UsageMeter::UsageMeter() : wall_s_(clock_s(CLOCK_MONOTONIC)), cpu_s_(clock_s(CLOCK_PROCESS_CPUTIME_ID)) {}

ResourceUsage UsageMeter::used() const {
  rusage process{};
  getrusage(RUSAGE_SELF, &process);
  return {clock_s(CLOCK_MONOTONIC) - wall_s_, clock_s(CLOCK_PROCESS_CPUTIME_ID) - cpu_s_,
          static_cast<double>(process.ru_maxrss) * 1024e-6};
}

}  // namespace uniquadric
