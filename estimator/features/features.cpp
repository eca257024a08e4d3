#include "estimator/features/features.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "estimator/features/depth_scale_watch.h"
#include "estimator/features/frame_view.h"
#include "estimator/images/noise_correlation.h"

namespace uniquadric {
namespace {

constexpr int kLandmarkSightings = 12;  // after which its own noise is below that of a new sighting
constexpr int kNoiseFrames = 5;    // share a measurement of the noise: how a sensor errs does not change soon
constexpr double kCrowding = 0.6;  // distance between features, of that in an even lattice

cv::Mat gray_of(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat gray;
  cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

Feature feature_of(const FrameView& view, const PointTrack& track) {
  Feature feature;
  feature.track = track.id;
  feature.pixel = track.undistorted;
  feature.rim = !view.regions.contains_patch(track.at_stamp);
  if (track.depth) {
    feature.depth_m = track.depth->depth_m;
    feature.depth_sigma_m = track.depth->sigma_m;
  }
  return feature;
}

// How many features each label still wants and how far apart they should be.
struct Demand {
  int wanted = 0;
  double distance_px = 0;
};

std::map<int, Demand> demands(const FrameView& view) {
  std::map<int, Demand> result;
  std::map<int, int> area;
  for (int v = 0; v < view.regions.labels.rows; ++v) {
    const std::uint16_t* row = view.regions.labels.ptr<std::uint16_t>(v);
    for (int u = 0, begin = 0; u < view.regions.labels.cols; begin = u) {
      while (u < view.regions.labels.cols && row[u] == row[begin]) ++u;
      area[row[begin]] += u - begin;
    }
  }
  for (const auto& [label, pixels] : area) {
    const int wanted = label == 0 ? view.options.background_features : view.options.body_features;
    result[label] = {wanted, std::max(view.options.min_distance_px,
                                      kCrowding * std::sqrt(double(pixels) / std::max(wanted, 1)))};
  }
  return result;
}

// Draws the descriptors of new corners.
void describe(const FrameView& view, std::vector<PointTrack>& corners) {
  std::vector<SurfacePoint> points;
  for (const auto& corner : corners) points.push_back({corner.pixel, *corner.depth});
  auto descriptors = describe_surfaces(view.gray, view.lens, points);
  for (std::size_t i = 0; i < corners.size(); ++i) corners[i].descriptors = std::move(descriptors[i]);
}

}  // namespace

struct FeatureTracker::State {
  State(const Camera& with_lens, double rolling_shutter_s)
      : lens(with_lens), camera(without_distortion(with_lens)), shutter(with_lens, rolling_shutter_s) {}

  Camera lens, camera;  // as it is, without distortion
  RollingShutter shutter;
  FeatureOptions options;
  std::uint64_t seed = 0;
  FlowImage last_image;
  std::int64_t last_stamp_ns = 0;
  std::int64_t next_id = 0;
  std::map<int, TrackedBody> bodies;
  DepthScaleWatch depth_scale;
  SurfaceNoise noise;
  int frames_until_noise = 0;  // is measured again

  void measure_noise(const cv::Mat& depth);
  void follow_all(const FrameView& view, const FlowImage& image);
  void presume_twists();
  void find_corners(const FrameView& view);
  void ignore_depth(FrameView& view);
  void begin_anew(FrameView& view, const cv::Mat& depth);
  void update_landmarks(const FrameView& view, TrackedBody& body) const;
  TrackedFeatures result(const FrameView& view) const;
};

// An image may tell nothing: then the next one is asked.
void FeatureTracker::State::measure_noise(const cv::Mat& depth) {
  if (frames_until_noise-- > 0) return;
  noise = surface_noise(depth, options.depth);
  frames_until_noise = noise.wide.residual < 1 ? kNoiseFrames - 1 : 0;
}

// Moves all tracks to their places in the new image; those not found are lost.
void FeatureTracker::State::follow_all(const FrameView& view, const FlowImage& image) {
  std::vector<Eigen::Vector2d> points, seeds;
  for (const auto& [label, body] : bodies) {
    const auto pose = expected_pose(view, body);
    for (const auto& track : body.tracks) {
      points.push_back(track.pixel);
      seeds.push_back(track.pixel);
      if (!pose || !track.landmark) continue;
      const auto pixel = shutter.seen_at(*pose * track.landmark->point, body.twist);
      if (pixel && lens.contains(*pixel)) seeds.back() = *pixel;
    }
  }
  const auto found = follow_points(last_image, image, points, seeds, options.flow);
  std::size_t i = 0;
  for (auto& [label, body] : bodies) {
    std::vector<PointTrack> kept;
    for (auto& track : body.tracks) {
      const auto& pixel = found[i++];
      const bool placed = pixel && view.place_roughly(track, *pixel, body);
      const bool on_mask =
          placed && view.regions.label(track.at_stamp) == label && view.regions.is_inside(track.at_stamp);
      track.missed = on_mask ? 0 : track.missed + 1;
      if (placed && track.missed <= options.max_missed && view.belongs(label, track))
        kept.push_back(std::move(track));
      else
        retire(body, std::move(track), options.gallery.min_sightings, view.most_tracks(label));
    }
    body.tracks = std::move(kept);
  }
}

void FeatureTracker::State::ignore_depth(FrameView& view) {
  view.depth = cv::Mat(view.depth.size(), view.depth.type(), cv::Scalar(0));  // another: the caller keeps his
  for (auto& [label, body] : bodies)
    for (auto& track : body.tracks) track.depth.reset();
}

// With depth of another scale than all that was mapped before. How bodies moved is known by their pixels.
void FeatureTracker::State::begin_anew(FrameView& view, const cv::Mat& depth) {
  for (auto& [label, body] : bodies) {
    TrackedBody anew;
    anew.label = label;
    anew.motion = body.motion;
    anew.motion_ns = body.motion_ns;
    anew.twist = body.twist;
    body = std::move(anew);
  }
  view.depth = depth;
}

// What is not known to move is presumed to be at rest in the world.
void FeatureTracker::State::presume_twists() {
  const Vector6d at_rest = bodies[0].twist;
  for (auto& [label, body] : bodies)
    if (!body.twist_known) body.twist = at_rest;
}

// Fills bodies up: lost tracks that should be seen, then new corners, of which some may be recognised.
void FeatureTracker::State::find_corners(const FrameView& view) {
  auto wanted = demands(view);
  Spacing spacing(view.gray.size());
  for (auto& [label, demand] : wanted) {
    TrackedBody& body = bodies[label];
    body.label = label;
    return_where_left(view, body, demand.distance_px, demand.wanted);
    for (const auto& track : body.tracks) spacing.take(track.pixel, demand.distance_px);
    demand.wanted -= static_cast<int>(body.tracks.size());
    const auto before = body.tracks.size();
    return_expected_tracks(view, body, spacing, demand.distance_px, demand.wanted);
    demand.wanted -= static_cast<int>(body.tracks.size() - before);
  }
  presume_twists();
  std::map<int, std::vector<PointTrack>> corners;
  for (const auto& corner : fast_corners(view.gray, options.fast_threshold)) {
    const int label = view.regions.label(corner.pixel);
    Demand& demand = wanted[label];
    if (demand.wanted <= 0 || !spacing.is_free(corner.pixel) || !view.regions.is_well_inside(corner.pixel))
      continue;
    PointTrack track;
    if (!view.place(track, corner.pixel, bodies[label]) || (!view.depth.empty() && !track.depth) ||
        view.regions.label(track.at_stamp) != label || !view.regions.is_well_inside(track.at_stamp) ||
        !view.belongs(label, track))
      continue;
    corners[label].push_back(track);
    spacing.take(corner.pixel, demand.distance_px);
    --demand.wanted;
  }
  for (auto& [label, found] : corners) {
    TrackedBody& body = bodies[label];
    if (!view.depth.empty()) describe(view, found);
    recognise_body(view, body, found);
    for (auto& track : found) {
      track.id = next_id++;
      body.tracks.push_back(std::move(track));
    }
  }
}

void FeatureTracker::State::update_landmarks(const FrameView& view, TrackedBody& body) const {
  if (body.tracks.empty()) body.camera_from_map.reset();
  if (!body.tracks.empty() && !body.camera_from_map) {
    body.camera_from_map = Pose{};
    body.map = body.maps++;
  }
  for (auto& track : body.tracks) {
    if (!track.depth || track.missed > 0) continue;
    track.map = body.map;
    add_sighting(track, camera, *body.camera_from_map, options.motion.pixel_sigma, kLandmarkSightings);
    if (!track.anchor) track.anchor = make_anchor(view.gray, track.pixel, *body.camera_from_map);
  }
}

TrackedFeatures FeatureTracker::State::result(const FrameView& view) const {
  TrackedFeatures result;
  for (const auto& [label, body] : bodies) {
    std::vector<Feature> features;
    for (const auto& track : body.tracks)
      if (track.missed == 0) features.push_back(feature_of(view, track));
    if (label == 0) {
      result.background = std::move(features);
      result.background_motion = body.motion;
      result.background_at_rows = view.shutter.is_on() && !body.twist_known;
      continue;
    }
    if (!features.empty()) result.bodies.emplace(label, std::move(features));
    if (body.motion) result.motions.emplace(label, *body.motion);
  }
  return result;
}

FeatureTracker::FeatureTracker(const Camera& camera, const FeatureOptions& options, std::uint64_t seed,
                               double rolling_shutter_s)
    : state_(std::make_unique<State>(camera, options.rolling_shutter.enabled ? rolling_shutter_s : 0)) {
  state_->options = options;
  state_->seed = seed;
}

FeatureTracker::~FeatureTracker() = default;

TrackedFeatures FeatureTracker::track(const SequenceFrame& frame, const cv::Mat& image, const cv::Mat& depth,
                                      const cv::Mat& masks, const BodyHints& hints) {
  State& s = *state_;
  FrameView view{s.lens, s.camera, s.shutter, s.options, hints, gray_of(image), depth, {}};
  view.regions = make_regions(masks, view.gray.size(), s.options.keep_margin_px, s.options.start_margin_px,
                              s.options.flow.window_px / 2);
  view.frame = frame.frame;
  view.step_ns = frame.stamp_ns - s.last_stamp_ns;
  view.seed = s.seed;
  if (s.options.depth.correlated_noise) s.measure_noise(depth);
  view.noise = s.noise;
  FlowImage flow_image = make_flow_image(view.gray, s.options.flow);
  if (!s.last_image.pyramid.empty()) s.follow_all(view, flow_image);
  if (const auto expected = expected_pose(view, s.bodies[0])) follow_twist(view, s.bodies[0], *expected);
  const auto scale = s.depth_scale.judge(view, s.bodies[0], frame.stamp_ns);
  if (scale != DepthScaleWatch::Verdict::believed) s.ignore_depth(view);
  std::map<int, std::pair<std::optional<Pose>, int>> before;
  for (auto& [label, body] : s.bodies) {
    before[label] = {body.camera_from_map, body.map};
    move_body(view, body);
  }
  if (scale == DepthScaleWatch::Verdict::changed) s.begin_anew(view, depth);
  s.find_corners(view);
  for (auto& [label, body] : s.bodies) {
    const auto& [pose, map] = before[label];
    if (pose && !body.motion && body.camera_from_map && body.map == map) set_motion(view, body, *pose);
    s.update_landmarks(view, body);
  }
  s.last_image = std::move(flow_image);
  s.last_stamp_ns = frame.stamp_ns;
  TrackedFeatures result = s.result(view);
  result.depth_refused = scale == DepthScaleWatch::Verdict::refused;
  result.depth_changed = scale == DepthScaleWatch::Verdict::changed;
  return result;
}

}  // namespace uniquadric
