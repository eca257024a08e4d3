#include "core/import/omd.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "core/import/omd_readers.h"

namespace uniquadric {
namespace fs = std::filesystem;

void set_truth(const Trajectory& camera, const std::map<std::string, Trajectory>& bodies,
               const std::function<std::string(const ObjectDescription&)>& name_of, const fs::path& objects,
               Recording& recording) {
  RecordedTruth& truth = recording.truth.emplace();
  truth.camera = camera;
  recording.sequence.given_camera = camera;
  const auto stamps_ns = stamps_of(camera);
  std::set<std::string> left;
  for (const auto& [name, trajectory] : bodies) left.insert(name);
  if (!objects.empty())
    for (const ObjectDescription& object : read_objects_yaml(objects)) {
      const auto body = bodies.find(name_of(object));
      if (body == bodies.end())
        throw InputError(objects, fmt::format("the recording has no {}", name_of(object)));
      left.erase(body->first);
      truth.objects.push_back(object);
      truth.objects_at[object.id] = trajectory_at(body->second, stamps_ns);
    }
  if (!left.empty())
    recording.left_out.push_back(fmt::format(
        "the poses of {} are left out, for nothing says their sizes: --objects", fmt::join(left, ", ")));
}

void import_omd(const fs::path& recording, const ImportOmdOptions& options, const fs::path& out) {
  if (!fs::is_directory(recording)) throw InputError(recording, "is not a folder");
  if (fs::exists(recording / "rgbd/rgbd.csv"))
    write_recording(read_omd_raw(recording, options), options, out);
  else if (fs::exists(recording / "times.txt"))
    write_recording(read_omd_processed(recording, options), options, out);
  else
    throw InputError(
        recording, "holds no recording: neither rgbd/rgbd.csv (raw) nor times.txt and image_0/ (processed)");
}

}  // namespace uniquadric
