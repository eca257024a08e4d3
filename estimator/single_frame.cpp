#include "estimator/single_frame.h"

#include <chrono>

#include "core/geometry/box_symmetry.h"
#include "estimator/shape/object_points.h"

namespace uniquadric {
namespace {

// Adds the time since it was last asked to a stage.
class Stopwatch {
 public:
  explicit Stopwatch(std::vector<std::pair<const char*, double>>& stages) : stages_(stages) {}
  void stop(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    for (auto& [name, sum] : stages_)
      if (name == stage) {
        sum += ms;
        return;
      }
    stages_.emplace_back(stage, ms);
  }

 private:
  std::vector<std::pair<const char*, double>>& stages_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

std::vector<int> ids_in(const cv::Mat& masks) {
  std::set<int> ids;
  for (int v = 0; v < masks.rows; ++v)
    for (int u = 0; u < masks.cols; ++u) ids.insert(masks.at<std::uint16_t>(v, u));
  ids.erase(0);
  return {ids.begin(), ids.end()};
}

ObjectState state_of(const SequenceFrame& frame, const Pose& world_from_camera, const ObbEstimate& obb) {
  ObjectState state;
  state.frame = frame.frame;
  state.stamp_ns = frame.stamp_ns;
  state.ellipsoid = inscribed_ellipsoid(obb.box);
  state.ellipsoid.world_from_object = world_from_camera * state.ellipsoid.world_from_object;
  state.ellipsoid.world_from_object.rotation.normalize();
  state.covariance_diagonal.head<3>() = obb.semi_axes_std_m.cwiseAbs2();
  return state;
}

}  // namespace

FrameEstimate estimate_frame(const Sequence& sequence, const SequenceFrame& frame, const Segmenter& segmenter,
                             const Variant& variant, const std::optional<Pose>& world_from_camera,
                             std::uint64_t seed) {
  FrameEstimate result;
  result.has_depth = !frame.depth.empty();
  result.has_pose = world_from_camera.has_value();
  Stopwatch watch(result.timing_ms);
  if (!result.has_depth) return result;
  const cv::Mat depth = read_depth(sequence, frame);
  watch.stop("read");
  result.masks = segment(segmenter, sequence, frame, depth, seed);
  watch.stop("segment");
  result.has_masks = !result.masks.empty();
  if (!result.has_masks || !result.has_pose) return result;
  const Eigen::Matrix3d world_axes_in_camera = world_from_camera->rotation.toRotationMatrix().transpose();
  for (const int id : ids_in(result.masks)) {
    const Eigen::Matrix3Xd points = object_points(depth, result.masks == id, sequence.camera, variant.points);
    watch.stop("points");
    RandomStream random(seed, "obb_ransac", frame.frame, id);
    const auto obb = fit_obb_ransac(points, variant.obb, world_axes_in_camera, random);
    watch.stop("shape");
    if (obb)
      result.states.emplace(id, state_of(frame, *world_from_camera, *obb));
    else
      ++result.objects_without_state;
  }
  return result;
}

void follow_axes(ObjectTrack& track) {
  for (std::size_t i = 1; i < track.states.size(); ++i) {
    const auto axes = [&](std::size_t k) {
      return track.states[k].ellipsoid.world_from_object.rotation.toRotationMatrix();
    };
    ObjectState& state = track.states[i];
    const Eigen::Matrix3d P = nearest_box_rotation(axes(i), axes(i - 1));
    state.ellipsoid = relabel_axes(state.ellipsoid, P);
    state.covariance_diagonal.head<3>() =
        (P.cwiseAbs().transpose() * state.covariance_diagonal.head<3>()).eval();
  }
}

}  // namespace uniquadric
