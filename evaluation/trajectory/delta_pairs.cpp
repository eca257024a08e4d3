#include "evaluation/trajectory/delta_pairs.h"

#include <cassert>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "evaluation/trajectory/pose_error.h"

namespace uniquadric {
namespace {

std::vector<IndexStep> frame_steps(std::size_t count, std::size_t delta, bool all_pairs) {
  std::vector<IndexStep> steps;
  for (std::size_t i = 0; i + delta < count; i += all_pairs ? 1 : delta) steps.push_back({i, i + delta});
  return steps;
}

using Distance =
    std::function<double(std::size_t, std::size_t)>;  // from pose i to pose j > i, in delta's unit

Distance distance_in(DeltaUnit unit, const std::vector<Pose>& poses,
                     const std::vector<std::int64_t>& stamps_ns) {
  if (unit == DeltaUnit::metres)
    return [along = path_lengths_m(poses)](std::size_t i, std::size_t j) { return along[j] - along[i]; };
  if (unit == DeltaUnit::seconds)
    return
        [&](std::size_t i, std::size_t j) { return static_cast<double>(stamps_ns[j] - stamps_ns[i]) * 1e-9; };
  return [&](std::size_t i, std::size_t j) {
    const Eigen::Matrix3d turn = (poses[i].rotation.conjugate() * poses[j].rotation).toRotationMatrix();
    return rotation_angle(turn) * 180 / std::numbers::pi;
  };
}

// The pose after i that is nearest to delta. Path and time only grow, so that the search may end past them;
// an angle may shrink again: there the first run of poses within the tolerance is searched, and a pose beyond
// it ends the search, also one that is the first to pass delta at all.
std::optional<std::size_t> step_end(std::size_t i, std::size_t count, const DeltaOptions& options,
                                    const Distance& distance) {
  const double tolerance = options.tolerance * options.delta;
  std::optional<std::size_t> best;
  double least = tolerance;
  for (std::size_t j = i + 1; j < count; ++j) {
    const double off = distance(i, j) - options.delta;
    if (std::abs(off) < least || (!best && std::abs(off) <= least)) {
      best = j;
      least = std::abs(off);
    }
    if (off > tolerance || (best && std::abs(off) > tolerance)) break;
  }
  return best;
}

constexpr std::pair<DeltaUnit, const char*> kUnits[] = {{DeltaUnit::frames, "f"},
                                                        {DeltaUnit::metres, "m"},
                                                        {DeltaUnit::seconds, "s"},
                                                        {DeltaUnit::degrees, "deg"}};

}  // namespace

const char* to_string(DeltaUnit unit) {
  for (const auto& [known, name] : kUnits)
    if (known == unit) return name;
  return "";
}

std::optional<Delta> parse_delta(std::string_view text) {
  for (const auto& [unit, name] : kUnits) {
    if (!text.ends_with(name)) continue;
    const auto value = parse_double(text.substr(0, text.size() - std::string_view(name).size()));
    if (value && *value > 0 && (unit != DeltaUnit::frames || *value == std::floor(*value)))
      return Delta{*value, unit};
  }
  return std::nullopt;
}

std::vector<IndexStep> delta_steps(const std::vector<Pose>& poses, const std::vector<std::int64_t>& stamps_ns,
                                   const DeltaOptions& options) {
  assert(poses.size() == stamps_ns.size());
  if (!(options.delta > 0) || !std::isfinite(options.delta)) throw InputError("delta must be greater than 0");
  if (options.unit == DeltaUnit::frames) {
    if (options.delta != std::floor(options.delta))
      throw InputError("delta in frames must be a whole number");
    if (options.delta >= static_cast<double>(poses.size())) return {};  // 2^64 and more fit no index
    return frame_steps(poses.size(), static_cast<std::size_t>(options.delta), options.all_pairs);
  }
  const Distance distance = distance_in(options.unit, poses, stamps_ns);
  std::vector<IndexStep> steps;
  for (std::size_t i = 0; i < poses.size();) {
    const auto j = step_end(i, poses.size(), options, distance);
    if (j) steps.push_back({i, *j});
    i = j && !options.all_pairs ? *j : i + 1;
  }
  return steps;
}

}  // namespace uniquadric
