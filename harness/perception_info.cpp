#include "harness/perception_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/core.hpp>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/seconds.h"
#include "core/sequence/sequence.h"
#include "core/sequence/trajectory.h"
#include "estimator/perception/perception_files.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Problems = std::vector<std::string>;

struct BodyCount {
  std::size_t frames = 0, features = 0, points = 0;
};

std::map<int, BodyCount> count_bodies(const Perception& perception) {
  std::map<int, BodyCount> bodies;
  for (std::size_t i = 0; i < perception.frames().size(); ++i)
    for (const BodyObservation& body : perception.read(i).bodies) {
      BodyCount& count = bodies[body.id];
      ++count.frames;
      count.features += body.features.size();
      count.points += static_cast<std::size_t>(body.points.cols());
    }
  return bodies;
}

// Runs what may throw InputError; its message is the problem.
template <typename Action>
void attempt(Problems& problems, const Action& action) {
  try {
    action();
  } catch (const InputError& e) {
    problems.push_back(e.what());
  }
}

void check_mask(const fs::path& path, const Camera& camera, Problems& problems) {
  const cv::Mat mask = read_image(path);
  if (mask.type() != CV_16UC1 || mask.cols != camera.width || mask.rows != camera.height)
    problems.push_back(path.string() + ": is no 16-bit grey image of the camera's size");
}

// camera.tum says again, for other tools, what the observations' index says.
void check_poses(const fs::path& path, const std::vector<FrameInfo>& frames, Problems& problems) {
  Trajectory kept;
  for (const FrameInfo& frame : frames)
    if (frame.final_camera) kept.push_back({frame.stamp_ns, *frame.final_camera});
  const Trajectory written = read_tum(path);
  const bool is_same =
      std::equal(kept.begin(), kept.end(), written.begin(), written.end(), [](const auto& a, const auto& b) {
        return a.stamp_ns == b.stamp_ns && a.pose.matrix() == b.pose.matrix();
      });
  if (!is_same) problems.push_back(path.string() + ": does not have the poses of the observations");
}

}  // namespace

bool is_perception(const fs::path& folder) {
  return fs::is_regular_file(folder / "perception.yaml");
}

std::string describe_perception(const fs::path& folder) {
  const Perception perception(folder);
  const auto& frames = perception.frames();
  const auto count = [&](auto has) { return std::count_if(frames.begin(), frames.end(), has); };
  const Camera& camera = perception.camera();
  std::string text = fmt::format("perception made by {}, key {}\ncamera: {}x{} px, fx {} fy {} cx {} cy {}\n",
                                 ConfigNode::load(folder / "perception.yaml").get<std::string>("program"),
                                 perception.source().key, camera.width, camera.height, camera.fx, camera.fy,
                                 camera.cx, camera.cy);
  text += fmt::format("frames: {} over {:.3f} s; {} with masks, {} with a camera pose\n", frames.size(),
                      frames.empty() ? 0 : seconds(frames.front().stamp_ns, frames.back().stamp_ns),
                      count([](const FrameInfo& f) { return f.has_masks; }),
                      count([](const FrameInfo& f) { return f.final_camera.has_value(); }));
  for (const auto& [id, body] : count_bodies(perception))
    text += fmt::format("body {}: in {} frames, {} features and {} points in each on average\n", id,
                        body.frames, body.features / body.frames, body.points / body.frames);
  return text;
}

std::vector<std::string> check_perception(const fs::path& folder) {
  Problems problems;
  for (const fs::path& file : foreign_files(folder))
    problems.push_back((folder / file).string() + ": is no part of a kept perception");
  attempt(problems, [&] {
    const Perception perception(folder);
    for (std::size_t i = 0; i < perception.frames().size(); ++i)
      attempt(problems, [&] { perception.read(i); });
    attempt(problems, [&] { check_poses(folder / "camera.tum", perception.frames(), problems); });
    if (!fs::is_directory(folder / "masks")) return;
    std::vector<fs::path> masks;
    for (const auto& entry : fs::directory_iterator(folder / "masks")) masks.push_back(entry.path());
    std::sort(masks.begin(), masks.end());
    for (const fs::path& mask : masks)
      attempt(problems, [&] { check_mask(mask, perception.camera(), problems); });
  });
  return problems;
}

}  // namespace uniquadric
