#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "core/base/error.h"
#include "core/base/text.h"
#include "simulator/families/scene_draft.h"
#include "simulator/scene/mesh_building.h"
#include "simulator/scene/mesh_import.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Eigen::Vector3d;

std::vector<fs::path> mesh_files(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw InputError(folder, "is no folder of meshes");
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    std::string ending = entry.path().extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
    if (ending == ".obj" || ending == ".ply" || ending == ".glb" || ending == ".dae" || ending == ".stl")
      files.push_back(entry.path());
  }
  for (const fs::path& file : files)
    if (file.string().find("${") != std::string::npos)
      throw InputError(file, "has ${ in its name, which a scene file takes for an environment variable");
  if (files.empty()) throw InputError(folder, "has no mesh (.obj, .ply, .glb, .dae, .stl)");
  std::ranges::sort(files);  // folders have no order of their own
  return files;
}

Thing draw_mesh(RandomStream& random, const fs::path& folder) {
  constexpr double kLeast_m = 0.02, kMost_m = 0.6;
  const fs::path file = one_of(random, mesh_files(folder));
  Thing thing{"mesh", fmt::format("    mesh: {}\n", yaml_quoted(fs::absolute(file).string())), {}};
  thing.size_m = tight_box(import_mesh(file).meshes).sizes();
  if (!(thing.size_m.minCoeff() > 0))
    throw InputError(file, "is flat: an object needs an extent along every axis");
  if (!(thing.size_m.maxCoeff() >= kLeast_m && thing.size_m.maxCoeff() <= kMost_m))
    throw InputError(file, fmt::format("measures {:.3g} m: expected {} to {} m. Is it in metres?",
                                       thing.size_m.maxCoeff(), kLeast_m, kMost_m));
  return thing;
}

// Round to a tenth of a millimetre, as it is written.
Vector3d draw_size(RandomStream& random, const std::string& kind) {
  const auto between = [&](double low, double high) {
    return std::round(1e4 * random.uniform(low, high)) / 1e4;
  };
  if (kind == "box") return {between(0.12, 0.20), between(0.05, 0.09), between(0.16, 0.28)};
  if (kind == "book") return {between(0.18, 0.28), between(0.12, 0.20), between(0.02, 0.05)};
  if (kind == "block") return {between(0.06, 0.16), between(0.06, 0.16), between(0.05, 0.14)};
  if (kind == "angle") return {between(0.12, 0.2), between(0.05, 0.1), between(0.1, 0.18)};
  if (kind == "mug") {
    const double across = between(0.075, 0.1);
    return {std::round(1.35e4 * across) / 1e4, across, between(0.085, 0.12)};
  }
  const double across = kind == "bowl"  ? between(0.13, 0.2)
                        : kind == "can" ? between(0.06, 0.10)
                                        : between(0.05, 0.08);
  const double high = kind == "bowl"  ? between(0.05, 0.08)
                      : kind == "can" ? between(0.08, 0.14)
                                      : between(0.18, 0.28);
  return {across, across, high};
}

std::string primitive_of(const std::string& kind) {
  if (kind == "can" || kind == "bottle") return "cylinder";
  return kind == "mug" || kind == "bowl" || kind == "angle" ? kind : "rounded_box";
}

}  // namespace

Thing draw_thing(RandomStream& random, const FamilyOptions& options) {
  if (!options.meshes.empty()) return draw_mesh(random, options.meshes);
  const std::string kind =
      one_of<std::string>(random, {"box", "can", "book", "block", "bottle", "mug", "bowl", "angle"});
  Thing thing{kind, {}, draw_size(random, kind)};
  const std::string primitive = primitive_of(kind);
  thing.keys = fmt::format("    primitive: {}\n    size_m: {}\n", primitive, yaml_vector(thing.size_m));
  if (primitive == "rounded_box")
    thing.keys += fmt::format("    radius_m: {}\n", yaml_number(0.03 * thing.size_m.minCoeff()));
  thing.keys += fmt::format("    material: {}\n", drawn_material(random, options.difficulty));
  return thing;
}

}  // namespace uniquadric
