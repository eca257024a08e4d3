#include "evaluation/association/hidden_objects.h"

#include <algorithm>

#include "core/base/hungarian.h"

namespace uniquadric {
namespace {

// The track of each object in one frame by their overlaps there, -1 for none.
std::vector<int> tracks_at(const ObjectOverlaps& overlaps, std::size_t frame) {
  std::vector<int> tracks(overlaps.truth.size(), -1);
  if (overlaps.estimate.empty()) return tracks;
  Eigen::MatrixXd table(overlaps.truth.size(), overlaps.estimate.size());
  for (Eigen::Index g = 0; g < table.rows(); ++g)
    for (Eigen::Index e = 0; e < table.cols(); ++e)
      table(g, e) = overlaps.iou3d[static_cast<std::size_t>(g)][static_cast<std::size_t>(e)][frame];
  const std::vector<int> assignment = maximum_assignment(table);
  for (std::size_t g = 0; g < tracks.size(); ++g)
    if (assignment[g] >= 0 && table(static_cast<Eigen::Index>(g), assignment[g]) > 0)
      tracks[g] = assignment[g];
  return tracks;
}

void drop_at(std::size_t frame, const std::vector<bool>& hidden,
             const std::vector<std::optional<std::size_t>>& matches, const std::vector<bool>& left_out,
             ObjectOverlaps& overlaps) {
  const std::vector<int> tracks = tracks_at(overlaps, frame);
  std::vector<bool> kept(overlaps.estimate.size());
  for (std::size_t g = 0; g < hidden.size(); ++g)
    if (!hidden[g] && tracks[g] >= 0) kept[static_cast<std::size_t>(tracks[g])] = true;
  const auto drop_track = [&](std::size_t e) {
    if (kept[e]) return;
    overlaps.estimate[e][frame].reset();
    for (auto& row : overlaps.iou3d) row[e][frame] = 0;
  };
  for (std::size_t g = 0; g < hidden.size(); ++g) {
    if (!hidden[g]) continue;
    if (tracks[g] >= 0) drop_track(static_cast<std::size_t>(tracks[g]));
    if (matches[g]) drop_track(*matches[g]);
    overlaps.truth[g][frame].reset();
    for (auto& values : overlaps.iou3d[g]) values[frame] = 0;
  }
  for (std::size_t e = 0; e < left_out.size(); ++e)
    if (left_out[e]) drop_track(e);
}

}  // namespace

void drop_hidden(const std::vector<std::vector<bool>>& hidden,
                 const std::vector<std::optional<std::size_t>>& matches, const std::vector<bool>& left_out,
                 ObjectOverlaps& overlaps) {
  for (std::size_t frame = 0; frame < overlaps.stamps_ns.size(); ++frame) {
    std::vector<bool> here;
    for (const auto& row : hidden) here.push_back(row[frame]);
    if (std::find(here.begin(), here.end(), true) != here.end())
      drop_at(frame, here, matches, left_out, overlaps);
  }
}

}  // namespace uniquadric
