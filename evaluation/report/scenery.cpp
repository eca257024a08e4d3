#include "evaluation/report/scenery.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/files.h"
#include "core/import/rectify.h"
#include "core/sequence/ply.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "evaluation/report/absence.h"
#include "evaluation/report/jpeg.h"
#include "evaluation/report/page.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kJpegQuality = 60;   // ours: the outlines are drawn by the page, sharp
constexpr std::size_t kViews = 8;  // ours: depth images or scans that make the cloud
constexpr double kFarthest = 4;  // ours: points further than this many medians are not of the scene's middle
constexpr int kDiffuse = 150;    // of intensities: what is above is a retro-reflector

// The image of an ideal lens, shrunk.
cv::Mat small_image(const cv::Mat& image, const Camera& camera, int width_px) {
  const double scale = static_cast<double>(width_px) / camera.width;
  const cv::Size size(width_px, std::max(1, static_cast<int>(std::lround(camera.height * scale))));
  cv::Mat shrunk;
  cv::resize(rectify(camera, image, true), shrunk, size, 0, 0, cv::INTER_AREA);
  return shrunk;
}

json write_frames(const Sequence& sequence, const SceneryOptions& options, const fs::path& folder) {
  fs::create_directories(folder);
  json list = json::array();
  const std::size_t count =
      std::min(sequence.frames.size(), static_cast<std::size_t>(std::max(options.frames, 0)));
  for (const std::size_t i : evenly_spaced(sequence.frames.size(), count)) {
    const SequenceFrame& frame = sequence.frames[i];
    const cv::Mat image = small_image(read_rgb(sequence, frame), sequence.camera,
                                      std::min(options.width_px, sequence.camera.width));
    write_jpeg(folder / fmt::format("{:06}.jpg", frame.frame), image, kJpegQuality);
    list.push_back({{"frame", frame.frame}, {"stamp_ns", frame.stamp_ns}});
  }
  return list;
}

json camera_json(const Camera& camera) {
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
          {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy}};
}

json millimetres(const std::vector<Eigen::Vector3f>& points) {
  json list = json::array();
  for (const Eigen::Vector3f& point : points)
    for (int i = 0; i < 3; ++i) list.push_back(std::lround(1000 * point[i]));
  return list;
}

// Corners in one cell of a grid become one, their mean; triangles that lose a side go.
SurfaceFile clustered(const SurfaceFile& mesh, float cell_m) {
  std::map<std::array<long, 3>, std::uint32_t> cells;
  std::vector<float> counts;
  std::vector<std::uint32_t> cluster_of;
  SurfaceFile result;
  for (const Eigen::Vector3f& point : mesh.points) {
    std::array<long, 3> cell{};
    for (std::size_t i = 0; i < 3; ++i) cell[i] = std::lround(point[static_cast<Eigen::Index>(i)] / cell_m);
    const auto [found, is_new] = cells.emplace(cell, static_cast<std::uint32_t>(result.points.size()));
    if (is_new) result.points.push_back(Eigen::Vector3f::Zero()), counts.push_back(0);
    cluster_of.push_back(found->second);
    result.points[found->second] += point;
    ++counts[found->second];
  }
  for (std::size_t i = 0; i < counts.size(); ++i) result.points[i] /= counts[i];
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::array<std::uint32_t, 3> corners{cluster_of[a], cluster_of[b], cluster_of[c]};
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
      result.triangles.push_back(corners);
  }
  return result;
}

// With at most so many triangles: the finest of grids each a quarter coarser than the one before.
SurfaceFile simplified(const SurfaceFile& mesh, std::size_t most_triangles) {
  if (mesh.triangles.size() <= most_triangles) return mesh;
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& point : mesh.points) box.extend(point);
  SurfaceFile result = mesh;
  for (float cell_m = box.sizes().norm() / 200; result.triangles.size() > most_triangles; cell_m *= 1.25f)
    result = clustered(mesh, cell_m);
  return result;
}

json meshes_json(const Tracks& truth, const fs::path& folder, std::size_t most_triangles) {
  json list = json::array();
  for (const ObjectTrack& object : truth.objects) {
    const fs::path file = folder / "objects" / fmt::format("{}.ply", object.id);
    if (!fs::exists(file)) continue;
    const SurfaceFile mesh = simplified(read_surface_ply(file), most_triangles);
    json triangles = json::array();
    for (const auto& corners : mesh.triangles)
      for (const std::uint32_t corner : corners) triangles.push_back(corner);
    if (!triangles.empty())
      list.push_back(
          {{"id", object.id}, {"positions_mm", millimetres(mesh.points)}, {"triangles", triangles}});
  }
  return list;
}

struct Cloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<unsigned> colors;
};

void add_depth(const Sequence& sequence, const SequenceFrame& frame, const Pose& world_from_camera,
               std::size_t count, Cloud& cloud) {
  const cv::Mat depth = read_depth(sequence, frame), color = read_rgb(sequence, frame);
  const int step = std::max(
      1, static_cast<int>(std::sqrt(static_cast<double>(depth.total()) / static_cast<double>(count))));
  std::vector<float> depths;
  for (int v = step / 2; v < depth.rows; v += step)
    for (int u = step / 2; u < depth.cols; u += step)
      if (depth.at<float>(v, u) > 0) depths.push_back(depth.at<float>(v, u));
  if (depths.empty()) return;
  std::nth_element(depths.begin(), depths.begin() + std::ssize(depths) / 2, depths.end());
  const double farthest_m = kFarthest * depths[depths.size() / 2];
  for (int v = step / 2; v < depth.rows; v += step)
    for (int u = step / 2; u < depth.cols; u += step) {
      const double depth_m = depth.at<float>(v, u);
      const auto ray = sequence.camera.unproject({u, v});
      if (!(depth_m > 0 && depth_m < farthest_m) || !ray) continue;
      const auto& bgr = color.at<cv::Vec3b>(v, u);
      cloud.points.push_back((world_from_camera * Eigen::Vector3d(depth_m * *ray)).cast<float>());
      cloud.colors.push_back(bgr[2] * 0x10000u + bgr[1] * 0x100u + bgr[0]);
    }
}

void add_scan(const fs::path& file, const Pose& world_from_lidar, std::size_t count, Cloud& cloud) {
  const std::vector<LidarPoint> points = read_lidar_points(file);
  const std::size_t step = std::max<std::size_t>(1, points.size() / count);
  for (std::size_t i = 0; i < points.size(); i += step) {
    const auto grey = static_cast<unsigned>(80 + 175 * std::clamp(points[i].intensity / kDiffuse, 0.f, 1.f));
    cloud.points.push_back(
        (world_from_lidar * Eigen::Vector3d(points[i].x, points[i].y, points[i].z)).cast<float>());
    cloud.colors.push_back(grey * 0x10101u);
  }
}

const Pose* nearest_pose(const Trajectory& camera, std::int64_t stamp_ns) {
  const auto nearest = std::min_element(camera.begin(), camera.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.stamp_ns - stamp_ns) < std::abs(b.stamp_ns - stamp_ns);
  });
  return nearest == camera.end() ? nullptr : &nearest->pose;
}

// Of evenly spaced depth images; of scans where there is no depth, each as if taken at once.
json cloud_json(const Sequence& sequence, const Trajectory& camera, std::size_t points) {
  std::vector<const SequenceFrame*> with_depth;
  for (const SequenceFrame& frame : sequence.frames)
    if (!frame.depth.empty() && camera_pose_at(camera, frame.stamp_ns)) with_depth.push_back(&frame);
  Cloud cloud;
  for (const std::size_t i : evenly_spaced(with_depth.size(), std::min(kViews, with_depth.size())))
    add_depth(sequence, *with_depth[i], *camera_pose_at(camera, with_depth[i]->stamp_ns), points / kViews,
              cloud);
  if (with_depth.empty() && sequence.lidar && !camera.empty())
    for (const std::size_t i :
         evenly_spaced(sequence.scans.size(), std::min(kViews, sequence.scans.size()))) {
      const SequenceScan& scan = sequence.scans[i];
      add_scan(sequence.folder / scan.file,
               *nearest_pose(camera, scan.stamp_ns) * sequence.lidar->camera_from_lidar, points / kViews,
               cloud);
    }
  return {{"positions_mm", millimetres(cloud.points)}, {"colors", cloud.colors}};
}

}  // namespace

void write_scenery(const fs::path& sequence_folder, const fs::path& truth_folder, const fs::path& out,
                   const SceneryOptions& options, bool force) {
  const Sequence sequence = open_sequence(sequence_folder);
  const Tracks truth = truth_folder.empty() ? Tracks{} : read_tracks(truth_folder);
  PendingFolder folder(out, "scenery", force);
  const json scenery = {{"camera", camera_json(sequence.camera)},
                        {"frames", write_frames(sequence, options, folder.path() / "frames")},
                        {"meshes", meshes_json(truth, truth_folder, options.triangles)},
                        {"cloud", cloud_json(sequence, truth.camera, options.points)}};
  write_text(folder.path() / "scenery.json", scenery.dump() + '\n');
  folder.commit();
}

}  // namespace uniquadric
