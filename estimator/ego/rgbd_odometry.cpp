#include "estimator/ego/rgbd_odometry.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <vector>

#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "estimator/ego/ego_map.h"
#include "estimator/ego/map_locator.h"

namespace uniquadric {
namespace {

constexpr int kUprightTries = 10;  // frames in which the floor is looked for

double median_depth(const std::vector<Feature>& features) {
  std::vector<double> depths;
  for (const Feature& feature : features)
    if (feature.depth_m > 0) depths.push_back(feature.depth_m);
  if (depths.empty()) return 1;
  return upper_median(std::move(depths));
}

// A map and the frames it placed. `before`: those that came earlier and had no place in the map of then.
struct Stretch {
  EgoMap map;
  std::vector<FramePose> frames, before;
};

std::int64_t count_with_depth(const std::vector<Feature>& features) {
  return std::count_if(features.begin(), features.end(), [](const Feature& f) { return f.depth_m > 0; });
}

}  // namespace

struct RgbdOdometry::State {
  MapLocator locator;
  EgoOptions options;
  std::vector<Stretch> given_up;
  EgoMap map;
  std::vector<FramePose> frames, before;  // of the map, as in Stretch
  std::size_t settled = 0;                // of the frames, whose features are gone
  std::int64_t placed = 0;                // of the frames, by the map
  std::int64_t placed_ns = 0;             // the last of them
  std::vector<FramePose> lost;            // since then, the bridged ones too
  std::set<std::int64_t> last_tracks;     // of the background, in the last frame
  std::int64_t followed = 0;              // of these, with depth in the present frame
  std::optional<Pose> camera_from_world;  // of the last frame
  Pose presumed;                          // the same, where it is not known: the last known, moved on
  std::optional<Eigen::Vector3d> up;      // in the map's world, the first camera
  double fixed_lag_s = 1;
  Trajectory causal, lagged;      // map_from_camera, as known at each frame and a fixed lag after it
  std::size_t lagged_frames = 0;  // of the frames: those in `lagged`
  int frames_seen = 0;
  bool depth_changed = false;  // and no map has begun since

  bool wants_keyframe(const std::vector<Feature>& features, std::int64_t frame) const;
  void insert_keyframe(std::int64_t frame, const std::vector<Feature>& features);
  void settle_frames();
  void begin_map(const Pose& pose, std::int64_t frame, const std::vector<Feature>& features);
  void await_motion(const SequenceFrame& frame, const std::vector<Feature>& features);
  void begin_with(const SequenceFrame& frame, const TrackedFeatures& features);
  void count_followed(const std::vector<Feature>& features);
  bool follow(std::int64_t frame, const TrackedFeatures& features);
  bool can_bridge(const TrackedFeatures& features) const;
  bool is_young() const { return given_up.empty() && placed < options.young_frames; }
  bool is_hopeless(std::int64_t stamp_ns) const;
  void look_back(std::int64_t until_ns);
  Trajectory in_world(const Trajectory& map_from_camera) const;
  void begin_anew(std::int64_t frame, const std::vector<Feature>& features);
  void add_frame(const SequenceFrame& frame, const TrackedFeatures& features, bool is_bridged);
  void append(const EgoMap& of, const std::vector<FramePose>& placed, const std::vector<FramePose>& earlier,
              Trajectory& trajectory) const;
  void look_for_floor(const cv::Mat& depth, const cv::Mat& masks, std::int64_t frame);
  Pose world_from_map() const { return upright_world_from_camera(up.value_or(-Eigen::Vector3d::UnitY())); }
};

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
  RandomStream random(locator.seed, "ego_loop", frame);
  const auto loop = map.keyframes.empty()
                        ? std::nullopt
                        : find_loop(map, locator.camera, features, *camera_from_world, options.loop, random);
  add_keyframe(map, locator.camera, {frame, *camera_from_world, features});
  const int count = static_cast<int>(map.keyframes.size());
  if (loop) close_loop(map, *loop, options.loop);
  std::vector<int> moving(loop ? count : std::min(count, options.window_keyframes));
  std::iota(moving.begin(), moving.end(), count - static_cast<int>(moving.size()));
  adjust_bundle(map, locator.camera, moving, options.bundle);
  camera_from_world = map.keyframes.back().camera_from_world;
}

// Frames whose keyframe has left the local bundle adjustment are fixed to it: from here on the map about them
// moves as a whole, and memory does not grow with their features.
void RgbdOdometry::State::settle_frames() {
  if (is_young()) return;  // they may have to be looked for in another map
  const int first_moving = static_cast<int>(map.keyframes.size()) - options.window_keyframes;
  for (; settled < frames.size() && frames[settled].keyframe < first_moving; ++settled) {
    FramePose& frame = frames[settled];
    frame.camera_from_keyframe =
        locator.found_again(map, frame) * map.keyframes[frame.keyframe].camera_from_world.inverse();
    frame.features = std::vector<Feature>();
  }
}

void RgbdOdometry::State::look_for_floor(const cv::Mat& depth, const cv::Mat& masks, std::int64_t frame) {
  if (up || frames_seen > kUprightTries || !camera_from_world) return;
  RandomStream random(locator.seed, "ego_floor", frame);
  if (const auto found = find_up(depth, masks, locator.camera, options.upright, random))
    up = camera_from_world->rotation.conjugate() * *found;
}

void RgbdOdometry::State::begin_map(const Pose& pose, std::int64_t frame,
                                    const std::vector<Feature>& features) {
  camera_from_world = pose;
  depth_changed = false;
  insert_keyframe(frame, features);
}

// A rolling shutter's frame before the first motion: its place is the world's origin, the map begins later.
void RgbdOdometry::State::await_motion(const SequenceFrame& frame, const std::vector<Feature>& features) {
  presumed = {};
  camera_from_world = presumed;
  before.push_back({frame.frame, frame.stamp_ns, 0, {}, features});
  causal = lagged = {{frame.stamp_ns, presumed}};
}

// The first motion tells about how the camera moved in the frame before.
void RgbdOdometry::State::begin_with(const SequenceFrame& frame, const TrackedFeatures& features) {
  if (!before.empty() && features.background_motion)
    before.back().presumed_twist =
        log_se3(*features.background_motion) / seconds(before.back().stamp_ns, frame.stamp_ns);
  begin_map(before.empty() ? Pose{} : presumed, frame.frame, features.background);
}

void RgbdOdometry::State::count_followed(const std::vector<Feature>& features) {
  followed = std::count_if(features.begin(), features.end(),
                           [&](const Feature& f) { return f.depth_m > 0 && last_tracks.contains(f.track); });
  last_tracks.clear();
  for (const Feature& f : features) last_tracks.insert(f.track);
}

// Whether the background's motion tells the pose, where that of the frame before is known.
bool RgbdOdometry::State::can_bridge(const TrackedFeatures& features) const {
  return features.background_motion && options.bridge_features > 0 && followed >= options.bridge_features;
}

// Places the camera in the map; false where it is lost.
bool RgbdOdometry::State::follow(std::int64_t frame, const TrackedFeatures& features) {
  const auto prior = camera_from_world ? std::optional(presumed) : std::nullopt;
  const auto fit = locator.locate(map, features.background, prior, frame);
  camera_from_world.reset();
  if (!fit) return false;
  camera_from_world = fit->camera_from_body;
  if (wants_keyframe(features.background, frame)) {
    insert_keyframe(frame, features.background);
    settle_frames();
  }
  return true;
}

// Whether it is time to give the map up, which the frames in `lost` do not fit. Where nothing is followed
// from frame to frame a new map would be lost as soon as it was made.
bool RgbdOdometry::State::is_hopeless(std::int64_t stamp_ns) const {
  if (is_young())
    return std::ssize(lost) >= options.young_lost_frames && followed >= options.pose.min_inliers;
  return seconds(placed_ns, stamp_ns) >= options.restart_after_s && followed >= options.restart_features;
}

// Notes the poses of frames up to a stamp as they are known now.
void RgbdOdometry::State::look_back(std::int64_t until_ns) {
  for (; lagged_frames < frames.size() && frames[lagged_frames].stamp_ns <= until_ns; ++lagged_frames) {
    const FramePose& frame = frames[lagged_frames];
    lagged.push_back({frame.stamp_ns, locator.found_again(map, frame).inverse()});
  }
}

Trajectory RgbdOdometry::State::in_world(const Trajectory& map_from_camera) const {
  Trajectory trajectory;
  for (const auto& [stamp_ns, pose] : map_from_camera) {
    trajectory.push_back({stamp_ns, world_from_map() * pose});
    trajectory.back().pose.rotation.normalize();
  }
  return trajectory;
}

// A young map is no loss: its frames are looked for in the new one, as are those that were lost or bridged.
void RgbdOdometry::State::begin_anew(std::int64_t frame, const std::vector<Feature>& features) {
  look_back(frames.back().stamp_ns);
  while (frames.back().is_bridged) frames.pop_back();
  if (is_young()) {
    before.insert(before.end(), frames.begin(), frames.end());
    causal.clear();
    lagged.clear();
    presumed = {};
    up.reset();
    frames_seen = 1;
  } else {
    given_up.push_back({std::move(map), std::move(frames), std::move(before)});
    before.clear();
  }
  before.insert(before.end(), lost.begin(), lost.end());
  map = {};
  frames.clear();
  settled = lagged_frames = 0;
  placed = 0;
  begin_map(presumed, frame, features);
}

// A frame whose pose has just become known.
void RgbdOdometry::State::add_frame(const SequenceFrame& frame, const TrackedFeatures& features,
                                    bool is_bridged) {
  if (!is_bridged) {
    lost.clear();
    ++placed;
    placed_ns = frame.stamp_ns;
  }
  presumed = *camera_from_world;
  const Pose camera_from_keyframe = *camera_from_world * map.keyframes.back().camera_from_world.inverse();
  frames.push_back({frame.frame,
                    frame.stamp_ns,
                    int(map.keyframes.size()) - 1,
                    camera_from_keyframe,
                    features.background,
                    features.background_motion,
                    {},
                    is_bridged});
  causal.push_back({frame.stamp_ns, camera_from_world->inverse()});
  look_back(frame.stamp_ns - nanoseconds(fixed_lag_s));
}

RgbdOdometry::RgbdOdometry(const Camera& camera, const EgoOptions& options, std::uint64_t seed,
                           double fixed_lag_s, double rolling_shutter_s)
    : state_(std::make_unique<State>()) {
  state_->locator = {without_distortion(camera), options.pose, seed, rolling_shutter_s};
  state_->options = options;
  state_->fixed_lag_s = fixed_lag_s;
}

RgbdOdometry::~RgbdOdometry() = default;

void RgbdOdometry::track(const SequenceFrame& frame, const TrackedFeatures& features, const cv::Mat& depth,
                         const cv::Mat& masks) {
  State& s = *state_;
  ++s.frames_seen;
  const auto& seen = features.background;
  const bool can_begin = count_with_depth(seen) >= s.options.pose.min_inliers;
  s.depth_changed = s.depth_changed || features.depth_changed;
  if (features.background_motion) s.presumed = *features.background_motion * s.presumed;
  s.count_followed(seen);
  const bool was_known = s.camera_from_world.has_value();
  bool is_bridged = false;
  if (s.map.keyframes.empty()) {
    if (!can_begin) return;
    if (features.background_at_rows) return s.await_motion(frame, seen);
    s.begin_with(frame, features);
  } else if (s.depth_changed && can_begin) {
    s.begin_anew(frame.frame, seen);
  } else if (!s.follow(frame.frame, features)) {
    s.lost.push_back({frame.frame, frame.stamp_ns, 0, {}, seen, features.background_motion});
    if (s.is_hopeless(frame.stamp_ns)) {
      s.lost.pop_back();
      s.begin_anew(frame.frame, seen);
    } else {
      is_bridged = was_known && s.can_bridge(features);
      if (!is_bridged) return;
      s.lost.back().is_bridged = true;
      s.camera_from_world = s.presumed;
    }
  }
  s.add_frame(frame, features, is_bridged);
  s.look_for_floor(depth, masks, frame.frame);
}

std::optional<Pose> RgbdOdometry::pose() const {
  if (!state_->camera_from_world) return std::nullopt;
  return state_->world_from_map() * state_->camera_from_world->inverse();
}

// Frames that came before the map are placed by it backwards, from neighbour to neighbour.
void RgbdOdometry::State::append(const EgoMap& of, const std::vector<FramePose>& placed,
                                 const std::vector<FramePose>& earlier, Trajectory& trajectory) const {
  EgoMap adjusted = of;
  std::vector<int> all(adjusted.keyframes.size());
  std::iota(all.begin(), all.end(), 0);
  BundleOptions bundle = options.bundle;
  bundle.iterations = options.final_iterations;
  adjust_bundle(adjusted, locator.camera, all, bundle);
  const auto world_from_camera = [&](const FramePose& frame, const Pose& camera_from_map) {
    Pose pose = world_from_map() * camera_from_map.inverse();
    pose.rotation.normalize();
    return StampedPose{frame.stamp_ns, pose};
  };
  Trajectory first;
  Pose next = adjusted.keyframes.front().camera_from_world;
  auto motion = placed.front().motion;
  for (auto frame = earlier.rbegin(); frame != earlier.rend(); ++frame) {
    if (motion) next = motion->inverse() * next;
    motion = frame->motion;
    const auto pose = locator.locate(adjusted, *frame, next);
    if (!pose && !frame->is_bridged) continue;
    if (pose) next = *pose;
    first.push_back(world_from_camera(*frame, next));
  }
  trajectory.insert(trajectory.end(), first.rbegin(), first.rend());
  for (const FramePose& frame : placed)
    trajectory.push_back(world_from_camera(frame, locator.found_again(adjusted, frame)));
}

Trajectory RgbdOdometry::trajectory() const {
  Trajectory trajectory;
  for (const Stretch& s : state_->given_up) state_->append(s.map, s.frames, s.before, trajectory);
  if (!state_->frames.empty()) state_->append(state_->map, state_->frames, state_->before, trajectory);
  return trajectory;
}

Trajectory RgbdOdometry::causal_trajectory() const {
  return state_->in_world(state_->causal);
}

Trajectory RgbdOdometry::lagged_trajectory() {
  State& s = *state_;
  if (!s.frames.empty()) s.look_back(s.frames.back().stamp_ns);
  return s.in_world(s.lagged);
}

const EgoMap& RgbdOdometry::map() const {
  return state_->map;
}

std::int64_t RgbdOdometry::features_kept() const {
  std::int64_t kept = 0;
  for (const FramePose& frame : state_->frames) kept += std::ssize(frame.features);
  return kept;
}

int RgbdOdometry::restarts() const {
  return static_cast<int>(state_->given_up.size());
}

}  // namespace uniquadric
