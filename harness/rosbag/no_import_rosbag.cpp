// In the place of import_rosbag.cpp where ROS 1's library of bags was not installed.
#include "core/base/error.h"
#include "harness/rosbag/import_rosbag.h"

namespace uniquadric {

void import_rosbag(const std::filesystem::path&, const ImportRosbagOptions&, const std::filesystem::path&) {
  throw InputError("this program was built without rosbag (librosbag-storage-dev)");
}

}  // namespace uniquadric
