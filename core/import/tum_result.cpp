#include "core/import/tum_result.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

#include "core/base/error.h"
#include "core/sequence/estimated_objects.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr const char* kCameraFiles[] = {"camera.tum", "trajectory.txt", "CameraTrajectory.txt",
                                        "KeyFrameTrajectory.txt"};

// Trajectories of objects by id: ID.tum or ID.txt, not both.
std::map<int, fs::path> object_files(const fs::path& folder) {
  std::map<int, fs::path> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (file.extension() != ".tum" && file.extension() != ".txt") continue;
    if (!files.emplace(id_of_file(file), file).second)
      throw InputError(folder, fmt::format("has several trajectories of object {}", id_of_file(file)));
  }
  return files;
}

// A size that belongs to no trajectory is a mistake in an id.
void require_poses(const fs::path& sizes, const std::map<int, ObjectShape>& shapes,
                   const std::map<int, fs::path>& files) {
  for (const auto& [id, shape] : shapes)
    if (!files.contains(id))
      throw InputError(sizes, fmt::format("object {0} has no poses: objects/{0}.tum is missing", id));
}

}  // namespace

fs::path camera_file(const fs::path& folder) {
  std::vector<std::string> found;
  for (const char* name : kCameraFiles)
    if (fs::exists(folder / name)) found.emplace_back(name);
  if (found.size() > 1)
    throw InputError(folder, fmt::format("has several trajectories of the camera, {}: name the file instead",
                                         fmt::join(found, ", ")));
  return found.empty() ? fs::path() : folder / found.front();
}

Tracks read_tum_result(const fs::path& source) {
  Tracks tracks;
  if (!fs::is_directory(source)) {
    tracks.camera = read_tum(source);
    return tracks;
  }
  const fs::path camera = camera_file(source), sizes = source / "objects.yaml";
  const auto files = object_files(source / "objects");
  if (camera.empty() && files.empty())
    throw InputError(source, fmt::format("has neither a trajectory of the camera ({}) nor objects/ID.tum",
                                         fmt::join(kCameraFiles, ", ")));
  const auto shapes = read_object_shapes(sizes);
  require_poses(sizes, shapes, files);
  if (!camera.empty()) tracks.camera = read_tum(camera);
  for (const auto& [id, file] : files)
    if (ObjectTrack track = track_of_shape(file, shapes); !track.states.empty())
      tracks.objects.push_back(std::move(track));
  number_frames(tracks);
  return tracks;
}

}  // namespace uniquadric
