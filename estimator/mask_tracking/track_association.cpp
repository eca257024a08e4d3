#include "estimator/mask_tracking/track_association.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/base/hungarian.h"

namespace uniquadric {
namespace {

constexpr double kNanosecond_s = 1e-9;
constexpr double kColourMemory = 0.8;    // weight of the known colours against those of a new sighting
constexpr double kVelocityMemory = 0.5;  // the same for the velocity
constexpr double kWellSeen = 0.3;        // share of the largest silhouette from which colours are learnt
constexpr double kWholeSeen = 0.9;       // the same, from which a velocity is taken
constexpr double kContinuous_s = 0.5;    // between sightings from which a velocity is taken
constexpr double kMostHiddenSpeed = 2;   // of a hidden body, to and fro, in its last one's

// Pixels that each id of the tracked masks shares with a detection.
std::map<int, int> shared_pixels(const Detection& detection, const cv::Mat& tracked_masks) {
  std::map<int, int> shared;
  for (int v = 0; v < detection.region.height; ++v) {
    const auto* ids = tracked_masks.ptr<std::uint16_t>(detection.region.y + v) + detection.region.x;
    const auto* inside = detection.mask.ptr<unsigned char>(v);
    for (int u = 0; u < detection.region.width; ++u)
      if (inside[u] && ids[u]) ++shared[ids[u]];
  }
  return shared;
}

std::map<int, int> pixels_of_ids(const cv::Mat& masks) {
  std::map<int, int> pixels;
  for (int v = 0; v < masks.rows; ++v)
    for (int u = 0; u < masks.cols; ++u)
      if (const int id = masks.at<std::uint16_t>(v, u)) ++pixels[id];
  return pixels;
}

bool same_depth(const Appearance& a, const Appearance& b, double tolerance) {
  if (!a.place_m || !b.place_m) return true;
  return std::abs(a.place_m->z() - b.place_m->z()) < tolerance * a.place_m->z();
}

// Distance from the line along which a body may have gone, to or fro, while it was hidden.
double off_path_m(const Eigen::Vector3d& moved, const Eigen::Vector3d& velocity, double most_m) {
  if (velocity.isZero()) return moved.norm();
  const Eigen::Vector3d along = velocity.normalized();
  return (moved - std::clamp(moved.dot(along), -most_m, most_m) * along).norm();
}

}  // namespace

void TrackBook::match_by_overlap(const std::vector<Detection>& detections, const cv::Mat& tracked_masks,
                                 std::map<int, int>& ids) const {
  if (tracked_masks.empty() || detections.empty()) return;
  const std::map<int, int> areas = pixels_of_ids(tracked_masks);
  std::vector<int> columns;
  for (const auto& [id, pixels] : areas) columns.push_back(id);
  Eigen::MatrixXd iou = Eigen::MatrixXd::Zero(std::ssize(detections), std::ssize(columns));
  std::vector<std::map<int, int>> shared;
  for (int row = 0; row < iou.rows(); ++row) {
    shared.push_back(shared_pixels(detections[row], tracked_masks));
    for (int column = 0; column < iou.cols(); ++column) {
      const auto both = shared[row].find(columns[column]);
      if (both == shared[row].end()) continue;
      const double area = detections[row].appearance.area_px + areas.at(both->first);
      const double value = both->second / (area - both->second);
      if (value >= AssociationGates::min_iou) iou(row, column) = value;
    }
  }
  std::map<int, int> matched;  // row of each id
  const std::vector<int> column_of = maximum_assignment(iou);
  for (int row = 0; row < iou.rows(); ++row)
    if (column_of[row] >= 0 && iou(row, column_of[row]) > 0) matched[columns[column_of[row]]] = row;
  for (const auto& [id, row] : matched) ids[detections[row].label] = id;
  for (int row = 0; row < iou.rows(); ++row)  // pieces of bodies that are matched
    for (const auto& [id, both] : shared[row])
      if (!ids.contains(detections[row].label) && matched.contains(id) &&
          both >= AssociationGates::min_fragment * detections[row].appearance.area_px &&
          same_depth(detections[row].appearance, detections[matched[id]].appearance,
                     AssociationGates::max_depth_step))
        ids[detections[row].label] = id;
}

// How well a detection fits a track that is out of sight; 0: not at all.
double TrackBook::likeness(const Detection& detection, const KnownTrack& track, std::int64_t stamp_ns) const {
  const Appearance &seen = detection.appearance, &known = track.appearance;
  const double gap_s = static_cast<double>(stamp_ns - track.seen_ns) * kNanosecond_s;
  const double similarity = colour_similarity(seen, known);
  if (gap_s > AssociationGates::patience_s || similarity < AssociationGates::min_similarity) return 0;
  if (!seen.place_m || !known.place_m)
    return seen.area_px <= AssociationGates::max_area_ratio * track.largest_area_px ? similarity : 0;
  // hidden ones slow down, turn round or hurry; and at the edges of its cover a body's end stands for it
  const double most_m =
      kMostHiddenSpeed * gap_s * track.velocity_mps.norm() + std::sqrt(track.largest_area_m2);
  const double distance = off_path_m(*seen.place_m - *known.place_m, track.velocity_mps, most_m) /
                          (AssociationGates::reach_m + gap_s * AssociationGates::reach_mps);
  if (distance > 1 || *seen.area_m2 > AssociationGates::max_area_ratio * track.largest_area_m2) return 0;
  return similarity * (1 - distance / 4);  // of two that look alike the nearer one
}

void TrackBook::match_by_looks(const std::vector<Detection>& detections, std::int64_t stamp_ns,
                               std::map<int, int>& ids) {
  std::set<int> taken;
  for (const auto& [label, id] : ids) taken.insert(id);
  std::vector<const Detection*> rows;
  for (const auto& detection : detections)
    if (!ids.contains(detection.label)) rows.push_back(&detection);
  std::vector<KnownTrack*> columns;
  for (auto& [id, track] : tracks_)
    if (!taken.contains(id)) columns.push_back(&track);
  Eigen::MatrixXd fit(std::ssize(rows), std::ssize(columns));
  for (int row = 0; row < fit.rows(); ++row)
    for (int column = 0; column < fit.cols(); ++column)
      fit(row, column) = likeness(*rows[row], *columns[column], stamp_ns);
  if (fit.size() == 0) return;
  const std::vector<int> column_of = maximum_assignment(fit);
  for (int row = 0; row < fit.rows(); ++row) {
    if (column_of[row] < 0 || fit(row, column_of[row]) <= 0) continue;
    KnownTrack& track = *columns[column_of[row]];
    if (!track.held_since_ns) track.held_since_ns = stamp_ns;
    const double held_s = static_cast<double>(stamp_ns - *track.held_since_ns) * kNanosecond_s;
    const bool is_sure =
        colour_similarity(rows[row]->appearance, track.appearance) >= AssociationGates::sure_similarity;
    ids[rows[row]->label] = is_sure || held_s >= AssociationGates::hold_s ? track.id : 0;
  }
}

void TrackBook::update(const std::vector<Detection>& detections, const std::map<int, int>& ids,
                       std::int64_t stamp_ns) {
  std::map<int, const Appearance*> seen;  // of each id the largest piece
  for (const auto& detection : detections) {
    const auto id = ids.find(detection.label);
    if (id == ids.end() || id->second == 0) continue;
    const Appearance*& piece = seen[id->second];
    if (!piece || piece->area_px < detection.appearance.area_px) piece = &detection.appearance;
  }
  for (const auto& [id, appearance] : seen) {
    const auto [entry, is_new] = tracks_.try_emplace(id);
    KnownTrack& track = entry->second;
    if (is_new) track = {id, *appearance, 0, 0, Eigen::Vector3d::Zero(), stamp_ns, 0, {}};
    learn(track, *appearance, stamp_ns);
  }
  std::erase_if(tracks_, [&](const auto& entry) {
    return static_cast<double>(stamp_ns - entry.second.seen_ns) * kNanosecond_s >
           AssociationGates::patience_s;
  });
  for (auto& [id, track] : tracks_)
    if (!seen.contains(id)) ++track.missing;
}

// Takes over what a new sighting shows.
void TrackBook::learn(KnownTrack& track, const Appearance& seen, std::int64_t stamp_ns) const {
  const double gap_s = static_cast<double>(stamp_ns - track.seen_ns) * kNanosecond_s;
  Appearance& known = track.appearance;
  if (seen.area_px >= kWellSeen * track.largest_area_px)
    for (std::size_t i = 0; i < known.colours.size(); ++i)
      known.colours[i] = kColourMemory * known.colours[i] + (1 - kColourMemory) * seen.colours[i];
  // while a cover slides over it, what is seen of it moves less than it does
  const bool is_whole = seen.area_px >= kWholeSeen * track.largest_area_px;
  if (gap_s > kContinuous_s)
    track.velocity_mps.setZero();
  else if (gap_s > 0 && seen.place_m && known.place_m && is_whole) {
    const double memory = track.velocity_mps.isZero() ? 0 : kVelocityMemory;
    track.velocity_mps =
        memory * track.velocity_mps + (1 - memory) * (*seen.place_m - *known.place_m) / gap_s;
  }
  known.area_px = seen.area_px;
  if (seen.place_m) {
    known.place_m = seen.place_m;
    known.area_m2 = seen.area_m2;
    track.largest_area_m2 = std::max(track.largest_area_m2, *seen.area_m2);
  }
  track.largest_area_px = std::max(track.largest_area_px, seen.area_px);
  track.seen_ns = stamp_ns;
  track.missing = 0;
  track.held_since_ns.reset();
}

std::map<int, int> TrackBook::associate(const std::vector<Detection>& detections,
                                        const cv::Mat& tracked_masks, std::int64_t stamp_ns) {
  std::map<int, int> ids;
  match_by_overlap(detections, tracked_masks, ids);
  match_by_looks(detections, stamp_ns, ids);
  for (const auto& detection : detections)
    if (!ids.contains(detection.label)) ids[detection.label] = next_id_++;
  update(detections, ids, stamp_ns);
  std::erase_if(ids, [](const auto& entry) { return entry.second == 0; });
  return ids;
}

std::map<int, int> TrackBook::trust(const std::vector<Detection>& detections, std::int64_t stamp_ns) {
  std::map<int, int> ids;
  for (const auto& detection : detections) ids[detection.label] = detection.label;
  update(detections, ids, stamp_ns);
  return ids;
}

}  // namespace uniquadric
