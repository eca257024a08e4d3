#include "harness/result/lengths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/sequence/estimated_objects.h"
#include "evaluation/association/object_overlap.h"
#include "evaluation/statistics/statistics.h"
#include "evaluation/unit_check.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kMostSpeed_mps = 150, kMostSize_m = 50;  // ours: beyond what is followed on the ground
constexpr double kLeastTwice = 1.7, kMostTwice = 2.3;     // ours: an estimate's size is off by less than 15 %
constexpr std::int64_t kMaxDifference_ns = 10'000'000;    // as evaluate has it

std::vector<Pose> positions(const Trajectory& trajectory) {
  std::vector<Pose> poses;
  for (const StampedPose& pose : trajectory) poses.push_back(pose.pose);
  return poses;
}

Trajectory path_of(const ObjectTrack& track) {
  Trajectory path;
  for (const ObjectState& state : track.states)
    path.push_back({state.stamp_ns, state.ellipsoid.world_from_object});
  return path;
}

std::optional<std::string> speed_fault(const Trajectory& path) {
  std::vector<double> speeds_mps;
  for (std::size_t i = 1; i < path.size(); ++i)
    speeds_mps.push_back((path[i].pose.translation - path[i - 1].pose.translation).norm() * 1e9 /
                         static_cast<double>(path[i].stamp_ns - path[i - 1].stamp_ns));
  if (speeds_mps.empty()) return std::nullopt;
  const double speed_mps = interpolated_quantile(std::move(speeds_mps), 0.5);
  if (speed_mps < kMostSpeed_mps) return std::nullopt;
  return fmt::format("moves at {:.3g} m/s: are positions in millimetres?", speed_mps);
}

std::optional<std::string> large_size_fault(const ObjectTrack& track) {
  std::vector<double> sizes_m;
  for (const ObjectState& state : track.states) sizes_m.push_back(2 * state.ellipsoid.semi_axes_m.maxCoeff());
  if (sizes_m.empty()) return std::nullopt;
  const double size_m = interpolated_quantile(std::move(sizes_m), 0.5);
  if (size_m < kMostSize_m) return std::nullopt;
  return fmt::format("object {} is {:.3g} m large: are sizes in millimetres?", track.id, size_m);
}

// Where the sizes stand.
fs::path size_file(const fs::path& folder) {
  return folder / (fs::exists(folder / "objects.csv") ? "objects.csv" : "objects.yaml");
}

// Median over the states of both of the cube root of the volume.
double mean_size_m(const ObjectTrack& track) {
  std::vector<double> sizes_m;
  for (const ObjectState& state : track.states)
    sizes_m.push_back(std::cbrt(state.ellipsoid.semi_axes_m.prod()));
  return interpolated_quantile(std::move(sizes_m), 0.5);
}

}  // namespace

std::vector<std::string> unit_faults(const fs::path& folder, const Tracks& estimate, const Trajectory& camera,
                                     const Tracks* truth) {
  std::vector<std::string> faults;
  const auto add = [&](const fs::path& file, const std::optional<std::string>& fault) {
    if (fault) faults.push_back(file.string() + ": " + *fault);
  };
  add(folder / "camera.tum", camera.empty() ? speed_fault(estimate.camera)
                                            : spread_fault(positions(camera), positions(estimate.camera)));
  for (const ObjectTrack& track : estimate.objects) {
    add(trajectory_file(folder, track.id), speed_fault(path_of(track)));
    if (!truth) add(size_file(folder), large_size_fault(track));
  }
  if (!truth) return faults;
  const double size_m = median_semi_axis_m(estimate.objects), true_m = median_semi_axis_m(truth->objects);
  if (size_m > 0 && true_m > 0 && (size_m > kUnitRatio * true_m || true_m > kUnitRatio * size_m))
    add(size_file(folder),
        fmt::format("the semi-axes' median is {:.3g} m, the true ones' {:.3g} m: are sizes in metres?",
                    size_m, true_m));
  return faults;
}

std::vector<std::pair<const ObjectTrack*, const ObjectTrack*>> matched_tracks(const Tracks& truth,
                                                                              const Tracks& estimate) {
  const auto matches = match_objects(overlap_objects(truth, estimate, kMaxDifference_ns));
  std::vector<std::pair<const ObjectTrack*, const ObjectTrack*>> pairs;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (matches[i]) pairs.emplace_back(&truth.objects[i], &estimate.objects[*matches[i]]);
  return pairs;
}

std::optional<std::string> size_faults(const fs::path& folder, const Tracks& estimate, const Tracks& truth) {
  std::vector<double> ratios;
  for (const auto& [object, track] : matched_tracks(truth, estimate))
    ratios.push_back(mean_size_m(*track) / mean_size_m(*object));
  if (ratios.empty()) return std::nullopt;
  const double ratio = interpolated_quantile(std::move(ratios), 0.5);
  const auto is_about_twice = [](double x) { return x > kLeastTwice && x < kMostTwice; };
  if (!is_about_twice(ratio) && !is_about_twice(1 / ratio)) return std::nullopt;
  return fmt::format("{}: sizes are {:.2f} times the truth's: {}", size_file(folder).string(), ratio,
                     ratio > 1 ? "full sizes given as semi-axes?" : "semi-axes given as full sizes?");
}

}  // namespace uniquadric
