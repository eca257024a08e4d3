#pragma once

#include <filesystem>
#include <optional>

namespace uniquadric {

/// What a run took of the machine.
struct ResourceUsage {
  double wall_time_s = 0;
  double cpu_time_s = 0;      ///< user and system time of all its processes and threads
  double peak_memory_mb = 0;  ///< most resident memory at a time [10^6 bytes]
};

/// Name of the file in an estimate's or a perception's folder.
inline constexpr const char* kUsageFile = "usage.csv";

/// Writes the header `wall_time_s,cpu_time_s,peak_memory_mb` and a row into `folder`.
void write_usage(const std::filesystem::path& folder, const ResourceUsage& usage);

/// Nothing where the folder has no such file. Throws InputError with the line for another header or values
/// that are no finite numbers of at least 0.
std::optional<ResourceUsage> read_usage(const std::filesystem::path& folder);

/// One run after the other.
ResourceUsage operator+(const ResourceUsage& a, const ResourceUsage& b);

/// Measures this process from its construction on; memory since the process began, as the system counts it.
class UsageMeter {
 public:
  UsageMeter();
  ResourceUsage used() const;

 private:
  double wall_s_, cpu_s_;
};

}  // namespace uniquadric
