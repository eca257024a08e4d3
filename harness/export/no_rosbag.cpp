// In the place of rosbag.cpp where ROS 1's library of bags was not installed.
#include "core/base/error.h"
#include "harness/export/writers.h"

namespace uniquadric {

void write_rosbag(const ExportSource&, const ExportOptions&, const std::filesystem::path&) {
  throw InputError("this program was built without rosbag (librosbag-storage-dev)");
}

}  // namespace uniquadric
