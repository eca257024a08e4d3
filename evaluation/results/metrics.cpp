#include "evaluation/results/metrics.h"

#include <fmt/format.h>

#include <cassert>
#include <map>

namespace uniquadric {
namespace {

constexpr int kObject = static_cast<int>(MetricScope::object);
constexpr int kCamera = static_cast<int>(MetricScope::camera);
constexpr int kAll = static_cast<int>(MetricScope::all);
constexpr bool kLower = true, kHigher = false;
constexpr bool kAlways = false, kPart = true;  // by_variant, is_part

constexpr Metric kMetrics[] = {
    {"ape_translation_rmse_m", "APE.t", "m", kLower, kObject | kCamera, "/ape/translation_m/rmse",
     "Absolute pose error, translation: root mean square over frames of the distance between the estimated "
     "and the true centre, in the world frame; no alignment of the object's own."},
    {"ape_rotation_rmse_rad", "APE.r", "rad", kLower, kObject | kCamera, "/ape/rotation_rad/rmse",
     "Absolute pose error, rotation: root mean square of the angle of R_est^T R_true, after one body-frame "
     "rotation per stretch taken from the true shape's own symmetries: box rotations that keep the semi-axes "
     "within 5 %, a free rotation for bodies of revolution and balls (fitted on the first 10 matched "
     "frames). A stretch of states ends where the object was lost or hidden; one of fewer than 10 matched "
     "frames takes the free rotation of a longer one."},
    {"ape_translation_in_view_rmse_m", "APE.t in view", "m", kLower, kObject,
     "/in_view/ape/translation_m/rmse",
     "APE.t over the frames in which the truth says that the object is visible. Empty where it says nothing "
     "of visibility.",
     kAlways, kPart},
    {"ape_rotation_in_view_rmse_rad", "APE.r in view", "rad", kLower, kObject,
     "/in_view/ape/rotation_rad/rmse", "APE.r over the same frames.", kAlways, kPart},
    {"ape_of_distance_rmse", "APE.t of distance", "", kLower, kObject, "/ape_of_distance/rmse",
     "APE.t over the object's true distance from the true camera.", kAlways, kPart},
    {"ape_rotation_naive_rmse_rad", "APE.r naive", "rad", kLower, kObject, "/ape/rotation_naive_rad/rmse",
     "The same angle without regard to symmetry: a cube whose axes were named in another order counts as "
     "wrong."},
    {"rpe_translation_rmse_m", "RPE.t", "m", kLower, kObject | kCamera, "/rpe/translation_m/rmse",
     "Relative pose error, translation: root mean square of the translation of (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) "
     "over "
     "consecutive frames, after the same relabelling of axes. Where a stretch begins both frames have the "
     "names of its axes."},
    {"rpe_rotation_rmse_rad", "RPE.r", "rad", kLower, kObject | kCamera, "/rpe/rotation_rad/rmse",
     "Relative pose error, rotation: root mean square of the angle of the same frame-to-frame difference."},
    {"rpe_translation_in_view_rmse_m", "RPE.t in view", "m", kLower, kObject,
     "/in_view/rpe/translation_m/rmse",
     "RPE.t over the pairs of frames in both of which the truth says that the object is visible.", kAlways,
     kPart},
    {"rpe_rotation_in_view_rmse_rad", "RPE.r in view", "rad", kLower, kObject,
     "/in_view/rpe/rotation_rad/rmse", "RPE.r over the same pairs of frames.", kAlways, kPart},
    {"motion_error_translation_rmse_m", "motion.t", "m", kLower, kObject, "/motion_error/translation_m/rmse",
     "Error of the object's motion in the world, H_k = X_(k+1) X_k^-1, seen from the true object; "
     "independent of "
     "where the body frame was put."},
    {"motion_error_rotation_rmse_rad", "motion.r", "rad", kLower, kObject, "/motion_error/rotation_rad/rmse",
     "Angle of the same motion error."},
    {"iou3d_solid_mean", "IoU solid", "", kHigher, kObject, "/iou3d_solid/mean",
     "Volume of intersection over volume of union of the estimated body, with its exponents, and the true "
     "mesh, else the true box or ellipsoid; mean over frames. Sampled: evaluation.json has the standard "
     "error."},
    {"iou3d_solid_in_view_mean", "IoU solid in view", "", kHigher, kObject, "/in_view/iou3d_solid/mean",
     "IoU solid over the frames in which the truth says that the object is visible.", kAlways, kPart},
    {"surface_f1", "surface F1", "", kHigher, kObject, "/surface_f1/mean",
     "F1 score of the estimated body's surface, mean over frames. Precision is the share of its points "
     "within "
     "t of the true surface, recall that of the true surface's points within t of it; t is 10 mm or 1 % of "
     "the "
     "true body's largest extent, whichever is more."},
    {"chamfer_m", "chamfer", "m", kLower, kObject, "/chamfer_m/mean",
     "Chamfer distance of the same two surfaces, mean over frames: half the sum of the mean distance of the "
     "estimated surface's points from the true surface and of the true one's from the estimated."},
    {"iou3d_ellipsoid_mean", "IoU ellipsoid", "", kHigher, kObject, "/iou3d/mean",
     "Volume of intersection over volume of union of the true and the estimated ellipsoid, mean over frames. "
     "Exact: "
     "integrated over slices, good to 1e-6; the Monte Carlo figure of the paper's method stands beside it in "
     "evaluation.json with its standard error."},
    {"iou3d_box_mean", "IoU box", "", kHigher, kObject, "/iou3d_box/mean",
     "The same ratio for the oriented boxes with those semi-axes as half extents, exact. About a body of "
     "revolution the true box is turned to the estimated one. Labels of recordings are boxes."},
    {"iou2d_mean", "IoU 2D", "", kHigher, kObject, "/iou2d/mean",
     "The same ratio in the image, for the rotated rectangles around the two projected outlines, intersected "
     "by the "
     "Vatti clipper as in the paper. It jumps for near circles, whose rectangle has no preferred angle."},
    {"iou2d_in_view_mean", "IoU 2D in view", "", kHigher, kObject, "/in_view/iou2d/mean",
     "IoU 2D over the frames in which the truth says that the object is visible.", kAlways, kPart},
    {"iou2d_ellipse_mean", "IoU 2D ellipse", "", kHigher, kObject, "/iou2d_ellipse/mean",
     "The same ratio for the projected outlines themselves."},
    {"ape_translation_after_3s_rmse_m", "APE.t after 3 s", "m", kLower, kObject,
     "/after_3s/ape/translation_m/rmse", "APE.t over the frames from 3 s after the object's first state.",
     kAlways, kPart},
    {"ape_rotation_after_3s_rmse_rad", "APE.r after 3 s", "rad", kLower, kObject,
     "/after_3s/ape/rotation_rad/rmse", "APE.r over the same frames.", kAlways, kPart},
    {"rpe_translation_after_3s_rmse_m", "RPE.t after 3 s", "m", kLower, kObject,
     "/after_3s/rpe/translation_m/rmse", "RPE.t over the pairs of the same frames.", kAlways, kPart},
    {"rpe_rotation_after_3s_rmse_rad", "RPE.r after 3 s", "rad", kLower, kObject,
     "/after_3s/rpe/rotation_rad/rmse", "RPE.r over the pairs of the same frames.", kAlways, kPart},
    {"iou3d_solid_after_3s_mean", "IoU solid after 3 s", "", kHigher, kObject, "/after_3s/iou3d_solid/mean",
     "IoU solid over the same frames.", kAlways, kPart},
    {"iou3d_after_3s_mean", "IoU ellipsoid after 3 s", "", kHigher, kObject, "/iou3d_after_3s/mean",
     "IoU ellipsoid over the frames from 3 s after the object's first state.", kAlways, kPart},
    {"iou2d_after_3s_mean", "IoU 2D after 3 s", "", kHigher, kObject, "/iou2d_after_3s/mean",
     "IoU 2D over the frames from 3 s after the object's first state.", kAlways, kPart},
    {"iou3d_from_40deg_mean", "IoU ellipsoid from 40 deg", "", kHigher, kObject, "/iou3d_from_40deg/mean",
     "IoU ellipsoid over the frames by which the camera has seen the object over an arc of 40 degrees: the "
     "largest "
     "angle between two directions to the camera so far, in the true object's frame.",
     kAlways, kPart},
    {"semi_axes_change_occluded_max", "size change occluded", "", kLower, kObject,
     "/semi_axes_change_occluded_max",
     "Greatest relative change of a semi-axis from the last frame before an occlusion to any frame within. "
     "Occluded is what shows less than half of its silhouette, or what the estimate calls so."},
    {"d_shape_mean_m", "d shape", "m", kLower, kObject, "/d_shape_m/mean",
     "Distance between two ellipsoids as bodies, in metres: sqrt(|dc|^2 + BW^2 / 3), BW the "
     "Bures-Wasserstein "
     "distance of their shapes; needs no symmetry rule and no threshold."},
    {"surface_error_median_m", "surface error", "m", kLower, kObject, "/surface/error_m/median",
     "Median distance of the surface points that the estimator kept of the object from the true mesh, the "
     "points' frame laid on the true one once for the whole track, where the poses usually have it. It is of "
     "the model; poses have errors of their own above.",
     true},
    {"surface_error_quantile_90_m", "surface error 90 %", "m", kLower, kObject,
     "/surface/error_m/quantile_90", "What 90 % of the same distances are below.", true},
    {"surface_completeness", "surface seen", "", kHigher, kObject, "/surface/completeness",
     "Share of the true surface that has such a point within 5 % of the diagonal of its tight box. What "
     "nobody saw, as the underside of what stands, is missing.",
     true},
    {"feature_depth_median_m", "feature depth", "m", kLower, kObject, "/feature_depth/error_m/median",
     "Median error of the depth that was recovered for features of the object, from LiDAR or depth images, "
     "against the true mesh along the true line of sight.",
     true},
    {"coverage", "coverage", "", kHigher, kObject | kCamera, "/coverage",
     "Share of the frames in which the object is visible for which there is an estimate (of the camera: of "
     "all "
     "frames). Visible is what shows a tenth of its silhouette and 50 pixels; hidden or out of view, it is "
     "neither hit nor miss. Lost frames count here; the errors above are over the matched frames alone."},
    {"longest_gap_s", "longest gap", "s", kLower, kObject, "/longest_gap_s",
     "Longest time without an estimate; frames in which the object is not visible add nothing."},
    {"id_switches", "id switches", "", kLower, kObject, "/id_switches",
     "How often the estimated track that follows this object changed, any overlap counting as following; "
     "MOTA counts at an IoU of 0.5, so its switches may be others."},
    {"drift_max_translation_m", "drift.t", "m", kLower, kObject | kCamera, "/drift/max_translation_m",
     "Largest translation error after the first poses were aligned."},
    {"drift_max_angle_deg", "drift.r", "deg", kLower, kObject | kCamera, "/drift/max_angle_deg",
     "Largest rotation error after the first poses were aligned."},
    {"hota", "HOTA", "", kHigher, kAll, "/tracking/hota",
     "Higher-order tracking accuracy, with the 3D IoU as similarity."},
    {"mota", "MOTA", "", kHigher, kAll, "/tracking/mota",
     "Multiple-object tracking accuracy: 1 - (misses + false tracks + id switches) / true objects."},
    {"idf1", "IDF1", "", kHigher, kAll, "/tracking/idf1",
     "F1 score of identities kept over the whole sequence."},
    {"false_bodies", "false bodies", "", kLower, kAll, "/tracking/false_bodies",
     "Number of estimated objects that match no true one, in a scene without objects too. An object counts "
     "if it has a state that is active or occluded; one that is tentative throughout does not. Empty where "
     "labels are partial, or no truth of objects exists."},
    {"size_spread_mean", "size spread", "", kLower, kAll, "/size_spread_mean",
     "How steady the estimated sizes are over time, which needs no truth: root mean square relative "
     "deviation "
     "of semi-axes from their median over a track, mean over the tracks.",
     true},
    {"map_precision", "map precision", "", kHigher, kAll, "/map/precision",
     "Of the voxels that the map which the LiDAR was followed by has occupied, those that are in the true "
     "map of "
     "the surroundings (voxels of 0.25 m at least).",
     true},
    {"map_completeness", "map completeness", "", kHigher, kAll, "/map/completeness",
     "Of the true map's occupied voxels, seen or not, those with an occupied one of the estimate in place or "
     "beside it.",
     true},
    {"frame_time_mean_ms", "frame time", "ms", kLower, kAll, "/timing_ms/frame/mean",
     "Mean computing time of the estimator per frame. Measured: it differs between equal runs.", true},
    {"wall_time_s", "wall time", "s", kLower, kAll, "/usage/wall_time_s",
     "Time from start to end of the estimator, with that of a perception stage it shares. Measured.", true},
    {"cpu_time_s", "processor time", "s", kLower, kAll, "/usage/cpu_time_s",
     "Processor time of all processes and threads of the estimator, with that of a perception stage it "
     "shares. "
     "Measured.",
     true},
    {"peak_memory_mb", "peak memory", "MB", kLower, kAll, "/usage/peak_memory_mb",
     "Most memory resident at a time in all processes of the estimator together [10^6 bytes]. Measured.",
     true},
};

constexpr const char* kSummary[] = {"ape_translation_rmse_m",
                                    "ape_rotation_rmse_rad",
                                    "rpe_translation_rmse_m",
                                    "rpe_rotation_rmse_rad",
                                    "iou3d_solid_mean",
                                    "iou3d_ellipsoid_mean",
                                    "iou2d_mean",
                                    "coverage"};

}  // namespace

std::span<const Metric> all_metrics() {
  return kMetrics;
}

std::string_view current_name(std::string_view name) {
  return name == "iou3d_mean" ? "iou3d_ellipsoid_mean" : name;
}

const Metric* metric_of_name(std::string_view name) {
  static const std::map<std::string_view, const Metric*> by_name = [] {
    std::map<std::string_view, const Metric*> metrics;
    for (const Metric& metric : kMetrics) metrics.emplace(metric.name, &metric);
    return metrics;
  }();
  const auto found = by_name.find(name);
  return found == by_name.end() ? nullptr : found->second;
}

const Metric& find_metric(std::string_view name) {
  const Metric* const metric = metric_of_name(name);
  assert(metric);
  return *metric;
}

std::string label_with_unit(const Metric& metric) {
  return *metric.unit ? fmt::format("{} [{}]", metric.label, metric.unit) : metric.label;
}

std::optional<std::string> impossible(const Metric& metric, double value) {
  constexpr double kRounding = 1e-9;  // of a mean of shares
  if (value < 0 && std::string_view(metric.name) != "mota") return fmt::format("{} is below 0", value);
  if (!metric.lower_is_better && value > 1 + kRounding) return fmt::format("{} is more than 1", value);
  return std::nullopt;
}

std::span<const char* const> summary_metrics() {
  return kSummary;
}

}  // namespace uniquadric
