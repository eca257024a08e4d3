#include "estimator/perception/features.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "estimator/perception/corners.h"
#include "estimator/perception/tracked_body.h"

namespace uniquadric {
namespace {

constexpr int kLandmarkSightings = 12;  // after which its own noise is below that of a new sighting

Camera without_distortion(Camera camera) {
  camera.distortion = {};
  return camera;
}

cv::Mat gray_of(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat gray;
  cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

Feature feature_of(const PointTrack& track) {
  Feature feature;
  feature.track = track.id;
  feature.pixel = track.undistorted;
  if (track.depth) {
    feature.depth_m = track.depth->depth_m;
    feature.depth_sigma_m = track.depth->sigma_m;
  }
  return feature;
}

}  // namespace

struct FeatureTracker::State {
  Camera lens, camera;  // as it is, without distortion
  FeatureOptions options;
  std::uint64_t seed = 0;
  FlowImage last_image;
  std::int64_t last_stamp_ns = 0;
  std::int64_t next_id = 0;
  std::map<int, TrackedBody> bodies;

  // The present frame.
  std::int64_t frame = 0, step_ns = 0;
  cv::Mat depth;
  Regions regions;
  const BodyEnvelope* envelope = nullptr;

  bool belongs(int label, const PointTrack& track) const {
    if (label == 0 || !*envelope || !track.depth) return true;
    return (*envelope)(label, seen_point(camera, track, options.motion.pixel_sigma).point);
  }

  bool place(PointTrack& track, const Eigen::Vector2d& pixel) const {
    const auto ray = lens.unproject(pixel);
    if (!ray) return false;
    track.pixel = pixel;
    track.undistorted = Eigen::Vector2d(camera.fx * ray->x() + camera.cx, camera.fy * ray->y() + camera.cy);
    track.depth = fit_plane_depth(depth, regions.labels, pixel, options.depth);
    return true;
  }

  void follow_all(const FlowImage& image);
  void move_body(TrackedBody& body);
  void update_landmarks(TrackedBody& body) const;
  void find_corners(const cv::Mat& gray);
  TrackedFeatures result(std::map<int, bool> moved) const;
};

// Moves all tracks to their places in the new image; those not found are dropped.
void FeatureTracker::State::follow_all(const FlowImage& image) {
  std::vector<Eigen::Vector2d> points, seeds;
  for (const auto& [label, body] : bodies) {
    const auto pose = step_ns <= std::int64_t(options.max_prediction_gap_s * 1e9)
                          ? predicted_pose(body, step_ns)
                          : std::nullopt;
    for (const auto& track : body.tracks) {
      points.push_back(track.pixel);
      seeds.push_back(track.pixel);
      if (!pose || !track.landmark) continue;
      const auto pixel = lens.project(*pose * track.landmark->point);
      if (pixel && lens.contains(*pixel)) seeds.back() = *pixel;
    }
  }
  const auto found = follow_points(last_image, image, points, seeds, options.flow);
  std::size_t i = 0;
  for (auto& [label, body] : bodies) {
    std::vector<PointTrack> kept;
    for (auto& track : body.tracks) {
      const auto& pixel = found[i++];
      if (!pixel || !place(track, *pixel)) continue;
      const bool on_mask = regions.label(*pixel) == label && regions.margin(*pixel) >= options.keep_margin_px;
      track.missed = on_mask ? 0 : track.missed + 1;
      if (track.missed <= options.max_missed && belongs(label, track)) kept.push_back(std::move(track));
    }
    body.tracks = std::move(kept);
  }
}

// The body's pose from its tracks; tracks that move otherwise are dropped. Without a consensus the map is
// given up, and the tracks too when there were enough of them to agree.
void FeatureTracker::State::move_body(TrackedBody& body) {
  std::vector<PointSighting> sightings;
  std::vector<std::size_t> places;
  const auto before = body.camera_from_map;
  for (std::size_t i = 0; i < body.tracks.size() && before; ++i) {
    const PointTrack& track = body.tracks[i];
    if (!track.landmark) continue;
    PointSighting s{track.landmark->point, track.undistorted};
    if (track.depth) {
      const Eigen::Vector3d ray = before->rotation.conjugate() * Eigen::Vector3d::UnitZ();
      const double own = ray.dot(track.landmark->information.inverse() * ray);
      s.depth_m = track.depth->depth_m;
      s.depth_sigma_m = std::sqrt(track.depth->sigma_m * track.depth->sigma_m + own);
    }
    sightings.push_back(s);
    places.push_back(i);
  }
  RandomStream random(seed, "rigid_motion", frame, body.label);
  const auto fit = fit_rigid_motion(sightings, camera, predicted_pose(body, step_ns), options.motion, random);
  body.motion.reset();
  if (!fit) {
    body.camera_from_map.reset();
    if (std::ssize(sightings) >= 2 * options.motion.min_inliers) body.tracks.clear();
    for (auto& track : body.tracks) track.landmark.reset();
    return;
  }
  body.camera_from_map = fit->camera_from_body;
  body.motion = fit->camera_from_body * before->inverse();
  body.motion->rotation.normalize();
  body.motion_ns = step_ns;
  std::vector<bool> outlier(body.tracks.size(), false);
  for (std::size_t i = 0; i < places.size(); ++i) outlier[places[i]] = !fit->inlier[i];
  std::size_t i = 0;
  std::erase_if(body.tracks, [&](const PointTrack&) { return outlier[i++]; });
}

void FeatureTracker::State::update_landmarks(TrackedBody& body) const {
  if (body.tracks.empty()) body.camera_from_map.reset();
  if (!body.tracks.empty() && !body.camera_from_map) body.camera_from_map = Pose{};
  for (auto& track : body.tracks)
    if (track.depth && track.missed == 0)
      add_sighting(track.landmark, seen_point(camera, track, options.motion.pixel_sigma),
                   *body.camera_from_map, kLandmarkSightings);
}

// New tracks on bodies that have too few.
void FeatureTracker::State::find_corners(const cv::Mat& gray) {
  std::map<int, double> area;
  for (int v = 0; v < gray.rows; ++v)
    for (int u = 0; u < gray.cols; ++u) ++area[regions.labels.at<std::uint16_t>(v, u)];
  Spacing spacing(gray.size());
  std::map<int, int> wanted;
  std::map<int, double> distance;
  for (const auto& [label, pixels] : area) {
    wanted[label] = label == 0 ? options.background_features : options.body_features;
    distance[label] = std::max(options.min_distance_px, 0.6 * std::sqrt(pixels / wanted[label]));
    for (const auto& track : bodies[label].tracks) spacing.take(track.pixel, distance[label]);
    wanted[label] -= static_cast<int>(bodies[label].tracks.size());
    bodies[label].label = label;
  }
  for (const auto& corner : fast_corners(gray, options.fast_threshold)) {
    const int label = regions.label(corner.pixel);
    if (wanted[label] <= 0 || regions.margin(corner.pixel) < options.start_margin_px ||
        !spacing.is_free(corner.pixel))
      continue;
    PointTrack track;
    if (!place(track, corner.pixel) || (!depth.empty() && !track.depth) || !belongs(label, track)) continue;
    track.id = next_id++;
    bodies[label].tracks.push_back(track);
    spacing.take(corner.pixel, distance[label]);
    --wanted[label];
  }
}

TrackedFeatures FeatureTracker::State::result(std::map<int, bool> moved) const {
  TrackedFeatures result;
  for (const auto& [label, body] : bodies) {
    std::vector<Feature> features;
    for (const auto& track : body.tracks)
      if (track.missed == 0) features.push_back(feature_of(track));
    if (label == 0) {
      result.background = std::move(features);
      if (moved[label]) result.background_motion = body.motion;
      continue;
    }
    if (!features.empty()) result.bodies.emplace(label, std::move(features));
    if (moved[label]) result.motions.emplace(label, *body.motion);
  }
  return result;
}

FeatureTracker::FeatureTracker(const Camera& camera, const FeatureOptions& options, std::uint64_t seed)
    : state_(std::make_unique<State>()) {
  state_->lens = camera;
  state_->camera = without_distortion(camera);
  state_->options = options;
  state_->seed = seed;
}

FeatureTracker::~FeatureTracker() = default;

TrackedFeatures FeatureTracker::track(const SequenceFrame& frame, const cv::Mat& image, const cv::Mat& depth,
                                      const cv::Mat& masks, const BodyEnvelope& envelope) {
  State& s = *state_;
  const cv::Mat gray = gray_of(image);
  s.frame = frame.frame;
  s.step_ns = frame.stamp_ns - s.last_stamp_ns;
  s.depth = depth;
  s.regions = make_regions(masks, gray.size());
  s.envelope = &envelope;
  FlowImage flow_image = make_flow_image(gray, s.options.flow);
  std::map<int, bool> moved;
  if (!s.last_image.pyramid.empty()) s.follow_all(flow_image);
  for (auto& [label, body] : s.bodies) {
    s.move_body(body);
    moved[label] = body.motion.has_value();
  }
  s.find_corners(gray);
  for (auto& [label, body] : s.bodies) s.update_landmarks(body);
  s.last_image = std::move(flow_image);
  s.last_stamp_ns = frame.stamp_ns;
  return s.result(std::move(moved));
}

}  // namespace uniquadric
