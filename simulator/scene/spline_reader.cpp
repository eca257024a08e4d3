#include "simulator/scene/spline_reader.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/warning.h"
#include "core/sequence/trajectory.h"
#include "simulator/scene/named_motions.h"
#include "simulator/scene/path_reader.h"
#include "simulator/scene/spline.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kMostOvershoot = 0.2;      // ours, of the distance between way-points
constexpr double kLeastOvershoot_m = 1e-3;  // ours: nobody sees less

/// A spline from rest to rest.
struct Stretch {
  std::vector<Waypoint> waypoints;
  std::size_t first = 0;  ///< the first one's place in the list
};

std::vector<Stretch> read_stretches(const ConfigNode& node, Mover mover) {
  std::vector<Stretch> stretches(1);
  const auto target = node.find("look_at_m");
  const std::vector<ConfigNode> items = node.at("waypoints").items();
  for (std::size_t k = 0; k < items.size(); ++k) {
    const ConfigNode& item = items[k];
    const auto position = item.get<Vector3d>("position_m");
    const double time_s = item.get<double>("time_s");
    const auto& earlier = stretches.back().waypoints;
    if (!earlier.empty() && time_s <= earlier.back().time_s)
      item.fail(fmt::format(
          "time_s {} does not follow {}{}", time_s, earlier.back().time_s,
          k > 0 && items[k - 1].has("hold_s") ? ", the end of the hold_s of the way-point before" : ""));
    const Pose pose{read_orientation(item, mover, position, target), position};
    stretches.back().waypoints.push_back({time_s, pose});
    if (item.has("hold_s")) {
      if (stretches.back().waypoints.size() == 1) stretches.pop_back();  // it begins with a rest
      stretches.push_back({{{time_s + item.positive("hold_s"), pose}}, k});
    }
    item.refuse_unknown_keys();
  }
  const bool ends_with_rest = stretches.size() > 1 && stretches.back().waypoints.size() == 1;
  if (ends_with_rest) stretches.pop_back();
  return stretches;
}

/// How far a spline leaves the box that two neighbouring way-points' positions span.
struct Overshoot {
  std::size_t waypoint = 0;  ///< the later one's place in the list
  double out_m = 0, apart_m = 0;
  double excess_m() const { return out_m - kMostOvershoot * apart_m; }
};

Overshoot overshoot(const Motion& motion, const Waypoint& a, const Waypoint& b, std::size_t place) {
  constexpr int kSamples = 16;
  const Vector3d from = a.world_from_body.translation, to = b.world_from_body.translation;
  Eigen::AlignedBox3d box(from);
  box.extend(to);
  Overshoot result{place, 0, (to - from).norm()};
  for (int k = 1; k < kSamples; ++k) {
    const double time_s = std::lerp(a.time_s, b.time_s, static_cast<double>(k) / kSamples);
    result.out_m = std::max(result.out_m, box.exteriorDistance(motion.at(time_s).translation));
  }
  return result;
}

void warn_of_overshoot(const ConfigNode& node, const std::vector<Stretch>& stretches,
                       const std::vector<Motion>& parts) {
  Overshoot worst;
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t k = 1; k < stretches[i].waypoints.size(); ++k) {
      const auto& waypoints = stretches[i].waypoints;
      const Overshoot found = overshoot(parts[i], waypoints[k - 1], waypoints[k], stretches[i].first + k);
      if (found.excess_m() > worst.excess_m()) worst = found;
    }
  if (worst.excess_m() < kLeastOvershoot_m) return;
  const ConfigNode item = node.at("waypoints").items()[worst.waypoint];
  warn(
      fmt::format("{}:{}: way-point {}: on the way there from {:.3g} m off the spline swings out by {:.3g} m "
                  "(time the way-points evenly, or give hold_s)",
                  item.file().string(), item.line(), worst.waypoint, worst.apart_m, worst.out_m));
}

}  // namespace

Motion read_spline(const ConfigNode& node, Mover mover) {
  const std::vector<Stretch> stretches = read_stretches(node, mover);
  const bool may_overshoot = node.get<bool>("may_overshoot", false);
  node.refuse_unknown_keys();
  std::vector<Motion> parts;
  std::vector<double> starts_s;
  try {
    for (const Stretch& stretch : stretches) {
      parts.push_back(spline_motion(stretch.waypoints));
      starts_s.push_back(stretch.waypoints.front().time_s);
    }
  } catch (const InputError& error) {
    node.fail(error.what());
  }
  if (!may_overshoot) warn_of_overshoot(node, stretches, parts);
  return parts.size() == 1 ? parts.front() : successive_motion(std::move(parts), std::move(starts_s));
}

Motion read_recorded(const ConfigNode& node, std::vector<std::filesystem::path>& files, double end_s) {
  const ConfigNode file = node.at("file");
  files.push_back(find_file(file));
  const double start_s = node.get<double>("start_s", 0);
  std::vector<Waypoint> record;
  const Trajectory poses = read_tum(files.back());
  for (const StampedPose& p : poses)
    record.push_back({start_s + static_cast<double>(p.stamp_ns - poses.front().stamp_ns) * 1e-9, p.pose});
  const double from_s = record.empty() ? 0 : record.front().time_s,
               to_s = record.empty() ? 0 : record.back().time_s;
  try {
    Motion motion = recorded_motion(std::move(record));
    if (from_s > end_s || to_s < 0)
      warn(fmt::format(
          "{}: lasts from {:.6g} to {:.6g} s, outside the scene's 0 to {:.6g} s: nothing moves by it",
          file.place(), from_s, to_s, end_s));
    return motion;
  } catch (const InputError& error) {
    file.fail(error.what());
  }
}

}  // namespace uniquadric
