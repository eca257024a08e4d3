#include "core/import/euroc.h"
#include "core/import/euroc_camera.h"
#include "core/import/fields.h"
#include "core/import/kitti_files.h"
#include "core/import/omd_readers.h"
#include "core/sequence/sequence.h"
#include "fuzz/target.h"

namespace uniquadric::fuzz {
namespace {
namespace fs = std::filesystem;

const char* const kEurocCamera =
    "T_BS: {data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}\ncamera_model: pinhole\n"
    "resolution: [4, 4]\nintrinsics: [4, 4, 2, 2]\n";
const char* const kEurocImu =
    "T_BS: {data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}\nrate_hz: 200\n"
    "gyroscope_noise_density: 1e-4\ngyroscope_random_walk: 1e-5\n"
    "accelerometer_noise_density: 1e-3\naccelerometer_random_walk: 1e-3\n";
const char* const kKalibr =
    "cam1: {T_cn_cnm1: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}\n"
    "cam2: {T_cn_cnm1: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], resolution: [4, 4],\n"
    "  intrinsics: [4, 4, 2, 2], T_cam_imu: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}\n";
const char* const kSettings =
    "{Camera.fx: 4, Camera.fy: 4, Camera.cx: 2, Camera.cy: 2, Camera.width: 4, "
    "Camera.height: 4}\n";

const Target kitti_calib("kitti_calib", "0000.txt",
                         [](const fs::path& file) { read_kitti_calibration(file, true); });
const Target kitti_label("kitti_label", "0000.txt",
                         [](const fs::path& file) { read_kitti_labels(file, 100); });
const Target kitti_poses("kitti_poses", "0000.txt", [](const fs::path& file) { read_kitti_poses(file); });
const Target kitti_oxts("kitti_oxts", "0000.txt", [](const fs::path& file) { read_kitti_oxts(file); });
const Target times("times_txt", "times.txt",
                   [](const fs::path& file) { nominal_rate_hz(read_times(file), 10); });

const Target omd_vicon("omd_vicon_csv", "vicon.csv", [](const fs::path& file) { read_vicon(file, 0.5); });

void read_raw(const fs::path& file) {
  beside(file, "kalibr.yaml", kKalibr);
  beside(file, "rgbd/rgbd.csv", "0,1,0\n1,2,0\n");
  for (const char* image : {"rgbd/000000_color.png", "rgbd/000000_aligned_depth.png"})
    beside(file, image, "");
  read_omd_raw(file.parent_path(), {});
}
const Target omd_kalibr("omd_kalibr_yaml", "raw/kalibr.yaml", read_raw);
const Target omd_imu("omd_imu_csv", "raw/imu.csv", read_raw);
const Target omd_rgbd("omd_rgbd_csv", "raw/rgbd/rgbd.csv",
                      [](const fs::path& file) { read_raw(file.parent_path()); });

void read_processed(const fs::path& file) {
  beside(file, "settings.yaml", kSettings);
  beside(file, "times.txt", "0\n1\n");
  for (const char* image : {"image_0/000000.png", "image_0/000001.png"}) beside(file, image, "");
  beside(file, "pose_gt.txt", "0 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n");
  read_omd_processed(file.parent_path(), {});
}
const Target omd_settings("omd_settings_yaml", "processed/settings.yaml", read_processed);
const Target omd_pose_gt("omd_pose_gt", "processed/pose_gt.txt", read_processed);
const Target omd_object_pose("omd_object_pose", "processed/object_pose.txt", read_processed);

const Target euroc_camera("euroc_camera_yaml", "cam0/sensor.yaml", [](const fs::path& file) {
  beside(file, "data.csv", "0,a.png\n");
  beside(file, "data/a.png", "");
  read_euroc_camera(file.parent_path());
});
const Target euroc_images("euroc_images_csv", "cam0/data.csv", [](const fs::path& file) {
  beside(file, "sensor.yaml", kEurocCamera);
  beside(file, "data/a.png", "");
  read_euroc_camera(file.parent_path());
});

// The whole import, of one image of 4x4 pixels.
void import_with(const fs::path& mav0) {
  beside(mav0 / "cam0", "cam0/sensor.yaml", kEurocCamera);
  beside(mav0 / "cam0", "cam0/data.csv", "1000000000,a.png\n");
  if (!fs::exists(mav0 / "cam0/data/a.png")) {
    fs::create_directories(mav0 / "cam0/data");
    write_png(mav0 / "cam0/data/a.png", cv::Mat::zeros(4, 4, CV_8UC1));
  }
  ImportEurocOptions options;
  options.stereo_depth = false;
  options.quiet = options.force = true;
  import_euroc(mav0.parent_path(), options, mav0.parent_path().parent_path() / "imported");
}
const Target euroc_imu("euroc_imu_csv", "recording/mav0/imu0/data.csv", [](const fs::path& file) {
  beside(file, "sensor.yaml", kEurocImu);
  import_with(file.parent_path().parent_path());
});
const Target euroc_states("euroc_states_csv", "recording/mav0/state_groundtruth_estimate0/data.csv",
                          [](const fs::path& file) { import_with(file.parent_path().parent_path()); });

}  // namespace
}  // namespace uniquadric::fuzz
