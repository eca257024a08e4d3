#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/import/fields.h"
#include "core/import/images.h"
#include "core/import/omd_readers.h"
#include "core/import/pinhole.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kDepthUnitsPerM = 1000, kCameraRateHz = 30, kImuRateHz = 100;
constexpr std::int64_t kMostFrames = 10'000'000;
// s, ns, quaternion (the unit's own filter's), angular velocity, acceleration
constexpr std::size_t kImuColumns = 12;
const char* const kPayload = "sensor_payload";

// The only file NAME*.yaml of a folder; nothing where there is none.
std::optional<fs::path> dated_file(const fs::path& folder, const std::string& name) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().filename().string().starts_with(name) && entry.path().extension() == ".yaml")
      found.push_back(entry.path());
  if (found.size() > 1)
    throw InputError(folder, fmt::format("has {} files {}*.yaml, expected one", found.size(), name));
  return found.empty() ? std::nullopt : std::optional(found.front());
}

fs::path calibration_file(const fs::path& recording, const fs::path& wanted, const std::string& name) {
  const fs::path above = fs::weakly_canonical(recording).parent_path();
  for (const fs::path& folder : wanted.empty() ? std::vector{recording, above} : std::vector{wanted}) {
    if (!fs::is_directory(folder)) throw InputError(folder, "is not a folder");
    if (const auto file = dated_file(folder, name)) return *file;
  }
  throw InputError(wanted.empty() ? recording : wanted, fmt::format("has no {}*.yaml", name));
}

struct Rig {
  Pose left_from_rgbd;                  // cam0 from cam2
  std::optional<Pose> camera_from_imu;  // of cam2, where kalibr says it
};

Rig read_rig(const fs::path& path, Camera& camera) {
  const ConfigNode cameras = ConfigNode::load(path);
  const ConfigNode rgbd = cameras.at("cam2");
  camera = read_pinhole_camera(rgbd, "distortion_coeffs");
  const Pose right_from_left = read_pose_matrix(cameras.at("cam1").at("T_cn_cnm1"));
  const Pose rgbd_from_right = read_pose_matrix(rgbd.at("T_cn_cnm1"));
  Rig rig;
  rig.left_from_rgbd = right_from_left.inverse() * rgbd_from_right.inverse();
  if (const auto own = rgbd.find("T_cam_imu")) {
    rig.camera_from_imu = read_pose_matrix(*own);
  } else if (const auto left = cameras.find("cam0"); left && left->find("T_cam_imu")) {
    rig.camera_from_imu = rig.left_from_rgbd.inverse() * read_pose_matrix(left->at("T_cam_imu"));
  }
  return rig;
}

void read_imu(const fs::path& path, const Rig& rig, Recording& recording) {
  if (!fs::exists(path)) return;
  if (!rig.camera_from_imu) {
    recording.left_out.push_back(
        fmt::format("{}: left out, for kalibr's file has no T_cam_imu that says its place", path.string()));
    return;
  }
  recording.imu = read_imu_rows(path, kImuColumns, [&](int line, const Fields& fields) {
    return read_seconds_and_ns(path, line, fields[0], fields[1]);
  });
  ImuCalibration& imu = recording.sequence.imu.emplace();
  imu.camera_from_imu = *rig.camera_from_imu;
  imu.rate_hz = nominal_rate_hz(stamps_of(recording.imu), kImuRateHz);
}

void read_truth(const fs::path& path, const Pose& payload_from_camera, const ImportOmdOptions& options,
                Recording& recording) {
  ViconFile vicon = read_vicon(path, options.vicon_offset_s);
  if (vicon.dropped > 0)
    recording.left_out.push_back(
        fmt::format("{}: {} rows without a name or with NaN are left out", path.string(), vicon.dropped));
  const auto payload = vicon.bodies.find(kPayload);
  if (payload == vicon.bodies.end()) throw InputError(path, fmt::format("has no row of {}", kPayload));
  Trajectory world_from_camera = payload->second;
  for (StampedPose& pose : world_from_camera) {
    pose.pose = pose.pose * payload_from_camera;
    pose.pose.rotation.normalize();
  }
  vicon.bodies.erase(payload);
  set_truth(
      camera_poses(path, world_from_camera, recording, kMaxPoseGap_s, ", see --vicon-offset"), vicon.bodies,
      [](const auto& object) { return object.name; }, options.objects, recording);
}

}  // namespace

void read_rgbd(const fs::path& folder, Recording& recording) {
  const fs::path list = folder / "rgbd.csv";
  std::optional<std::int64_t> before_ns;
  std::size_t single = 0;
  for_each_row(list, 3, [&](int line, const Fields& fields) {
    const std::int64_t index = read_count(list, line, fields[0], "frame_num", kMostFrames);
    const std::int64_t stamp_ns = read_seconds_and_ns(list, line, fields[1], fields[2]);
    require_later(list, line, before_ns, stamp_ns);
    before_ns = stamp_ns;
    const fs::path color = folder / fmt::format("{:06}_color.png", index);
    const fs::path depth = folder / fmt::format("{:06}_aligned_depth.png", index);
    if (!fs::exists(color) || !fs::exists(depth)) {
      ++single;
      return;
    }
    SequenceFrame& frame = add_frame(recording.sequence, stamp_ns, fmt::format("rgb/{:06}.png", index));
    frame.depth = fmt::format("depth/{:06}.png", index);
    recording.images.push_back({color, frame.rgb, ImageKind::color, make_color});
    recording.images.push_back({depth, frame.depth, ImageKind::depth});
  });
  if (recording.sequence.frames.empty()) throw InputError(list, "names no index that has both images");
  if (single > 0)
    recording.left_out.push_back(
        fmt::format("{}: {} indices without both images are left out", list.string(), single));
  recording.sequence.rate_hz = nominal_rate_hz(stamps_of(recording.sequence.frames), kCameraRateHz);
}

Recording read_omd_raw(const fs::path& folder, const ImportOmdOptions& options) {
  Recording recording;
  recording.sequence = begin_sequence(recording_name(folder));
  recording.sequence.depth_units_per_m = kDepthUnitsPerM;
  const Rig rig =
      read_rig(calibration_file(folder, options.calibration, "kalibr"), recording.sequence.camera);
  read_rgbd(folder / "rgbd", recording);
  read_imu(folder / "imu.csv", rig, recording);
  if (fs::exists(folder / "vicon.csv")) {
    const ConfigNode vicon = ConfigNode::load(calibration_file(folder, options.calibration, "vicon"));
    const Pose payload_from_left = read_pose_matrix(vicon.at("T_apparatus_left"));
    read_truth(folder / "vicon.csv", payload_from_left * rig.left_from_rgbd, options, recording);
  }
  return recording;
}

}  // namespace uniquadric
