#include "estimator/perception/cluster_tracker.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/hungarian.h"
#include "core/base/seconds.h"

namespace uniquadric {
namespace {

constexpr int kLeastSights = 3;     // that a velocity is taken from
constexpr double kLeastSide = 0.5;  // [m]: a sliver's box is given some width

double overlap(const ClusterBox& a, const ClusterBox& b) {
  double both = 1, first = 1, second = 1;
  for (int axis = 0; axis < 2; ++axis) {
    both *= std::max(0.0, std::min(a.high[axis], b.high[axis]) - std::max(a.low[axis], b.low[axis]));
    first *= a.high[axis] - a.low[axis];
    second *= b.high[axis] - b.low[axis];
  }
  return both / std::min(first, second);
}

ClusterBox widened(ClusterBox box) {
  for (int axis = 0; axis < 2; ++axis)
    if (const double lacks = kLeastSide - (box.high[axis] - box.low[axis]); lacks > 0)
      box.low[axis] -= lacks / 2, box.high[axis] += lacks / 2;
  return box;
}

ClusterBox moved(ClusterBox box, const Eigen::Vector2d& shift) {
  box.low.head<2>() += shift;
  box.high.head<2>() += shift;
  return box;
}

// Slope of a line through (t, x); nothing of fewer than kLeastSights.
std::optional<double> slope(const std::vector<Eigen::Vector2d>& samples) {
  if (std::ssize(samples) < kLeastSights) return std::nullopt;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& s : samples) mean += s / static_cast<double>(samples.size());
  double up = 0, down = 0;
  for (const auto& s : samples) {
    up += (s.x() - mean.x()) * (s.y() - mean.y());
    down += (s.x() - mean.x()) * (s.x() - mean.x());
  }
  return down > 0 ? std::optional(up / down) : std::nullopt;
}

}  // namespace

void ClusterTracker::add(Track& track, std::int64_t stamp_ns, const ClusterBox& box) {
  ++track.seen;
  track.missed = 0;
  track.sights.push_back({stamp_ns, box});
  while (std::ssize(track.sights) > options_.window_scans) track.sights.pop_front();
  bool moves = false;
  for (int axis = 0; axis < 2; ++axis) {
    std::array<std::optional<double>, 2> ends;
    for (int side = 0; side < 2; ++side) {
      std::vector<Eigen::Vector2d> samples;
      for (const Sight& sight : track.sights)
        if (!sight.box.cut[2 * axis + side])
          samples.emplace_back(seconds(stamp_ns, sight.stamp_ns),
                               side ? sight.box.high[axis] : sight.box.low[axis]);
      ends[side] = slope(samples);
    }
    if (!ends[0] && !ends[1]) continue;
    track.velocity_mps[axis] = ends[0] && ends[1] ? (*ends[0] + *ends[1]) / 2 : ends[0] ? *ends[0] : *ends[1];
    moves |= ends[0] && ends[1] && std::abs(*ends[0] - *ends[1]) < options_.max_stretch_mps &&
             std::min(std::abs(*ends[0]), std::abs(*ends[1])) > options_.min_speed_mps;
  }
  track.moving = moves ? track.moving + 1 : 0;
  track.moved |= track.moving >= options_.moving_scans;
}

std::vector<TrackedCluster> ClusterTracker::track(std::int64_t stamp_ns,
                                                  const std::vector<ClusterBox>& clusters) {
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(std::ssize(clusters), std::ssize(tracks_));
  for (std::ptrdiff_t j = 0; j < weights.cols(); ++j) {
    const Track& track = tracks_[j];
    const Sight& last = track.sights.back();
    const ClusterBox predicted =
        widened(moved(last.box, track.velocity_mps * seconds(last.stamp_ns, stamp_ns)));
    for (std::ptrdiff_t i = 0; i < weights.rows(); ++i)
      if (const double share = overlap(widened(clusters[i]), predicted); share >= options_.min_overlap)
        weights(i, j) = share * (1 + std::min(track.seen, options_.confirm_scans));  // old tracks first
  }
  const std::vector<int> columns = maximum_assignment(weights);
  std::vector<TrackedCluster> result;
  for (Track& track : tracks_) ++track.missed;
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const bool known = columns[i] >= 0 && weights(static_cast<int>(i), columns[i]) > 0;
    if (!known) tracks_.push_back({++last_id_, 0, 0, 0, 0, false, {}, Eigen::Vector2d::Zero()});
    Track& track = known ? tracks_[columns[i]] : tracks_.back();
    add(track, stamp_ns, clusters[i]);
    if (track.seen >= options_.confirm_scans && (track.moved || !options_.moving_only)) ++track.seen_as_body;
    result.push_back({track.id, track.velocity_mps, track.seen_as_body});
  }
  std::erase_if(tracks_, [&](const Track& track) { return track.missed > options_.patience_scans; });
  return result;
}

}  // namespace uniquadric
