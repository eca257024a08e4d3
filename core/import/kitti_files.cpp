#include "core/import/kitti_files.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/import/fields.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kEarthRadiusM = 6378137;         // the devkit's
constexpr std::size_t kOxtsFields = 30;           // of which the first six are the pose
constexpr std::size_t kLabelFields = 17;          // results have a score besides
constexpr double kMostPrincipalPoint_px = 16384;  // as far as the largest image goes

struct Row {
  int line = 0;
  std::vector<double> values;
};

// A row by either of its names.
const Row* find_row(const std::map<std::string, Row, std::less<>>& rows, const char* name,
                    const char* other) {
  for (const char* key : {name, other})
    if (const auto found = rows.find(key); found != rows.end()) return &found->second;
  return nullptr;
}

const Row& row_of(const fs::path& path, const std::map<std::string, Row, std::less<>>& rows, const char* name,
                  const char* other, std::size_t count) {
  const Row* row = find_row(rows, name, other);
  if (!row) throw InputError(path, fmt::format("has no {}", name));
  if (row->values.size() != count)
    throw InputError(path, row->line,
                     fmt::format("{}: expected {} numbers, found {}", name, count, row->values.size()));
  return *row;
}

void read_projection(const fs::path& path, const Row& row, KittiCalibration& calibration) {
  const auto& p = row.values;
  Camera& camera = calibration.camera;
  camera.fx = p[0], camera.cx = p[2], camera.fy = p[5], camera.cy = p[6];
  if (!(camera.fx > 0 && camera.fy > 0) || p[1] != 0 || p[4] != 0 || p[8] != 0 || p[9] != 0 || p[10] != 1)
    throw InputError(path, row.line, "P2: expected fx 0 cx ? 0 fy cy ? 0 0 1 ?");
  for (const double place : {camera.cx, camera.cy})
    if (!(place > 0 && place < kMostPrincipalPoint_px))
      throw InputError(path, row.line,
                       fmt::format("P2: expected a principal point from 0 to {} px, found {}",
                                   kMostPrincipalPoint_px, place));
  const Eigen::Vector3d last(p[3], p[7], p[11]);
  calibration.camera_from_rectified.translation = camera.matrix().inverse() * last;
}

Pose label_pose(const std::vector<double>& v) {  // h w l x y z ry
  Eigen::Matrix3d camera_from_upright;
  camera_from_upright << 1, 0, 0, 0, 0, -1, 0, 1, 0;  // columns: length, width, up
  return {(Eigen::AngleAxisd(v[6], Eigen::Vector3d::UnitY()) * Eigen::Quaterniond(camera_from_upright))
              .normalized(),
          {v[3], v[4] - v[0] / 2, v[5]}};
}

}  // namespace

KittiCalibration read_kitti_calibration(const fs::path& path, bool needs_imu) {
  std::map<std::string, Row, std::less<>> rows;
  for_each_line(path, [&](int line, const Fields& fields) {
    std::string key(fields[0]);
    if (key.ends_with(':')) key.pop_back();
    if (!rows.try_emplace(key, Row{line, read_numbers(path, line, fields, 1)}).second)
      throw InputError(path, line, fmt::format("{} stands twice", key));
  });
  KittiCalibration calibration;
  read_projection(path, row_of(path, rows, "P2", "P2", 12), calibration);
  const auto pose = [&](const char* name, const char* other, std::size_t count) {
    const Row& row = row_of(path, rows, name, other, count);
    return read_pose_rows(path, row.line, row.values);
  };
  const Pose rectified_from_camera0 = pose("R_rect", "R0_rect", 9);
  calibration.camera_from_velodyne =
      calibration.camera_from_rectified * rectified_from_camera0 * pose("Tr_velo_cam", "Tr_velo_to_cam", 12);
  if (needs_imu) calibration.velodyne_from_imu = pose("Tr_imu_velo", "Tr_imu_to_velo", 12);
  return calibration;
}

Pose camera_from_velodyne_axes() {
  Eigen::Matrix3d rotation;
  rotation << 0, -1, 0, 0, 0, -1, 1, 0, 0;  // columns: forward, left, up in the optical frame
  return {Eigen::Quaterniond(rotation), Eigen::Vector3d::Zero()};
}

std::vector<KittiLabel> read_kitti_labels(const fs::path& path, std::int64_t frames) {
  std::vector<KittiLabel> labels;
  std::set<std::pair<std::int64_t, int>> seen;
  for_each_line(path, [&](int line, const Fields& fields) {
    if (fields.size() != kLabelFields && fields.size() != kLabelFields + 1)
      throw InputError(path, line, fmt::format("expected {} fields, found {}", kLabelFields, fields.size()));
    if (fields[2] == "DontCare") return;
    KittiLabel label;
    label.frame = read_count(path, line, fields[0], "frame", frames);
    label.id = static_cast<int>(read_count(path, line, fields[1], "track", std::numeric_limits<int>::max()));
    label.type = fields[2];
    const auto box = read_numbers(path, line, Fields(fields.begin() + 10, fields.begin() + kLabelFields));
    if (!(box[0] > 0 && box[1] > 0 && box[2] > 0))
      throw InputError(path, line, fmt::format("a box of {} x {} x {} m", box[2], box[1], box[0]));
    if (std::abs(box[6]) > 2 * std::numbers::pi)
      throw InputError(path, line, fmt::format("a rotation_y of {} is no angle in radians", box[6]));
    if (!is_plain_name(label.type)) throw InputError(path, line, "the type is no plain name");
    label.semi_axes_m = Eigen::Vector3d(box[2], box[1], box[0]) / 2;
    label.rectified_from_object = label_pose(box);
    if (!seen.insert({label.frame, label.id}).second)
      throw InputError(path, line, fmt::format("track {} stands twice in frame {}", label.id, label.frame));
    labels.push_back(label);
  });
  return labels;
}

int first_free_id(const std::vector<KittiLabel>& labels) {
  int free_id = 1;
  for (const KittiLabel& label : labels) free_id = std::max(free_id, label.id + 1);
  return free_id;
}

int object_id(const KittiLabel& label, int free_id) {
  return label.id > 0 ? label.id : free_id;
}

std::vector<Pose> read_kitti_poses(const fs::path& path) {
  std::vector<Pose> poses;
  for_each_line(path, [&](int line, const Fields& fields) {
    const auto values = read_numbers(path, line, fields);
    if (values.size() != 12)
      throw InputError(path, line, fmt::format("expected 12 numbers, found {}", values.size()));
    poses.push_back(camera_from_velodyne_axes().inverse() * read_pose_rows(path, line, values));
  });
  return poses;
}

std::vector<Pose> read_kitti_oxts(const fs::path& path) {
  std::vector<Pose> poses;
  double scale = 1;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  for_each_line(path, [&](int line, const Fields& fields) {
    const auto v = read_numbers(path, line, fields);
    if (v.size() != kOxtsFields)
      throw InputError(path, line, fmt::format("expected {} numbers, found {}", kOxtsFields, v.size()));
    constexpr double kRad = std::numbers::pi / 180;
    if (!(std::abs(v[0]) < 90)) throw InputError(path, line, fmt::format("a latitude of {} degrees", v[0]));
    if (poses.empty()) scale = std::cos(v[0] * kRad);
    const Eigen::Vector3d place(scale * kEarthRadiusM * v[1] * kRad,
                                scale * kEarthRadiusM * std::log(std::tan((90 + v[0]) * kRad / 2)), v[2]);
    if (poses.empty()) first = place;
    poses.push_back({Eigen::AngleAxisd(v[5], Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(v[4], Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(v[3], Eigen::Vector3d::UnitX()),
                     place - first});
  });
  return poses;
}

}  // namespace uniquadric
