#include "core/import/kitti_files.h"
#include "core/sequence/lidar.h"
#include "core/sequence/pcd.h"
#include "core/sequence/ply.h"
#include "fuzz/target.h"
#include "simulator/lidar/scan_pattern.h"

namespace uniquadric::fuzz {
namespace {

const Target pcd("pcd", "scan.pcd", [](const std::filesystem::path& file) {
  read_pcd(file);
  read_lidar_points(file);
});

const Target surface("surface_ply", "surface.ply",
                     [](const std::filesystem::path& file) { read_surface_ply(file); });

const Target kitti_scan("kitti_scan", "000000.bin",
                        [](const std::filesystem::path& file) { read_kitti_scan(file, 100'000'000); });

const Target csv_pattern_table("csv_pattern", "pattern.csv", [](const std::filesystem::path& file) {
  const ScanPattern pattern = csv_pattern(file);
  BeamBlock block;
  pattern.fill(pattern.first_at(1'000'000'000), 16, block);
});

}  // namespace
}  // namespace uniquadric::fuzz
