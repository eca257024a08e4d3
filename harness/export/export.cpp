#include "harness/export/export.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/base/files.h"
#include "harness/export/export_source.h"
#include "harness/export/writers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

struct Format {
  const char* name;
  void (*write)(const ExportSource& source, const ExportOptions& options, const fs::path& folder);
  bool has_estimates = false;  // whether an estimate has a place in it
};

constexpr Format kFormats[] = {{"tum", write_tum_recording}, {"kitti-tracking", write_kitti_tracking},
                               {"bop", write_bop},           {"euroc", write_euroc},
                               {"rosbag", write_rosbag},     {"ply", write_ply_clouds},
                               {"vdo", write_vdo},           {"mcap", write_mcap, true}};

}  // namespace

std::vector<std::string> export_formats() {
  std::vector<std::string> names;
  for (const Format& format : kFormats) names.push_back(format.name);
  return names;
}

void export_sequence(const std::string& format, const fs::path& sequence, const fs::path& out,
                     const ExportOptions& options) {
  const auto* found = std::find_if(std::begin(kFormats), std::end(kFormats),
                                   [&](const Format& known) { return known.name == format; });
  if (found == std::end(kFormats))
    throw InputError(
        fmt::format("export format '{}' is none of {}", format, fmt::join(export_formats(), ", ")));
  if (!options.estimate.empty() && !found->has_estimates)
    throw InputError(fmt::format("export format '{}' has no place for an estimate; mcap has", format));
  const ExportSource source = open_export_source(sequence, options.truth);
  PendingFolder pending(out, "export", options.force);
  found->write(source, options, pending.path());
  pending.commit();
}

}  // namespace uniquadric
