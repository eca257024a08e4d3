#include "estimator/window/cloud_alignment.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/geometry/box_symmetry.h"
#include "estimator/window/cloud_aligner.h"

namespace uniquadric {
namespace {

constexpr FitEffort kFull{15, 1}, kRough{7, 4};
constexpr std::size_t kRefined = 5;                   // rough fits that are worth a full one
constexpr double kSamePlace = 0.02, kSameTurn = 0.1;  // [m], [rad] of rough fits that end alike
constexpr int kLeastModel = 50;                       // points of a model that a pose is taken from
constexpr double kOtherSide = 0.3;  // share of the points that it must match more, to be the one that is seen

// A motion that an impact changed has sigmas so many times as large. One frame in thirty has one: its cost is
// that of their six-dimensional normal distribution, log(30 * kImpactSigmas^6).
constexpr double kImpactSigmas = 10, kImpactCost = 17;

double cost_with_impacts(double way) {
  return std::min(way, kImpactCost + way / (kImpactSigmas * kImpactSigmas));
}

CloudFit held_fit(const CloudAligner& aligner, const Pose& start, const FitEffort& effort) {
  const CloudFit fit = aligner.fit_from(start, effort);
  return std::isfinite(fit.cost) && aligner.holds_points(fit.pose) ? fit : CloudFit{};
}

bool is_same_place(const Pose& a, const Pose& b) {
  return a.rotation.angularDistance(b.rotation) < kSameTurn &&
         (a.translation - b.translation).norm() < kSamePlace;
}

// Of many starts: full fits from where the best of the rough ones ended, with what colours say.
std::vector<CloudFit> fits_from(const CloudAligner& aligner, const std::vector<Pose>& starts) {
  if (starts.size() == 1) return {held_fit(aligner, starts.front(), kFull)};
  const auto colored_fit = [&](const Pose& start, const FitEffort& effort) {
    CloudFit fit = held_fit(aligner, start, effort);
    if (std::isfinite(fit.cost)) fit.cost += aligner.color_cost(fit.pose, effort.stride);
    return fit;
  };
  std::vector<CloudFit> rough, fits;
  for (const Pose& start : starts) rough.push_back(colored_fit(start, kRough));
  std::ranges::stable_sort(rough, {}, &CloudFit::cost);
  std::vector<Pose> ends;
  for (const CloudFit& fit : rough) {
    if (ends.size() == kRefined || !std::isfinite(fit.cost)) break;
    const auto is_here = [&](const Pose& end) { return is_same_place(end, fit.pose); };
    if (std::ranges::any_of(ends, is_here)) continue;
    ends.push_back(fit.pose);
    fits.push_back(colored_fit(fit.pose, kFull));
  }
  return fits;
}

std::vector<Pose> other_sides(const Pose& camera_from_body, const Pose& body_from_object) {
  std::vector<Pose> sides;
  for (const Eigen::Matrix3d& turn : box_rotations())
    sides.push_back(camera_from_body * body_from_object *
                    Pose{Eigen::Quaterniond(turn), Eigen::Vector3d::Zero()} * body_from_object.inverse());
  return sides;
}

}  // namespace

PoseSigmas after_impact(const PoseSigmas& sigmas) {
  return {kImpactSigmas * sigmas.translation_m, kImpactSigmas * sigmas.rotation_rad};
}

std::optional<CloudAlignment> align_to_cloud(const Camera& camera, const BodyObservation& body,
                                             const SurfaceModel& model, const Pose& predicted,
                                             const PoseSigmas& sigmas, bool stale,
                                             const CloudAlignmentOptions& options) {
  if (!body.silhouette || model.points.cols() < kLeastModel) return std::nullopt;
  if (predicted.translation.z() < kLeastDepth_m) return std::nullopt;
  std::vector<Pose> starts = {predicted};
  for (int axis = 0; stale && axis < 3; ++axis)
    for (int turn = -options.turns; turn <= options.turns; ++turn) {
      if (turn == 0) continue;
      starts.push_back(predicted);
      starts.back().rotation =
          predicted.rotation * exp_so3(turn * options.turn_rad * Eigen::Vector3d::Unit(axis));
    }
  const CloudAligner aligner(camera, body, model, predicted, sigmas, options);
  CloudFit best;
  for (const CloudFit& fit : fits_from(aligner, starts))
    if (fit.cost < best.cost) best = fit;
  if (stale && model.body_from_object && std::isfinite(best.cost))
    for (const CloudFit& fit : fits_from(aligner, other_sides(best.pose, *model.body_from_object)))
      if (fit.matched >= best.matched + kOtherSide && fit.cost < best.cost) best = fit;
  if (!std::isfinite(best.cost)) return std::nullopt;
  // A face that was never seen matches nothing: the outline is enough to go on.
  const bool known = best.matched > options.min_matched;
  const double most_px =
      std::max(options.max_outline_px, options.max_outline_share * 2 * body.silhouette->rot_bbox.semi_minor);
  // What is known of a body may well end inside its outline, if its points lie where they were.
  const double off_px = known ? best.beyond_px : best.outline_px;
  if (best.distance_m > options.max_distance_m || off_px > most_px ||
      (!known && aligner.lines() < options.min_lines))
    return std::nullopt;
  return CloudAlignment{
      best.pose, best.information, best.matched, best.distance_m, aligner.distance_at(predicted), !known};
}

std::vector<Disagreement> disagreements(const Camera& camera, const BodyObservation& body,
                                        const SurfaceModel& model,
                                        const std::vector<LandmarkSighting>& sightings,
                                        const PoseSolverOptions& solver, const std::vector<Pose>& expected,
                                        const PoseSigmas& sigmas, const std::vector<Pose>& poses,
                                        const CloudAlignmentOptions& options) {
  std::optional<CloudAligner> aligner;
  if (model.points.cols() >= kLeastModel)
    aligner.emplace(camera, body, model, expected.front(), sigmas, options);
  const double most = solver.gate_sigmas * solver.gate_sigmas;
  std::vector<Disagreement> result;
  for (const Pose& pose : poses) {
    Disagreement d;
    if (aligner) d.surface = aligner->surface_disagreement(pose);
    d.way = std::numeric_limits<double>::infinity();
    for (const Pose& from : expected) d.way = std::min(d.way, way_cost(from, pose, sigmas));
    if (options.impacts) d.way = cost_with_impacts(d.way);
    for (const LandmarkSighting& sighting : sightings) {
      if (sighting.rim) continue;
      const LinearisedSighting l = linearise(camera, sighting, pose, solver.pixel_sigma_px);
      d.sightings += 0.5 * (l.valid ? std::min(most, l.residual.squaredNorm()) : most);
    }
    result.push_back(d);
  }
  return result;
}

Matrix6d surface_information(const Camera& camera, const BodyObservation& body, const Pose& camera_from_body,
                             const Pose& body_from_object, const Superellipsoid& shape,
                             const CloudAlignmentOptions& options) {
  Matrix6d sum = Matrix6d::Zero();
  const auto seen = evenly_drawn(body, options.max_points);
  if (seen.empty()) return sum;
  const auto add = [&](const Vector6d& row) { sum += kNeighbourEvidence * row * row.transpose(); };
  const Pose body_from_camera = camera_from_body.inverse(), object_from_body = body_from_object.inverse();
  for (const CloudPoint& point : seen) {
    const Eigen::Vector3d p = body_from_camera * point.position;
    const Eigen::Vector3d n = body_from_object.rotation * normal_at(shape, object_from_body * p);
    add(point_row(p, n) / options.point_sigma_m);
  }
  for (const SupportLine& line : body.silhouette ? body.silhouette->support : std::vector<SupportLine>{}) {
    if (!line.free) continue;
    const auto reach_px = [&](const CloudPoint& point) {
      return line.normal.dot((camera.matrix() * point.position).hnormalized());
    };
    const auto furthest =
        std::max_element(seen.begin(), seen.end(),
                         [&](const CloudPoint& a, const CloudPoint& b) { return reach_px(a) < reach_px(b); });
    add(line_row(camera, line, camera_from_body, furthest->position) / options.outline_sigma_px);
  }
  return sum;
}

}  // namespace uniquadric
