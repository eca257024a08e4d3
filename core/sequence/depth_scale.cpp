#include "core/sequence/depth_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/quantile.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t kImages = 5;                   // ours: a wrong scale is that of them all
constexpr float kLeast_m = 0.01F, kMost_m = 100.0F;  // ours: wider than the range of any depth camera

void add_depths(const Sequence& sequence, const SequenceFrame& frame, std::vector<float>& depths_m) {
  try {
    const cv::Mat depth = read_depth(sequence, frame);
    std::copy_if(depth.begin<float>(), depth.end<float>(), std::back_inserter(depths_m),
                 [](float d) { return d > 0; });
  } catch (const InputError&) {
  }
}

}  // namespace

std::optional<std::string> depth_scale_fault(const Sequence& sequence) {
  std::vector<const SequenceFrame*> frames;
  for (const SequenceFrame& frame : sequence.frames)
    if (!frame.depth.empty()) frames.push_back(&frame);
  const std::size_t images = std::min(kImages, frames.size());
  std::vector<float> depths_m;
  for (std::size_t i = 0; i < images; ++i)
    add_depths(sequence, *frames[i * frames.size() / images], depths_m);
  if (depths_m.empty()) return std::nullopt;
  const float usual_m = upper_median(std::move(depths_m));
  if (usual_m >= kLeast_m && usual_m <= kMost_m) return std::nullopt;
  return fmt::format("depth.units_per_m: {} gives a median depth of {:.3g} m, expected {:g} to {:g} m",
                     sequence.depth_units_per_m, usual_m, kLeast_m, kMost_m);
}

std::optional<double> stated_depth_units_per_m(const fs::path& images) {
  const fs::path file = fs::is_directory(images) ? images / "any" : images;
  const fs::path folder = fs::absolute(file).lexically_normal().parent_path();
  for (const fs::path& place : {folder, folder.parent_path()}) {
    if (!fs::exists(place / "sequence.yaml")) continue;
    const auto depth = ConfigNode::load(place / "sequence.yaml").find("depth");
    return depth ? std::optional(depth->positive("units_per_m")) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace uniquadric
