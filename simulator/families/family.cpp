#include "simulator/families/family.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/yaml_bounds.h"
#include "simulator/families/families.h"
#include "simulator/scene/realism.h"

namespace uniquadric {
namespace {

using Draw = std::string (*)(RandomStream&, const FamilyOptions&);
const std::vector<std::pair<std::string, Draw>> kFamilies = {{"tabletop", tabletop_scene},
                                                             {"tossed", tossed_scene},
                                                             {"handled", handled_scene},
                                                             {"street", street_scene},
                                                             {"room", room_scene}};
constexpr int kMostObjects = 100, kMostTossed = 12, kMostFrames = 100'000;

int whole(const ConfigNode& node, const std::string& key, int fallback, int low, int high) {
  const int value = node.get<int>(key, fallback);
  if (value < low || value > high)
    node.at(key).fail(fmt::format("expected {} to {}, found {}", low, high, value));
  return value;
}

FamilyOptions read_options(const FamilyRequest& request, double drawn_difficulty) {
  const ConfigNode node = ConfigNode::parse("{}", request.family, request.set);
  FamilyOptions options{request.family};
  options.difficulty = node.get<double>("difficulty", drawn_difficulty);
  if (!(options.difficulty >= 0 && options.difficulty <= 1)) node.at("difficulty").fail("expected 0 to 1");
  options.frames = whole(node, "frames", 300, 1, kMostFrames);
  const int most = request.family == "tossed" ? kMostTossed : kMostObjects;  // flights are slow to keep apart
  if (request.family != "room" && node.has("count")) options.count = whole(node, "count", 0, 1, most);
  if (request.family != "room" && request.family != "street")
    options.meshes = node.get<std::string>("meshes", "");
  if (request.family == "street")
    options.lidar = node.choice("lidar", {"livox_avia", "livox_mid360", "hdl64e", "os1_64", "vlp16"}, "");
  options.realism = read_realism(node);
  node.refuse_unknown_keys();
  return options;
}

Draw draw_of(const std::string& family) {
  const auto found = std::ranges::find(kFamilies, family, &std::pair<std::string, Draw>::first);
  if (found == kFamilies.end())
    throw InputError(
        fmt::format("there is no family '{}' (known: {})", family, fmt::join(family_names(), ", ")));
  return found->second;
}

// Long scenes of many objects have more way-points than a YAML file may hold.
void require_readable(const std::string& text, const FamilyRequest& request) {
  try {
    require_bounded_yaml(text, request.family);
  } catch (const InputError&) {
    const ConfigNode set = ConfigNode::parse("{}", request.family, request.set);
    set.at(set.has("frames") ? "frames" : "count")
        .fail("the scene would be larger than a YAML file may be; set fewer frames or a smaller count");
  }
}

}  // namespace

const std::vector<std::string>& family_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const auto& [name, draw] : kFamilies) all.push_back(name);
    return all;
  }();
  return names;
}

void check_request(const FamilyRequest& request) {
  draw_of(request.family);
  read_options(request, 0);
}

std::string generate_scene(const FamilyRequest& request) {
  const Draw draw = draw_of(request.family);
  RandomStream random(request.seed, "family " + request.family);
  FamilyOptions options = read_options(request, random.uniform());
  RandomStream lens(request.seed, "lens " + request.family);
  if (request.family != "street") options.lens = drawn_lens(lens);
  RandomStream noise(request.seed, "noise " + request.family);
  std::string text = fmt::format("{}{}, seed {}, difficulty {}.\n", kSceneHead, request.family, request.seed,
                                 yaml_number(options.difficulty, 3));
  text += fmt::format("name: {}_{}\nframes: {}\nrate_hz: 30\nrealism: {}\nnoise_seed: {}\ntexture: sparse\n",
                      request.family, request.seed, options.frames, options.realism, noise.bits());
  text += draw(random, options);
  require_readable(text, request);
  return text;
}

}  // namespace uniquadric
