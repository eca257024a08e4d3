#include "core/base/config.h"
#include "estimator/variant.h"
#include "fuzz/target.h"
#include "harness/bench/config.h"
#include "simulator/lidar/lidar_reader.h"
#include "simulator/scene/scene.h"

namespace uniquadric::fuzz {
namespace {
namespace fs = std::filesystem;

// All that yaml-cpp hands over, wherever it stands.
void walk(const ConfigNode& node) {
  if (node.is_map())
    for (const auto& [key, value] : node.entries()) walk(value);
  else if (node.is_sequence())
    for (const ConfigNode& item : node.items()) walk(item);
  else if (node.is_scalar())
    node.as<std::string>();
}
const Target yaml("yaml", "any.yaml", [](const fs::path& file) { walk(ConfigNode::load(file)); });

const Target scene("scene_yaml", "scene.yaml", [](const fs::path& file) {
  beside(file, "mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n");
  beside(file, "pattern.csv", "Time/s,Azimuth/deg,Zenith/deg\n0,0,90\n0.001,1,90\n");
  const Scene read = load_scene(file);
  std::vector<fs::path> files;
  if (read.lidar) read_lidar(*read.lidar, files);
});

const Target variant("variant_yaml", "variant.yaml", [](const fs::path& file) { load_variant(file); });

const Target bench("bench_yaml", "bench.yaml", [](const fs::path& file) {
  for (const char* other : {"a.yaml", "b.yaml"}) beside(file, other, "");
  bench_yaml(load_bench_config(file), file.parent_path());
});

}  // namespace
}  // namespace uniquadric::fuzz
