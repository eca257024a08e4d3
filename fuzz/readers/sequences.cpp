#include "core/base/folder_hashes.h"
#include "core/sequence/calibration.h"
#include "core/sequence/sequence.h"
#include "fuzz/target.h"

namespace uniquadric::fuzz {
namespace {

const char* const kSequence =
    "schema: 1\nname: fuzz\ncamera: {width: 4, height: 4, fx: 4, fy: 4, cx: 2, cy: 2, rate_hz: 30}\n";

const Target sequence_yaml("sequence_yaml", "sequence.yaml", [](const std::filesystem::path& file) {
  beside(file, "rgb.txt", "0 rgb.txt\n");
  beside(file, "lidar.txt", "0 rgb.txt\n");
  beside(file, "imu.csv", "");
  open_sequence(file.parent_path());
});

// Lines of the colour images, of depth, masks and scans at once.
const Target file_lists("file_lists", "rgb.txt", [](const std::filesystem::path& file) {
  beside(file, "sequence.yaml", kSequence);
  beside(file, "a", "");
  for (const char* other : {"depth.txt", "masks.txt"}) {
    std::filesystem::remove(file.parent_path() / other);
    std::filesystem::create_hard_link(file, file.parent_path() / other);
  }
  open_sequence(file.parent_path());
});

const Target camera_yaml("camera_yaml", "camera.yaml",
                         [](const std::filesystem::path& file) { read_camera_yaml(file); });

const Target hashes("hashes_txt", "hashes.txt", [](const std::filesystem::path& file) {
  beside(file, "a", "");
  check_hashes(file.parent_path(), 1);
});

}  // namespace
}  // namespace uniquadric::fuzz
