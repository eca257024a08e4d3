#include "estimator/lidar/cluster_tracker.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/base/hungarian.h"
#include "core/base/seconds.h"

namespace uniquadric {
namespace {

constexpr int kLeastSights = 3;     // that a velocity is taken from
constexpr double kLeastSide = 0.5;  // [m]: a sliver's box is given some width
constexpr double kClearSigmas = 4;  // by which a single end moves

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

struct Line {
  double slope = 0, slope_sigma = 0;
};

// Through (t, x) by least squares, each x off by `sigma` at least; nothing of fewer than kLeastSights.
std::optional<Line> line_through(const std::vector<Eigen::Vector2d>& samples, double sigma) {
  const auto n = static_cast<double>(samples.size());
  if (std::ssize(samples) < kLeastSights) return std::nullopt;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& s : samples) mean += s / n;
  double up = 0, down = 0, squares = 0;
  for (const auto& s : samples) {
    up += (s.x() - mean.x()) * (s.y() - mean.y());
    down += (s.x() - mean.x()) * (s.x() - mean.x());
  }
  if (!(down > 0)) return std::nullopt;
  for (const auto& s : samples) squares += std::pow(s.y() - mean.y() - up / down * (s.x() - mean.x()), 2);
  return Line{up / down, std::max(sigma, std::sqrt(squares / (n - 2))) / std::sqrt(down)};
}

// Along the ground, what has to be added to one box for the other's middle.
double distance(const ClusterBox& a, const ClusterBox& b) {
  return (a.low + a.high - b.low - b.high).head<2>().norm() / 2;
}

}  // namespace

// The velocity along an axis; whether it is that of a body that moves.
bool ClusterTracker::follow_ends(Track& track, int axis) const {
  std::array<std::optional<Line>, 2> ends;
  for (int side = 0; side < 2; ++side) {
    std::vector<Eigen::Vector2d> samples;
    for (const auto& [stamp_ns, box] : track.sights)
      if (const int end = 2 * axis + side; !box.cut[end])
        samples.emplace_back(seconds(track.sights.front().stamp_ns, stamp_ns) - box.ago_s[end],
                             side ? box.high[axis] : box.low[axis]);
    ends[side] = line_through(samples, options_.end_sigma_m);
  }
  const auto& hidden = track.sights.back().box.hidden;
  const bool both = ends[0] && ends[1];
  if (!ends[0] && !ends[1]) return false;
  const int facing = hidden[2 * axis] && ends[1] ? 1 : hidden[2 * axis + 1] && ends[0] ? 0 : -1;
  if (facing >= 0)
    track.velocity_mps[axis] = ends[facing]->slope;
  else
    track.velocity_mps[axis] =
        both ? (ends[0]->slope + ends[1]->slope) / 2 : (ends[0] ? *ends[0] : *ends[1]).slope;
  if (both && std::abs(ends[0]->slope - ends[1]->slope) < options_.max_stretch_mps)
    return std::min(std::abs(ends[0]->slope), std::abs(ends[1]->slope)) > options_.min_speed_mps;
  return facing >= 0 && std::abs(ends[facing]->slope) >
                            std::max(options_.min_speed_mps, kClearSigmas * ends[facing]->slope_sigma);
}

void ClusterTracker::add(Track& track, std::int64_t stamp_ns, const ClusterBox& box) const {
  ++track.seen;
  track.missed = 0;
  track.sights.push_back({stamp_ns, box});
  while (std::ssize(track.sights) > options_.window_scans) track.sights.pop_front();
  const bool along_x = follow_ends(track, 0), along_y = follow_ends(track, 1);
  note_motion(track, along_x || along_y);
}

// What only seems to move, as more of it comes into view, goes no way to speak of.
void ClusterTracker::note_motion(Track& track, bool is_moving) const {
  const Sight& last = track.sights.back();
  const double extent_m = (last.box.high - last.box.low).head<2>().norm();
  const Eigen::Vector2d middle = (last.box.low + last.box.high).head<2>() / 2;
  if (track.seen == 1) track.start = middle;
  if (is_moving) {
    const auto before = track.sights.size() > 1 ? std::prev(track.sights.end(), 2) : track.sights.begin();
    track.way_m += track.velocity_mps.norm() * seconds(before->stamp_ns, last.stamp_ns);
    ++track.moving;
    track.resting = 0;
  } else {
    track.way_m = 0;
    track.moving = 0;
    ++track.resting;
  }
  track.moved |= track.moving >= options_.moving_scans && track.way_m >= options_.min_way * extent_m;
  if (track.resting >= options_.forget_scans && (middle - track.start).norm() < extent_m) track.moved = false;
}

// From two sights that are apart: their ends that face the sensor, else both, tell the speed.
void ClusterTracker::start_moving(Track& track) {
  const ClusterBox &first = track.sights.front().box, &last = track.sights.back().box;
  const double step_s = seconds(track.sights.front().stamp_ns, track.sights.back().stamp_ns);
  for (int axis = 0; axis < 2; ++axis) {
    double sum_mps = 0;
    int ends = 0;
    for (int side = 0; side < 2; ++side) {
      const int end = 2 * axis + side;
      if (last.hidden[end]) continue;
      const double way_m = side ? last.high[axis] - first.high[axis] : last.low[axis] - first.low[axis];
      sum_mps += way_m / (step_s + first.ago_s[end] - last.ago_s[end]);
      ++ends;
    }
    if (ends > 0) track.velocity_mps[axis] = sum_mps / ends;
  }
}

// Of each cluster the track whose box, gone on, it overlaps most; -1 of none.
std::vector<int> ClusterTracker::tracks_of(std::int64_t stamp_ns,
                                           const std::vector<ClusterBox>& clusters) const {
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
  std::vector<int> tracks = maximum_assignment(weights);
  for (std::size_t i = 0; i < tracks.size(); ++i)
    if (tracks[i] >= 0 && !(weights(static_cast<int>(i), tracks[i]) > 0)) tracks[i] = -1;
  return tracks;
}

// Clusters that nothing overlaps may be what was seen in the last scan for the first time and is fast.
void ClusterTracker::catch_up(std::int64_t stamp_ns, const std::vector<ClusterBox>& clusters,
                              std::vector<int>& tracks) const {
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(std::ssize(clusters), std::ssize(tracks_));
  for (std::ptrdiff_t j = 0; j < weights.cols(); ++j) {
    const Track& track = tracks_[j];
    const bool is_new = track.seen == 1 && track.missed == 1;
    if (!is_new || std::find(tracks.begin(), tracks.end(), static_cast<int>(j)) != tracks.end()) continue;
    const double reach_m = options_.max_speed_mps * seconds(track.sights.back().stamp_ns, stamp_ns);
    for (std::ptrdiff_t i = 0; i < weights.rows(); ++i)
      if (const double off_m = distance(clusters[i], track.sights.back().box); tracks[i] < 0)
        weights(i, j) = std::max(0.0, 1 - off_m / reach_m);
  }
  const std::vector<int> caught = maximum_assignment(weights);
  for (std::size_t i = 0; i < tracks.size(); ++i)
    if (caught[i] >= 0 && weights(static_cast<int>(i), caught[i]) > 0) tracks[i] = caught[i];
}

std::vector<TrackedCluster> ClusterTracker::track(std::int64_t stamp_ns,
                                                  const std::vector<ClusterBox>& clusters) {
  for (Track& track : tracks_) ++track.missed;
  std::vector<int> tracks = tracks_of(stamp_ns, clusters);
  catch_up(stamp_ns, clusters, tracks);
  std::vector<TrackedCluster> result;
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const bool known = tracks[i] >= 0;
    if (!known) tracks_.emplace_back().id = ++last_id_;
    Track& track = known ? tracks_[tracks[i]] : tracks_.back();
    const bool was_caught = known && track.seen == 1;
    add(track, stamp_ns, clusters[i]);
    if (was_caught) start_moving(track);
    const bool is_body = track.seen >= options_.confirm_scans && (track.moved || !options_.moving_only);
    track.seen_as_body = is_body ? track.seen_as_body + 1 : 0;
    result.push_back({track.id, track.velocity_mps, track.seen_as_body});
  }
  std::erase_if(tracks_, [&](const Track& track) { return track.missed > options_.patience_scans; });
  return result;
}

}  // namespace uniquadric
