// How far the points of bodies that the estimator makes of a LiDAR's lie off the bodies' true surfaces, by
// what is undone of the motion during a scan (Eq. 2 to 4), and how true the depth of pixels and features is:
// undistortion_accuracy SCENE.yaml DATA VARIANT.yaml [FIGURE.svg OBJECT FRAME]; DATA is what
// `uniquadric simulate SCENE.yaml DATA` wrote. Masks, camera path and motions are estimated. The figure shows
// an object's points in one frame.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <map>
#include <opencv2/core/utility.hpp>

#include "benchmarks/ego_pairs.h"
#include "benchmarks/exact_depth.h"
#include "benchmarks/undistortion_svg.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/sequence.h"
#include "estimator/ego/lidar_ego.h"
#include "estimator/features/features.h"
#include "estimator/lidar/lidar_depth.h"
#include "estimator/lidar/lidar_stream.h"
#include "estimator/mask_tracking/aot.h"
#include "estimator/variant.h"
#include "evaluation/metrics/surface_distance.h"
#include "simulator/render/renderer.h"
#include "simulator/scene/mesh_building.h"
#include "simulator/scene/scene.h"

namespace uniquadric {
namespace {

enum Way { none, ego, object, told_truth };
constexpr std::array kTitles = {"nothing undone", "the sensor's motion", "and the body's, estimated",
                                "and the body's true motion"};
constexpr std::int64_t kScan_ns = 100'000'000;
constexpr double kMostNoise_m = 0.15;
constexpr std::array kWays = {"none", "ego", "object", "object, true motion"};

double share_of(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

struct BodyFigures {
  std::array<std::vector<double>, kWays.size()> off_m;  // of points, from the true surface
  std::array<int, kWays.size()> frames{};
  std::vector<double> speed_mps, velocity_error_mps, depth_error_m, feature_error_m;
};

// Which object each track is: the one under most pixels of its mask.
std::map<int, std::size_t> objects_of(const Scene& scene, const cv::Mat& masks, const cv::Mat& ids) {
  std::map<int, std::map<int, int>> votes;
  for (int v = 0; v < masks.rows; ++v)
    for (int u = 0; u < masks.cols; ++u)
      if (const int label = masks.at<std::uint16_t>(v, u)) ++votes[label][ids.at<std::uint16_t>(v, u)];
  std::map<int, std::size_t> result;
  for (const auto& [label, counts] : votes) {
    const int id = std::max_element(counts.begin(), counts.end(), [](auto& a, auto& b) {
                     return a.second < b.second;
                   })->first;
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
      if (scene.objects[i].id == id) result[label] = i;
  }
  return result;
}

SurfaceDistance surface_of(const Body& body) {
  Mesh whole;
  for (const Mesh& mesh : body.meshes) merge(whole, mesh);
  return {std::move(whole.positions), std::move(whole.triangles)};
}

// The static world's returns of the last scan, by how they are brought to one time.
struct WorldFigures {
  std::array<std::vector<double>, 3> off_m;  // nothing undone, the estimated motion, the true one
};

struct Wanted {
  std::string object;
  std::int64_t frame = -1;
};

struct Run {
  const Scene scene;
  const Variant variant;
  const Sequence sequence;
  Renderer renderer{scene};
  LidarEgo lidar{sequence, variant.perception.lidar};
  AsyncObjectTracker tracker{
      sequence.camera,
      slow_segmenter(sequence, make_segmenter(sequence, variant.perception.segmentation, {}),
                     variant.perception.aot, 0),
      variant.perception.aot};
  FeatureTracker features{sequence.camera, variant.perception.features, 0};
  std::vector<FramePointSource> points;  // and depths: of each way
  std::vector<LidarDepth> depths;
  std::vector<SurfaceDistance> surfaces;
  std::vector<BodyFigures> figures;
  std::vector<SurfaceDistance> world;
  LidarStream stream{sequence};
  std::deque<TimedPoint> returns;  // of the last scan's time
  WorldFigures walls;
  Wanted wanted;
  std::vector<UndistortionPanel> panels;
  std::optional<ScenePoses> last;
  std::optional<Pose> last_camera;  // as it is estimated
  std::int64_t last_ns = 0;
  std::array<double, kWays.size()> ms{};

  Run(const char* scene_file, const std::filesystem::path& data, const char* variant_file)
      : scene(load_scene(scene_file)),
        variant(load_variant(variant_file)),
        sequence(on_camera_clock(open_sequence(data / "sequence"), variant.perception.lidar_time_offset_ns)),
        figures(scene.objects.size()) {
    for (const Body& body : scene.objects) surfaces.push_back(surface_of(body));
    for (const Body& body : scene.world) world.push_back(surface_of(body));
    const auto path = [this](std::int64_t ns) { return lidar.odometry().world_from_camera(ns); };
    LidarDepthOptions options = variant.perception.lidar_depth;
    for (std::size_t way = 0; way < kWays.size(); ++way) {
      options.undistortion = way == none  ? Undistortion::none
                             : way == ego ? Undistortion::ego
                                          : Undistortion::object;
      if (way == told_truth) options.motion = MotionSource::features;
      points.emplace_back(sequence, path, frame_point_options(options));
      depths.emplace_back(sequence, options);
    }
  }

  // In the estimated world, so that the camera's errors are those of the other ways.
  Pose true_motion(const ScenePoses& now, const Pose& camera, std::size_t object) const {
    const Pose here = now.world_from_camera.inverse() * now.world_from_object[object];
    const Pose before = last->world_from_camera.inverse() * last->world_from_object[object];
    return camera * here * before.inverse() * last_camera->inverse();
  }

  void judge_points(std::int64_t number, const LidarView& view, const ScenePoses& now,
                    const std::map<int, std::size_t>& objects, std::size_t way) {
    for (const auto& [label, body] : view.bodies) {
      const auto object = objects.find(label);
      if (object == objects.end()) continue;
      BodyFigures& f = figures[object->second];
      const Pose object_from_camera = now.world_from_object[object->second].inverse() * now.world_from_camera;
      for (const auto& point : body.points.colwise())
        f.off_m[way].push_back(surfaces[object->second].at(object_from_camera * Eigen::Vector3d(point)));
      ++f.frames[way];
      if (number == wanted.frame && scene.objects[object->second].name == wanted.object)
        keep_panel(body, object_from_camera, object->second, way);
    }
  }

  double off_world_m(const Eigen::Vector3d& point) const {
    double least = 1;
    for (std::size_t i = 0; i < world.size(); ++i)
      least = std::min(least, world[i].at(scene.world[i].motion.at(0).inverse() * point, least));
    return least;
  }

  // In every tenth frame, some of the returns.
  void judge_walls(const SequenceFrame& frame) {
    for (const TimedPoint& p : stream.take(frame.stamp_ns)) returns.push_back(p);
    while (!returns.empty() && frame.stamp_ns - returns.front().stamp_ns > kScan_ns) returns.pop_front();
    const auto here = lidar.odometry().world_from_camera(frame.stamp_ns);
    if (frame.frame % 10 != 0 || !here) return;
    const Pose now = scene.camera_motion.at(1e-9 * double(frame.stamp_ns));
    for (std::size_t i = 0; i < returns.size(); i += 20) {
      const TimedPoint& p = returns[i];
      const Eigen::Vector3d in_camera = sequence.lidar->camera_from_lidar * p.lidar.cast<double>();
      const auto then = lidar.odometry().world_from_camera(p.stamp_ns);
      const Eigen::Vector3d truth = scene.camera_motion.at(1e-9 * double(p.stamp_ns)) * in_camera;
      const double noise_m = off_world_m(truth);
      if (!then || noise_m > kMostNoise_m) continue;  // a body's
      walls.off_m[0].push_back(off_world_m(now * in_camera));
      walls.off_m[1].push_back(off_world_m(now * (here->inverse() * (*then * in_camera))));
      walls.off_m[2].push_back(noise_m);
    }
  }

  void keep_panel(const SurfacePoints& body, const Pose& object_from_camera, std::size_t object,
                  std::size_t way) {
    UndistortionPanel panel;
    std::vector<double> off_m;
    for (const auto& point : body.points.colwise()) {
      panel.points.push_back(object_from_camera * Eigen::Vector3d(point));
      off_m.push_back(surfaces[object].at(panel.points.back()));
    }
    panel.title = kTitles[way];
    panel.subtitle = fmt::format("median {:.0f} mm off the surface, nine tenths {:.0f} mm",
                                 1e3 * share_of(off_m, 0.5), 1e3 * share_of(off_m, 0.9));
    panels.push_back(std::move(panel));
  }

  void judge_depth(const cv::Mat& depth, const cv::Mat& masks, const RenderedFrame& image,
                   const std::map<int, std::size_t>& objects) {
    for (int v = 0; v < depth.rows; ++v)
      for (int u = 0; u < depth.cols; ++u) {
        const float z = depth.at<float>(v, u);
        const auto object = z > 0 ? objects.find(masks.at<std::uint16_t>(v, u)) : objects.end();
        if (object == objects.end() || image.ids.at<std::uint16_t>(v, u) != scene.objects[object->second].id)
          continue;
        figures[object->second].depth_error_m.push_back(std::abs(z - image.depth_m.at<float>(v, u)));
      }
  }

  void judge_features(const TrackedFeatures& tracked, const RenderedFrame& image,
                      const std::map<int, std::size_t>& objects) {
    for (const auto& [label, seen] : tracked.bodies) {
      const auto object = objects.find(label);
      if (object == objects.end()) continue;
      for (const Feature& f : seen) {
        const double z = exact_depth(image.depth_m, f.pixel);
        if (z > 0 && f.depth_m > 0)
          figures[object->second].feature_error_m.push_back(std::abs(z - f.depth_m));
      }
    }
  }

  void step(std::size_t index) {
    const SequenceFrame& frame = sequence.frames[index];
    const std::int64_t next_ns = index + 1 < sequence.frames.size() ? sequence.frames[index + 1].stamp_ns
                                                                    : 2 * frame.stamp_ns - last_ns;
    const cv::Mat rgb = read_rgb(sequence, frame);
    const cv::Mat masks = tracker.track(frame, rgb, {}, next_ns).masks;
    lidar.track(frame, masks);
    const auto camera = lidar.odometry().world_from_camera(frame.stamp_ns);
    const ScenePoses now = poses_at(scene, 1e-9 * double(frame.stamp_ns));
    const RenderedFrame& image = renderer.render(now);
    const auto objects = masks.empty() ? std::map<int, std::size_t>() : objects_of(scene, masks, image.ids);
    if (camera && last_camera)
      for (const auto& [label, i] : objects)
        depths[told_truth].moved(label, true_motion(now, *camera, i), frame.stamp_ns - last_ns);
    judge_walls(frame);
    cv::Mat depth;
    for (std::size_t way = 0; way < depths.size(); ++way) {
      const double start = now_ms();
      const FramePoints placed = points[way].take(frame.stamp_ns, next_ns, masks);
      const LidarView view = depths[way].at(placed, masks, depths[way].background(placed, masks));
      ms[way] += now_ms() - start;
      judge_points(frame.frame, view, now, objects, way);
      if (way == object) depth = view.depth;
    }
    const TrackedFeatures tracked = features.track(frame, rgb, depth, masks);
    if (!depth.empty() && !masks.empty()) {
      judge_depth(depth, masks, image, objects);
      judge_features(tracked, image, objects);
    }
    depths[object].saw(tracked.bodies);
    if (camera && last_camera)
      for (const auto& [label, motion] : tracked.motions) {
        const Pose world_motion = *camera * motion * last_camera->inverse();
        depths[object].moved(label, world_motion, frame.stamp_ns - last_ns);
        judge_motion(label, world_motion, now, *camera, objects, 1e-9 * double(frame.stamp_ns - last_ns));
      }
    last = now, last_camera = camera, last_ns = frame.stamp_ns;
  }

  void judge_motion(int label, const Pose& motion, const ScenePoses& now, const Pose& camera,
                    const std::map<int, std::size_t>& objects, double step_s) {
    const auto found = objects.find(label);
    if (found == objects.end()) return;
    const std::size_t i = found->second;
    const Pose true_step = true_motion(now, camera, i);
    const Eigen::Vector3d middle =
        *last_camera * last->world_from_camera.inverse() * last->world_from_object[i].translation;
    const auto between = [&](const ScenePoses& poses) {
      return Eigen::Vector3d(poses.world_from_object[i].translation - poses.world_from_camera.translation);
    };
    figures[i].speed_mps.push_back((between(now) - between(*last)).norm() / step_s);
    figures[i].velocity_error_mps.push_back((motion * middle - true_step * middle).norm() / step_s);
  }
};

void print(const std::string& name, const BodyFigures& f) {
  fmt::print("{}: {:.1f} m/s past the camera (most {:.1f}), motion off by {:.3f} m/s (nine tenths {:.3f})\n",
             name, share_of(f.speed_mps, 0.5), share_of(f.speed_mps, 1), share_of(f.velocity_error_mps, 0.5),
             share_of(f.velocity_error_mps, 0.9));
  for (std::size_t way = 0; way < kWays.size(); ++way)
    fmt::print("  {:20} {:4} frames {:7} points, off the surface by {:6.1f} mm (nine tenths {:6.1f})\n",
               kWays[way], f.frames[way], f.off_m[way].size(), 1e3 * share_of(f.off_m[way], 0.5),
               1e3 * share_of(f.off_m[way], 0.9));
  fmt::print("  depth of pixels off by {:.1f} mm (nine tenths {:.1f}), of features by {:.1f} mm ({:.1f})\n",
             1e3 * share_of(f.depth_error_m, 0.5), 1e3 * share_of(f.depth_error_m, 0.9),
             1e3 * share_of(f.feature_error_m, 0.5), 1e3 * share_of(f.feature_error_m, 0.9));
}

void print(const WorldFigures& walls) {
  constexpr std::array kNames = {"none", "ego", "ego, true motion"};
  fmt::print("static world, {} returns\n", walls.off_m[0].size());
  for (std::size_t way = 0; way < kNames.size(); ++way)
    fmt::print("  {:20} off the surface by {:6.1f} mm (nine tenths {:6.1f})\n", kNames[way],
               1e3 * share_of(walls.off_m[way], 0.5), 1e3 * share_of(walls.off_m[way], 0.9));
}

void write_figure(const Run& run, const char* file) {
  std::vector<Eigen::Vector3d> vertices;
  for (const Body& body : run.scene.objects)
    if (body.name == run.wanted.object)
      for (const Mesh& mesh : body.meshes)
        for (const Eigen::Vector3f& v : mesh.positions) vertices.push_back(v.cast<double>());
  if (vertices.empty() || run.panels.empty())
    throw InputError(file, "no points of such an object in such a frame");
  write_text(file, undistortion_svg(run.panels, vertices));
}

void run(int argc, char** argv) {
  Run run(argv[1], argv[2], argv[3]);
  if (argc > 6) run.wanted = {argv[5], std::atoll(argv[6])};
  for (std::size_t i = 0; i < run.sequence.frames.size(); ++i) run.step(i);
  for (std::size_t way = 0; way < kWays.size(); ++way)
    fmt::print("{}: {:.1f} ms a frame\n", kWays[way], run.ms[way] / double(run.sequence.frames.size()));
  for (std::size_t i = 0; i < run.figures.size(); ++i) print(run.scene.objects[i].name, run.figures[i]);
  print(run.walls);
  if (argc > 6) write_figure(run, argv[4]);
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  if (argc != 4 && argc != 7) {
    fmt::print(stderr,
               "usage: undistortion_accuracy SCENE.yaml DATA VARIANT.yaml [FIGURE.svg OBJECT FRAME]\n");
    return 2;
  }
  cv::setNumThreads(1);
  uniquadric::run(argc, argv);
}
