#include "estimator/perception/observe_bodies.h"

#include <set>

#include "estimator/lidar/point_colors.h"

namespace uniquadric {
namespace {

std::set<int> ids_in(const cv::Mat& masks) {
  std::set<int> ids;
  for (int v = 0; v < masks.rows; ++v) {
    const auto* row = masks.ptr<std::uint16_t>(v);
    for (int u = 0; u < masks.cols; ++u)
      if (row[u] != 0 && (u == 0 || row[u] != row[u - 1])) ids.insert(row[u]);
  }
  return ids;
}

std::map<int, Silhouette> outlines(const cv::Mat& masks, const cv::Mat& depth, const Camera& camera,
                                   const SilhouetteOptions& options, bool segmented,
                                   std::int64_t known_at_frame) {
  auto result = silhouettes(masks, depth, camera, options);
  for (auto& [id, silhouette] : result) {
    silhouette.segmented = segmented;
    silhouette.known_at_frame = known_at_frame;
  }
  return result;
}

SurfacePoints surface_of(int id, const Camera& camera, const PointOptions& options, FrameWork& work) {
  if (const auto found = work.surfaces.find(id); found != work.surfaces.end())
    return std::move(found->second);
  if (options.smooth_px > 0) return smoothed_points(work.depth, work.masks == id, camera, options);
  return {object_points(work.depth, work.masks == id, camera, options), {}};
}

// Without points that may be those of what the body stands on, unless most are near it: a sheet lies on a
// table.
void drop_support(const ContactPlane& plane, SurfacePoints& surface) {
  constexpr double kNoises = 2;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < surface.points.cols(); ++i)
    if (plane.normal.dot(surface.points.col(i)) + plane.offset_m > kNoises * plane.noise_m) kept.push_back(i);
  if (2 * std::ssize(kept) < surface.points.cols()) return;
  surface.points = Eigen::Matrix3Xd(surface.points(Eigen::all, kept));
  if (surface.normals.cols() > 0) surface.normals = Eigen::Matrix3Xd(surface.normals(Eigen::all, kept));
}

}  // namespace

BodyObservation& body_of(PerceivedFrame& frame, int id) {
  for (BodyObservation& body : frame.bodies)
    if (body.id == id) return body;
  frame.bodies.emplace_back().id = id;
  return frame.bodies.back();
}

void observe_bodies(const Camera& camera, const PerceptionOptions& options, std::uint64_t seed,
                    FrameWork& work) {
  Stopwatch watch(work.result.frame, work.times);
  if (work.masks.empty()) return;
  const std::int64_t frame = work.result.frame;
  for (auto& [id, silhouette] :
       outlines(work.masks, work.depth, camera, options.silhouettes, !options.aot.enabled, frame))
    body_of(work.result, id).silhouette = std::move(silhouette);
  for (const auto& [earlier, masks, depth] : work.arrived)
    work.late.push_back({earlier, outlines(masks, depth, camera, options.silhouettes, true, frame)});
  watch.stop("silhouettes");
  if (work.depth.empty()) return;
  for (const int id : ids_in(work.masks)) {
    BodyObservation& body = body_of(work.result, id);
    SurfacePoints surface = surface_of(id, camera, options.points, work);
    RandomStream random(seed, "contact", frame, id);
    body.contact = contact_plane(work.depth, work.masks, id, camera, options.contact, random);
    if (body.contact) drop_support(*body.contact, surface);
    body.points = std::move(surface.points);
    body.normals = std::move(surface.normals);
    if (body.normals.cols() > 0) body.colors = point_colors(work.rgb, camera, body.points);
  }
  watch.stop("points");
}

}  // namespace uniquadric
