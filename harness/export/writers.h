#pragma once

#include <filesystem>

namespace uniquadric {

struct ExportOptions;
struct ExportSource;

// One function a format, each writing into an existing empty folder. Layouts, conventions and losses are
// documented in docs/export.md, the formats' own definitions cited in the sources.
void write_tum_recording(const ExportSource& source, const ExportOptions& options,
                         const std::filesystem::path& folder);
void write_kitti_tracking(const ExportSource& source, const ExportOptions& options,
                          const std::filesystem::path& folder);
void write_bop(const ExportSource& source, const ExportOptions& options, const std::filesystem::path& folder);
void write_euroc(const ExportSource& source, const ExportOptions& options,
                 const std::filesystem::path& folder);
void write_rosbag(const ExportSource& source, const ExportOptions& options,
                  const std::filesystem::path& folder);
void write_mcap(const ExportSource& source, const ExportOptions& options,
                const std::filesystem::path& folder);
void write_vdo(const ExportSource& source, const ExportOptions& options, const std::filesystem::path& folder);
void write_ply_clouds(const ExportSource& source, const ExportOptions& options,
                      const std::filesystem::path& folder);

}  // namespace uniquadric
