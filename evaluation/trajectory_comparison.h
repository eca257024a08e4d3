#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/sequence/trajectory.h"
#include "evaluation/align/alignment.h"
#include "evaluation/association/stamps.h"
#include "evaluation/statistics/statistics.h"
#include "evaluation/trajectory/calibrated_drift.h"
#include "evaluation/trajectory/delta_pairs.h"
#include "evaluation/trajectory/drift_angles.h"
#include "evaluation/trajectory/kitti.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

enum class PoseRelation { ape, rpe };
const char* to_string(PoseRelation relation);
/// Of an error: its translation [m], its rotation's angle [rad], or |E - I|_F of the 4x4 matrix (no unit).
enum class ErrorPart { translation, rotation, full };
const char* to_string(ErrorPart part);
const char* unit_of(ErrorPart part);  ///< m, rad, or empty

struct TrajectoryOptions {
  StampOptions association;
  AlignmentKind alignment = AlignmentKind::none;
  std::optional<std::size_t> align_pairs;  ///< the first ones that the alignment is fitted on; nothing: all
  std::vector<PoseRelation> relations = {PoseRelation::ape, PoseRelation::rpe};
  std::vector<ErrorPart> parts = {ErrorPart::translation, ErrorPart::rotation};
  DeltaOptions delta;                        ///< of RPE
  std::optional<bool> pairs_from_reference;  ///< nothing: yes (SPEC 6); evo: no
  bool evo = false;                          ///< evo's choice of pairs and steps; stamps in any order
  bool drift = false, kitti = false;
};

/// One error over the trajectory.
struct ErrorSeries {
  PoseRelation relation = PoseRelation::ape;
  ErrorPart part = ErrorPart::translation;
  std::vector<std::size_t> at;  ///< the pair of each value; of a step its end
  std::vector<double> values;
};

struct TrajectoryComparison {
  std::size_t reference_poses = 0, estimate_poses = 0;
  double reference_path_m = 0, estimate_path_m = 0;  ///< of the files, the estimate's before it is scaled
  double coverage = 0;                               ///< share of the reference's poses that have an estimate
  std::size_t aligned_pairs = 0;                     ///< that the alignment was fitted on
  Alignment alignment;
  PosePairs pairs;  ///< the estimate aligned
  std::vector<ErrorSeries> errors;
  std::optional<Drift> drift;
  std::optional<DriftAngles> drift_angles;
  std::optional<CalibratedDrift> calibrated;
  std::optional<KittiOdometry> kitti;
};

/// Compares two TUM trajectories by SPEC 6. Throws InputError for a bad file, with its line, for fewer than
/// kMinPairs pairs, for an alignment that the poses leave open, and when no two poses lie delta apart.
TrajectoryComparison compare_trajectories(const std::filesystem::path& reference,
                                          const std::filesystem::path& estimate,
                                          const TrajectoryOptions& options);
/// The same of poses with strictly increasing stamps; messages call them `reference` and `estimate`.
TrajectoryComparison compare_trajectories(const Trajectory& reference, const Trajectory& estimate,
                                          const TrajectoryOptions& options);

/// The comparison as JSON: keys sorted, doubles that read back the same, units in the names.
std::string trajectory_json(const TrajectoryComparison& comparison, const TrajectoryOptions& options);
/// As a table for people.
std::string trajectory_text(const TrajectoryComparison& comparison, const TrajectoryOptions& options);

}  // namespace uniquadric
