#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/resource_usage.h"
#include "core/sequence/tracks.h"
#include "evaluation/association/tracking_scores.h"
#include "evaluation/camera_evaluation.h"
#include "evaluation/evaluate.h"
#include "evaluation/metrics/map_comparison.h"
#include "evaluation/object_evaluation.h"
#include "evaluation/size_steadiness.h"
#include "evaluation/world_alignment.h"

namespace uniquadric {

/// Everything that one comparison of truth and estimate yields.
struct Evaluation {
  WorldAlignment alignment;
  CameraEvaluation camera;
  std::vector<ObjectEvaluation> objects;
  Unlabelled unlabelled = Unlabelled::counted_false;
  std::vector<int> unmatched_ids;   ///< estimated tracks that belong to no truth object
  std::optional<int> false_bodies;  ///< empty where labels are partial, or no truth of objects exists
  std::optional<TrackingScores> tracking;
  /// Of all estimated objects, whether or not a truth speaks of them, but those that it does not score.
  std::vector<SizeSteadiness> sizes;
  std::map<std::string, std::vector<double>> timing_ms;
  std::optional<ResourceUsage> usage;  ///< of the whole run, where it says
  std::optional<MapComparison> map;    ///< of the surroundings, where the estimate wrote one
};

/// evaluation.json: keys sorted, doubles that read back the same. `run_config_json` is the estimate's
/// run.yaml as read_run_config gives it. Throws InputError for a figure that is not finite.
std::string evaluation_json(const Evaluation& evaluation, const EvaluateOptions& options,
                            const std::string& run_config_json);

/// frames.csv: one row a truth frame and object, cells empty where there is no figure.
std::string frames_csv(const std::vector<ObjectEvaluation>& objects);

inline constexpr std::array kPosesColumns = {
    "source",  "subject", "id",    "timestamp_ns", "x_m",           "y_m",           "z_m",
    "qx",      "qy",      "qz",    "qw",           "semi_axis_x_m", "semi_axis_y_m", "semi_axis_z_m",
    "outline", "upper",   "lower", "profile_axis", "sigma_x_m",     "sigma_y_m",     "sigma_z_m"};
/// Earlier versions wrote so many of them: without the solid's exponents and the centre's sigmas.
inline constexpr std::size_t kFewPosesColumns = 14;

/// poses.csv: what was compared, a row a pose of `truth` and of `estimate`, both in the truth's world: the
/// cameras (world_from_camera, no semi-axes) and the objects. A track that was matched stands under the true
/// object's id; the others, `unmatched`, under their own. Nine digits. Sigmas are of the centre, in the frame
/// that covariance_diagonal has; empty where not estimated.
std::string poses_csv(const Tracks& truth, const Tracks& estimate, const Evaluation& evaluation);

}  // namespace uniquadric
