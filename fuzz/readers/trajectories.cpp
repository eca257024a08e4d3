#include "core/import/fields.h"
#include "core/sequence/imu.h"
#include "core/sequence/tracks.h"
#include "core/sequence/trajectory.h"
#include "core/sequence/visibility.h"
#include "fuzz/target.h"

namespace uniquadric::fuzz {
namespace {

const char* const kStates =
    "frame,timestamp_ns,id,semi_axis_x_m,semi_axis_y_m,semi_axis_z_m,exponent_q,var_semi_axis_x_m2,var_semi_"
    "axis_y_m2,var_semi_axis_z_m2,var_translation_x_m2,var_translation_y_m2,var_translation_z_m2,var_"
    "rotation_x_rad2,var_rotation_y_rad2,var_rotation_z_rad2,state,motion,exponent_upper_q,exponent_lower_q,"
    "profile_axis\n"
    "0,0,1,0.5,0.5,0.5,2,,,,,,,,,,active,unknown,1.5,2,x\n";

const Target tum("tum", "camera.tum", [](const std::filesystem::path& file) { read_tum(file); });

// Of an estimate, whose poses the bytes are.
const Target estimate_poses("estimate_poses", "estimate/objects/1.tum",
                            [](const std::filesystem::path& file) {
                              beside(file, "../camera.tum", "0 0 0 0 0 0 0 1\n");
                              beside(file, "../objects.csv", kStates);
                              read_tracks(file.parent_path().parent_path());
                            });

const Target objects_csv("objects_csv", "objects.csv", [](const std::filesystem::path& file) {
  beside(file, "camera.tum", "0 0 0 0 0 0 0 1\n");
  beside(file, "objects/1.tum", "0 0 0 0 0 0 0 1\n");
  read_tracks(file.parent_path());
});

const Target objects_yaml("objects_yaml", "objects.yaml", [](const std::filesystem::path& file) {
  beside(file, "camera.tum", "0 0 0 0 0 0 0 1\n");
  beside(file, "objects/1.tum", "0 0 0 0 0 0 0 1\n");
  read_tracks(file.parent_path());
});

const Target imu_csv("imu_csv", "imu.csv", [](const std::filesystem::path& file) { read_imu_csv(file); });

const Target visibility("visibility_csv", "visibility.csv",
                        [](const std::filesystem::path& file) { read_visibility(file); });

}  // namespace
}  // namespace uniquadric::fuzz
