#include "estimator/features/depth_scale_watch.h"

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "estimator/images/rigid_motion.h"

namespace uniquadric {
namespace {

constexpr double kUnweighted_m = 1e6;  // sigma of a depth that decides nothing
constexpr int kLeastPoints = 30;       // to tell a scale by

// Median of measured to predicted depth over the points that agree in the image.
std::optional<double> measured_scale(const FrameView& view, const TrackedBody& background) {
  const auto prior = expected_pose(view, background);
  if (!prior) return std::nullopt;
  std::vector<PointSighting> sightings;
  for (const PointTrack& track : background.tracks)
    if (track.landmark && track.depth)
      sightings.push_back({track.landmark->point, track.undistorted, track.depth->depth_m, kUnweighted_m});
  RandomStream random(view.seed, "depth_scale", view.frame);
  const auto fit = fit_rigid_motion(sightings, view.camera, prior, view.options.motion, random);
  if (!fit || fit->inliers < kLeastPoints) return std::nullopt;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < sightings.size(); ++i)
    if (fit->inlier[i])
      ratios.push_back(sightings[i].depth_m / (fit->camera_from_body * sightings[i].point).z());
  return upper_median(std::move(ratios));
}

}  // namespace

DepthScaleWatch::Verdict DepthScaleWatch::judge(const FrameView& view, const TrackedBody& background,
                                                std::int64_t stamp_ns) {
  if (background.map != map_) scale_ = 1;
  map_ = background.map;
  const auto scale = measured_scale(view, background);
  if (!scale) return Verdict::believed;
  if (std::abs(*scale / scale_ - 1) > view.options.max_scale_change) {
    if (refused_++ == 0) refused_since_ns_ = stamp_ns;
    if (refused_ <= believed_ && seconds(refused_since_ns_, stamp_ns) < view.options.max_scale_refused_s)
      return Verdict::refused;
    const int agreed = refused_;
    *this = {};
    believed_ = agreed;
    return Verdict::changed;
  }
  refused_ = 0;
  ++believed_;
  scale_ = *scale;
  return Verdict::believed;
}

}  // namespace uniquadric
