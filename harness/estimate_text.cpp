#include "harness/estimate_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/base/config.h"
#include "core/sequence/tracks.h"
#include "evaluation/results/markup.h"

namespace uniquadric {
namespace {

const char* text_of(ObjectMotion motion) {
  return motion == ObjectMotion::unknown ? "undecided" : to_string(motion);
}

std::vector<std::string> line_of(const ObjectTrack& track) {
  const auto count = [&](ObjectStatus status) {
    return std::ranges::count(track.states, status, &ObjectState::status);
  };
  return {std::to_string(track.id), std::to_string(std::ssize(track.states) - count(ObjectStatus::lost)),
          std::to_string(count(ObjectStatus::occluded)), text_of(track.states.back().motion)};
}

std::string objects_text(const std::vector<ObjectTrack>& objects) {
  if (objects.empty()) return "no object with states\n";
  std::vector<std::vector<std::string>> lines = {{"object", "frames", "occluded", "motion"}};
  for (const ObjectTrack& track : objects) lines.push_back(line_of(track));
  std::string counts;
  for (const ObjectMotion motion : {ObjectMotion::at_rest, ObjectMotion::moving, ObjectMotion::unknown}) {
    const auto n = std::ranges::count(objects, motion,
                                      [](const ObjectTrack& track) { return track.states.back().motion; });
    counts += fmt::format("{}{} {}", counts.empty() ? ": " : ", ", n, text_of(motion));
  }
  return aligned_columns(lines, "<") + fmt::format("{} objects with states{}\n", objects.size(), counts);
}

}  // namespace

std::string estimate_text(const std::filesystem::path& estimate) {
  std::vector<ObjectTrack> objects = read_tracks(estimate).objects;
  std::erase_if(objects, [](const ObjectTrack& track) { return track.states.empty(); });
  const ConfigNode run = ConfigNode::load(estimate / "run.yaml");
  const bool has_images = run.get<std::string>("frames_are", "images") == "images";
  std::string frames = fmt::format("{} {}", run.get<int>("frames"), has_images ? "frames" : "scans");
  std::vector<std::string> kinds = {"pose"};
  if (has_images) kinds.insert(kinds.end(), {"depth", "masks"});
  for (const std::string& missing : kinds)
    frames +=
        fmt::format(", {} without {}", run.get<int>(fmt::format("frames_without_{}", missing)), missing);
  return objects_text(objects) + frames + "\n";
}

}  // namespace uniquadric
