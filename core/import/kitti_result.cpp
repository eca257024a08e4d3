#include "core/import/kitti_result.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/import/kitti_files.h"
#include "core/import/result.h"
#include "core/import/result_world.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// The label file and the folder that its poses and calibration stand in.
struct Source {
  fs::path labels, folder;
  fs::path beside(const char* kind) const { return folder / kind / labels.filename(); }
};

// Folders that hold label files, one a sequence.
bool is_label_folder(const fs::path& folder) {
  return folder.filename() == "data" || folder.filename() == "label_02";
}

bool is_numbered_text(const fs::path& file) {
  const std::string stem = file.stem().string();
  return file.extension() == ".txt" && !stem.empty() &&
         stem.find_first_not_of("0123456789") == std::string::npos;
}

std::vector<fs::path> label_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::path& place : {folder, folder / "data", folder / "label_02"}) {
    if (!fs::is_directory(place)) continue;
    for (const auto& entry : fs::directory_iterator(place))
      if (is_numbered_text(entry.path())) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

Source find_source(const fs::path& source) {
  Source found{source, {}};
  if (fs::is_directory(source)) {
    const auto files = label_files(source);
    if (files.empty())
      throw InputError(source, "has no file of labels such as 0000.txt, data/0000.txt or label_02/0000.txt");
    if (files.size() > 1)
      throw InputError(source, fmt::format("has {} files of labels, the first two {} and {}: name the file",
                                           files.size(), files[0].lexically_relative(source).string(),
                                           files[1].lexically_relative(source).string()));
    found.labels = files.front();
  }
  const fs::path parent = fs::absolute(found.labels).lexically_normal().parent_path();
  found.folder = is_label_folder(parent) ? parent.parent_path() : parent;
  return found;
}

// One pose a frame, as KITTI's odometry has them.
Trajectory read_poses(const fs::path& file, const std::vector<std::int64_t>& stamps_ns,
                      const Pose& camera_from_rectified) {
  const std::vector<Pose> poses = read_kitti_poses(file);
  if (poses.size() != stamps_ns.size())
    throw InputError(file, fmt::format("has {} lines for {} frames", poses.size(), stamps_ns.size()));
  Trajectory camera;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    camera.push_back({stamps_ns[i], poses[i] * camera_from_rectified.inverse()});
    camera.back().pose.rotation.normalize();
  }
  return camera;
}

}  // namespace

Tracks read_kitti_result(const fs::path& path, const Sequence& sequence) {
  const Source source = find_source(path);
  const std::vector<std::int64_t> stamps_ns = observed_ns(sequence);
  const std::vector<KittiLabel> labels = read_kitti_labels(source.labels, std::ssize(stamps_ns));
  Pose camera_from_rectified;
  if (const fs::path file = source.beside("calib"); fs::exists(file))
    camera_from_rectified = read_kitti_calibration(file, false).camera_from_rectified;
  const std::string name = source.labels.string();
  const fs::path poses = source.beside("poses");
  const Trajectory camera = fs::exists(poses)
                                ? read_poses(poses, stamps_ns, camera_from_rectified)
                                : camera_of_result(source.folder / "camera.tum", sequence, name);
  const int free_id = first_free_id(labels);
  std::vector<BoxInCamera> boxes;
  for (const KittiLabel& label : labels)
    boxes.push_back({label.frame,
                     object_id(label, free_id),
                     camera_from_rectified * label.rectified_from_object,
                     {label.semi_axes_m, {1, 1, 1}, 2}});
  return placed_in_world(std::move(boxes), camera, sequence, name);
}

}  // namespace uniquadric
