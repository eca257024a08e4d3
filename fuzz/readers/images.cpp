#include <libdeflate.h>

#include <fstream>
#include <sstream>

#include "core/sequence/sequence.h"
#include "evaluation/metrics/octree_file.h"
#include "fuzz/target.h"
#include "simulator/scene/mesh_import.h"

namespace uniquadric::fuzz {
namespace {
namespace fs = std::filesystem;

// With the checksums that its chunks should have: else no change of a PNG gets past them.
void mend_checksums(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  std::string bytes = std::move(text).str();
  const auto at = [&](std::size_t i) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i]));
  };
  for (std::size_t i = 8; i + 12 <= bytes.size();) {
    const std::size_t size = at(i) << 24 | at(i + 1) << 16 | at(i + 2) << 8 | at(i + 3);
    if (size > bytes.size() - i - 12) break;
    const std::uint32_t checksum = libdeflate_crc32(0, bytes.data() + i + 4, size + 4);
    for (int k = 0; k < 4; ++k) bytes[i + 8 + size + k] = static_cast<char>(checksum >> 8 * (3 - k));
    i += size + 12;
  }
  std::ofstream(file, std::ios::binary) << bytes;
}

const Target png("png", "image.png", [](const fs::path& file) {
  mend_checksums(file);
  read_image(file);
});
const Target jpeg("jpeg", "image.jpg", [](const fs::path& file) { read_image(file); });
const Target octree("octree_bt", "map.bt", [](const fs::path& file) { read_octree(file); });
const Target ply("mesh_ply", "mesh.ply", [](const fs::path& file) { import_mesh(file); });
const Target obj("mesh_obj", "mesh.obj", [](const fs::path& file) { import_mesh(file); });

}  // namespace
}  // namespace uniquadric::fuzz
