#include "estimator/ego/rgbd_odometry.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "estimator/ego/ego_map.h"

namespace uniquadric {
namespace {

constexpr int kUprightTries = 10;  // frames in which the floor is looked for

double median_depth(const std::vector<Feature>& features) {
  std::vector<double> depths;
  for (const Feature& feature : features)
    if (feature.depth_m > 0) depths.push_back(feature.depth_m);
  if (depths.empty()) return 1;
  std::nth_element(depths.begin(), depths.begin() + depths.size() / 2, depths.end());
  return depths[depths.size() / 2];
}

// A frame's place: known at once, mended by what becomes of its keyframe and of the points it saw.
struct FramePose {
  std::int64_t frame = 0, stamp_ns = 0;
  int keyframe = 0;
  Pose camera_from_keyframe;
  std::vector<Feature> features;
};

std::vector<PointSighting> sightings_of(const EgoMap& map, const std::vector<Feature>& features) {
  std::vector<PointSighting> sightings;
  for (const Feature& f : features)
    if (const auto point = map.points.find(f.track); point != map.points.end())
      sightings.push_back({point->second.position, f.pixel, f.depth_m, f.depth_sigma_m});
  return sightings;
}

}  // namespace

struct RgbdOdometry::State {
  Camera camera;  // without distortion
  EgoOptions options;
  std::uint64_t seed = 0;
  EgoMap map;
  std::vector<FramePose> frames;
  std::optional<Pose> camera_from_world;  // of the last frame
  std::optional<Eigen::Vector3d> up;      // in the map's world, the first camera
  int frames_seen = 0;

  std::optional<RigidMotion> locate(const EgoMap& by, const std::vector<Feature>& features,
                                    const std::optional<Pose>& prior, std::int64_t frame) const;
  bool wants_keyframe(const std::vector<Feature>& features, std::int64_t frame) const;
  void insert_keyframe(std::int64_t frame, const std::vector<Feature>& features);
  void look_for_floor(const cv::Mat& depth, const cv::Mat& masks, std::int64_t frame);
  Pose world_from_map() const { return upright_world_from_camera(up.value_or(-Eigen::Vector3d::UnitY())); }
};

std::optional<RigidMotion> RgbdOdometry::State::locate(const EgoMap& by, const std::vector<Feature>& features,
                                                       const std::optional<Pose>& prior,
                                                       std::int64_t frame) const {
  RandomStream random(seed, "ego", frame);
  return fit_rigid_motion(sightings_of(by, features), camera, prior, options.pose, random);
}

bool RgbdOdometry::State::wants_keyframe(const std::vector<Feature>& features, std::int64_t frame) const {
  const Keyframe& last = map.keyframes.back();
  if (frame - last.frame >= options.keyframe_max_gap) return true;
  const auto seen = std::ssize(sightings_of(map, features));
  if (static_cast<double>(seen) < options.keyframe_min_share * static_cast<double>(features.size()))
    return true;
  const Pose moved = *camera_from_world * last.camera_from_world.inverse();
  return log_so3(moved.rotation).norm() > options.keyframe_turn_rad ||
         moved.translation.norm() > options.keyframe_shift * median_depth(features);
}

void RgbdOdometry::State::insert_keyframe(std::int64_t frame, const std::vector<Feature>& features) {
  RandomStream random(seed, "ego_loop", frame);
  const auto loop = map.keyframes.empty()
                        ? std::nullopt
                        : find_loop(map, camera, features, *camera_from_world, options.loop, random);
  add_keyframe(map, camera, {frame, *camera_from_world, features});
  const int count = static_cast<int>(map.keyframes.size());
  if (loop) close_loop(map, *loop, options.loop);
  std::vector<int> moving(loop ? count : std::min(count, options.window_keyframes));
  std::iota(moving.begin(), moving.end(), count - static_cast<int>(moving.size()));
  adjust_bundle(map, camera, moving, options.bundle);
  camera_from_world = map.keyframes.back().camera_from_world;
}

void RgbdOdometry::State::look_for_floor(const cv::Mat& depth, const cv::Mat& masks, std::int64_t frame) {
  if (up || frames_seen > kUprightTries || !camera_from_world) return;
  RandomStream random(seed, "ego_floor", frame);
  if (const auto found = find_up(depth, masks, camera, options.upright, random))
    up = camera_from_world->rotation.conjugate() * *found;
}

RgbdOdometry::RgbdOdometry(const Camera& camera, const EgoOptions& options, std::uint64_t seed)
    : state_(std::make_unique<State>()) {
  state_->camera = without_distortion(camera);
  state_->options = options;
  state_->seed = seed;
}

RgbdOdometry::~RgbdOdometry() = default;

void RgbdOdometry::track(const SequenceFrame& frame, const TrackedFeatures& features, const cv::Mat& depth,
                         const cv::Mat& masks) {
  State& s = *state_;
  ++s.frames_seen;
  const auto& seen = features.background;
  if (s.map.keyframes.empty()) {
    const auto with_depth =
        std::count_if(seen.begin(), seen.end(), [](const Feature& f) { return f.depth_m > 0; });
    if (with_depth < s.options.pose.min_inliers) return;
    s.camera_from_world = Pose{};
    s.insert_keyframe(frame.frame, seen);
  } else {
    std::optional<Pose> prior = s.camera_from_world;
    if (prior && features.background_motion) prior = *features.background_motion * *prior;
    const auto fit = s.locate(s.map, seen, prior, frame.frame);
    s.camera_from_world.reset();
    if (!fit) return;
    s.camera_from_world = fit->camera_from_body;
    if (s.wants_keyframe(seen, frame.frame)) s.insert_keyframe(frame.frame, seen);
  }
  const Pose camera_from_keyframe = *s.camera_from_world * s.map.keyframes.back().camera_from_world.inverse();
  s.frames.push_back(
      {frame.frame, frame.stamp_ns, int(s.map.keyframes.size()) - 1, camera_from_keyframe, seen});
  s.look_for_floor(depth, masks, frame.frame);
}

std::optional<Pose> RgbdOdometry::pose() const {
  if (!state_->camera_from_world) return std::nullopt;
  return state_->world_from_map() * state_->camera_from_world->inverse();
}

Trajectory RgbdOdometry::trajectory() const {
  const State& s = *state_;
  EgoMap map = s.map;
  if (s.options.final_adjustment) {
    std::vector<int> all(map.keyframes.size());
    std::iota(all.begin(), all.end(), 0);
    BundleOptions bundle = s.options.bundle;
    bundle.iterations = s.options.final_iterations;
    adjust_bundle(map, s.camera, all, bundle);
  }
  Trajectory trajectory;
  for (const FramePose& frame : s.frames) {
    const Pose expected = frame.camera_from_keyframe * map.keyframes[frame.keyframe].camera_from_world;
    const bool is_keyframe = map.keyframes[frame.keyframe].frame == frame.frame;
    const auto fit = is_keyframe ? std::nullopt : s.locate(map, frame.features, expected, frame.frame);
    Pose pose = s.world_from_map() * (fit ? fit->camera_from_body : expected).inverse();
    pose.rotation.normalize();
    trajectory.push_back({frame.stamp_ns, pose});
  }
  return trajectory;
}

}  // namespace uniquadric
