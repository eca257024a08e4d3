// What feature tracking makes of a simulated sequence, against exact geometry:
// feature_accuracy SCENE.yaml DATA [FRAMES [SIGHTINGS.csv]]; DATA is what `uniquadric simulate SCENE.yaml
// DATA` wrote. Times are those of the processor, with OpenCV on one thread.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <map>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "benchmarks/exact_depth.h"
#include "core/base/error.h"
#include "core/sequence/sequence.h"
#include "estimator/features/features.h"
#include "simulator/render/renderer.h"
#include "simulator/scene/scene.h"

namespace uniquadric {
namespace {

// Figures of a set of numbers.
struct Numbers {
  std::vector<double> values;
  void add(double value) { values.push_back(value); }
  double rms() const {
    double sum = 0;
    for (const double v : values) sum += v * v;
    return std::sqrt(sum / std::max(1.0, double(values.size())));
  }
  double mean() const {
    double sum = 0;
    for (const double v : values) sum += v;
    return sum / std::max(1.0, double(values.size()));
  }
  double share(double p) const {
    if (values.empty()) return 0;
    auto copy = values;
    std::sort(copy.begin(), copy.end());
    return copy[std::min(copy.size() - 1, std::size_t(p * double(copy.size())))];
  }
};

struct KnownPoint {
  Eigen::Vector3d point;  // frame of the body
  std::int64_t first_frame = 0, last_frame = 0;
};

struct BodyFigures {
  Numbers count, motion_shift, motion_turn, depth_error, depth_chi, age, returned;
  std::map<int, Numbers> pixel_error;  // by age, in bins
  int off_body = 0, sightings = 0, frames = 0, motions = 0;
};

int age_bin(std::int64_t age) {
  for (const int limit : {1, 3, 10, 30, 100})
    if (age <= limit) return limit;
  return 1000;
}

struct Truth {
  ScenePoses poses;
  const RenderedFrame* image = nullptr;
  Pose camera_from(const Scene& scene, int label) const {
    if (label == 0) return poses.world_from_camera.inverse();
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
      if (scene.objects[i].id == label)
        return relative_pose(poses.world_from_camera, poses.world_from_object[i]);
    throw InputError("a mask has an id that the scene does not have");
  }
};

void judge_features(const std::vector<Feature>& features, int label, std::int64_t frame, const Camera& camera,
                    const Pose& camera_from_body, const RenderedFrame& image,
                    std::map<std::int64_t, KnownPoint>& points, BodyFigures& figures, std::ostream& csv) {
  figures.count.add(double(features.size()));
  ++figures.frames;
  for (const auto& f : features) {
    const int u = int(std::lround(f.pixel.x())), v = int(std::lround(f.pixel.y()));
    ++figures.sightings;
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height ||
        image.ids.at<std::uint16_t>(v, u) != label) {
      ++figures.off_body;
      continue;
    }
    const double z = exact_depth(image.depth_m, f.pixel);
    if (f.depth_m > 0 && z > 0) {
      figures.depth_error.add(f.depth_m - z);
      figures.depth_chi.add((f.depth_m - z) / f.depth_sigma_m);
    }
    const auto known = points.find(f.track);
    if (known == points.end()) {
      if (z > 0)
        points[f.track] = {camera_from_body.inverse() * (z * *camera.unproject(f.pixel)), frame, frame};
      continue;
    }
    const auto expected = camera.project(camera_from_body * known->second.point);
    if (!expected) continue;
    const double error = (*expected - f.pixel).norm();
    csv << fmt::format("{},{},{},{},{:.3f},{:.3f},{:.4f},{:.4f},{:.6f},{:.6f}\n", frame, label, f.track,
                       frame - known->second.first_frame, f.pixel.x(), f.pixel.y(),
                       f.pixel.x() - expected->x(), f.pixel.y() - expected->y(), z > 0 ? f.depth_m - z : 0,
                       f.depth_sigma_m);
    if (frame - known->second.last_frame > 3)
      figures.returned.add(error);
    else
      figures.pixel_error[age_bin(frame - known->second.first_frame)].add(error);
    figures.age.add(double(frame - known->second.first_frame));
    known->second.last_frame = frame;
  }
}

void judge_motion(const std::optional<Pose>& motion, const Pose& before, const Pose& now,
                  const Eigen::Vector3d& at, BodyFigures& figures) {
  if (!motion) return;
  const Pose error = (*motion) * (before * now.inverse());
  ++figures.motions;
  figures.motion_shift.add((error * at - at).norm());
  figures.motion_turn.add(log_so3(error.rotation).norm());
}

void print(int label, const BodyFigures& f) {
  fmt::print("label {}: frames {} features {:.0f} motions {} off-body {:.2f} % age {:.0f}\n", label, f.frames,
             f.count.mean(), f.motions, 100.0 * f.off_body / std::max(1, f.sightings), f.age.mean());
  fmt::print(
      "  motion: shift rms {:.2f} p95 {:.2f} max {:.2f} mm, turn rms {:.2f} p95 {:.2f} max {:.2f} mrad\n",
      1e3 * f.motion_shift.rms(), 1e3 * f.motion_shift.share(0.95), 1e3 * f.motion_shift.share(1),
      1e3 * f.motion_turn.rms(), 1e3 * f.motion_turn.share(0.95), 1e3 * f.motion_turn.share(1));
  fmt::print(
      "  depth: rms {:.2f} mm median {:.2f} mm, over sigma: rms {:.2f} median |.| {:.2f} p99 {:.1f}\n",
      1e3 * f.depth_error.rms(), 1e3 * f.depth_error.share(0.5), f.depth_chi.rms(),
      [&] {
        Numbers a;
        for (const double v : f.depth_chi.values) a.add(std::abs(v));
        return a.share(0.5);
      }(),
      f.depth_chi.share(0.99));
  for (const auto& [age, errors] : f.pixel_error)
    fmt::print("  age <= {:4}: {:6} sightings, pixel error rms {:.2f} median {:.2f} p95 {:.2f}\n", age,
               errors.values.size(), errors.rms(), errors.share(0.5), errors.share(0.95));
  if (!f.returned.values.empty())
    fmt::print("  returned: {} tracks, pixel error median {:.2f} p95 {:.2f}\n", f.returned.values.size(),
               f.returned.share(0.5), f.returned.share(0.95));
}

void run(const std::filesystem::path& scene_file, const std::filesystem::path& data, std::int64_t frames,
         const char* csv_file) {
  std::ofstream csv(csv_file);
  csv << "frame,label,track,age,u_px,v_px,error_u_px,error_v_px,depth_error_m,depth_sigma_m\n";
  cv::setNumThreads(1);
  const Scene scene = load_scene(scene_file);
  const Sequence sequence = open_sequence(data / "sequence");
  Renderer renderer(scene);
  FeatureTracker tracker(sequence.camera, {}, 0);
  std::map<int, BodyFigures> figures;
  std::map<std::int64_t, KnownPoint> points;
  std::optional<Truth> last;
  double ms = 0;
  const std::int64_t count = std::min<std::int64_t>(frames, std::ssize(sequence.frames));
  for (std::int64_t i = 0; i < count; ++i) {
    const SequenceFrame& frame = sequence.frames[i];
    const cv::Mat rgb = read_rgb(sequence, frame), depth = read_depth(sequence, frame);
    const cv::Mat masks = frame.masks.empty() ? cv::Mat() : read_masks(sequence, frame);
    const std::clock_t start = std::clock();
    const TrackedFeatures seen = tracker.track(frame, rgb, depth, masks);
    ms += 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    Truth truth{poses_at(scene, double(frame.stamp_ns) * 1e-9)};
    truth.image = &renderer.render(truth.poses);
    const auto judge = [&](int label, const std::vector<Feature>& features,
                           const std::optional<Pose>& motion) {
      const Pose now = truth.camera_from(scene, label);
      judge_features(features, label, i, sequence.camera, now, *truth.image, points, figures[label], csv);
      const Eigen::Vector3d at = label == 0 ? Eigen::Vector3d::Zero() : now.translation;
      if (last) judge_motion(motion, last->camera_from(scene, label), now, at, figures[label]);
    };
    judge(0, seen.background, seen.background_motion);
    for (const auto& [label, features] : seen.bodies)
      judge(label, features,
            seen.motions.contains(label) ? std::optional(seen.motions.at(label)) : std::nullopt);
    last = truth;
  }
  fmt::print("{}: {} frames, {:.1f} ms a frame\n", scene.name, count, ms / double(count));
  for (const auto& [label, f] : figures) print(label, f);
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "usage: feature_accuracy SCENE.yaml DATA [FRAMES [SIGHTINGS.csv]]\n");
    return 2;
  }
  uniquadric::run(argv[1], argv[2], argc > 3 ? std::atoll(argv[3]) : 1'000'000,
                  argc > 4 ? argv[4] : "/dev/null");
}
