#include "evaluation/association/object_choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <numeric>

#include "core/base/error.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {

// Of the true poses, whose jitter is less than an object's smallest side.
bool moves(const ObjectTrack& object) {
  if (object.states.empty()) return false;
  const Ellipsoid& first = object.states.front().ellipsoid;
  const double side_m = 2 * first.semi_axes_m.minCoeff();
  return std::ranges::any_of(object.states, [&](const ObjectState& state) {
    const Eigen::Vector3d& now = state.ellipsoid.world_from_object.translation;
    return (now - first.world_from_object.translation).norm() > side_m;
  });
}

bool overlaps_any(const ObjectOverlaps& overlaps, std::size_t track, std::size_t frame) {
  return std::ranges::any_of(overlaps.iou3d, [&](const auto& row) { return row[track][frame] > 0; });
}

// Nothing where the track never overlaps an object.
std::optional<std::size_t> most_overlapped(const ObjectOverlaps& overlaps, std::size_t track) {
  std::optional<std::size_t> most;
  double greatest = 0;
  for (std::size_t g = 0; g < overlaps.iou3d.size(); ++g) {
    const std::vector<double>& values = overlaps.iou3d[g][track];
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    if (sum > greatest) most = g;
    greatest = std::max(greatest, sum);
  }
  return most;
}

}  // namespace

ObjectChoice parse_object_choice(const std::string& text) {
  ObjectChoice choice;
  for (const std::string_view item : split(text, ',')) {
    if (item.empty()) throw InputError(fmt::format("objects: '{}' has an empty item", text));
    if (item == "moving")
      choice.moving = true;
    else if (item == "in_view")
      choice.in_view = true;
    else if (item != "all" && item != "labelled")
      choice.classes.push_back(class_of(std::string(item)));
  }
  return choice;
}

std::string to_string(const ObjectChoice& choice) {
  std::vector<std::string> items = choice.classes;
  if (choice.in_view) items.insert(items.begin(), "in_view");
  if (choice.moving) items.insert(items.begin(), "moving");
  return items.empty() ? "all" : fmt::format("{}", fmt::join(items, ","));
}

std::string class_of(const std::string& name) {
  const std::size_t end = name.rfind('_');
  const bool is_numbered =
      end != std::string::npos && end > 0 && parse_integer(std::string_view(name).substr(end + 1));
  std::string result = is_numbered ? name.substr(0, end) : name;
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

std::vector<bool> scored_objects(const std::vector<ObjectTrack>& truth, const ObjectChoice& choice) {
  std::vector<bool> scored;
  for (const ObjectTrack& object : truth) {
    const bool is_wanted = choice.classes.empty() ||
                           std::ranges::find(choice.classes, class_of(object.name)) != choice.classes.end();
    scored.push_back(is_wanted && (!choice.moving || moves(object)));
  }
  return scored;
}

std::vector<bool> tracks_of(const std::vector<bool>& objects,
                            const std::vector<std::optional<std::size_t>>& matches,
                            const ObjectOverlaps& overlaps) {
  std::vector<std::optional<std::size_t>> object_of;
  for (std::size_t e = 0; e < overlaps.estimate.size(); ++e)
    object_of.push_back(most_overlapped(overlaps, e));
  for (std::size_t g = 0; g < matches.size(); ++g)
    if (matches[g]) object_of[*matches[g]] = g;
  std::vector<bool> belongs;
  for (const auto& object : object_of) belongs.push_back(object && objects[*object]);
  return belongs;
}

void drop_unlabelled(Unlabelled unlabelled, bool labels_are_partial,
                     const std::vector<std::optional<std::size_t>>& matches, ObjectOverlaps& overlaps) {
  std::vector<std::optional<std::size_t>> object_of(overlaps.estimate.size());
  for (std::size_t g = 0; g < matches.size(); ++g)
    if (matches[g]) object_of[*matches[g]] = g;
  for (std::size_t e = 0; e < overlaps.estimate.size(); ++e)
    for (std::size_t frame = 0; frame < overlaps.stamps_ns.size(); ++frame) {
      const bool left = labels_are_partial && object_of[e] && !overlaps.truth[*object_of[e]][frame];
      if ((left || unlabelled == Unlabelled::ignored) && !overlaps_any(overlaps, e, frame))
        overlaps.estimate[e][frame].reset();
    }
}

}  // namespace uniquadric
