#pragma once

#include <functional>
#include <map>
#include <string>

#include "core/import/omd.h"

namespace uniquadric {

/// The two layouts of import_omd().
Recording read_omd_raw(const std::filesystem::path& folder, const ImportOmdOptions& options);
Recording read_omd_processed(const std::filesystem::path& folder, const ImportOmdOptions& options);

/// vicon.csv: world_from_body by name.
struct ViconFile {
  std::map<std::string, Trajectory> bodies;
  std::size_t dropped = 0;  ///< rows without a name or with NaN
};
ViconFile read_vicon(const std::filesystem::path& path, double offset_s);

/// rgbd/ of the raw layout: frames and their images. Says in `left_out` how many indices have one image only.
void read_rgbd(const std::filesystem::path& folder, Recording& recording);

/// The truth of the camera's poses at the frames (camera_poses) and of the bodies that `options.objects`
/// describes, as far as `name_of` finds them in `bodies`, at the camera's stamps. Bodies without a
/// description are left out, and that is said.
void set_truth(const Trajectory& camera, const std::map<std::string, Trajectory>& bodies,
               const std::function<std::string(const ObjectDescription&)>& name_of,
               const std::filesystem::path& objects, Recording& recording);

}  // namespace uniquadric
