#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "evaluation/align/alignment.h"
#include "evaluation/align/body_frame.h"
#include "evaluation/association/object_choice.h"

namespace uniquadric {

struct EvaluateOptions {
  int iou_samples = 100'000;  ///< Monte Carlo samples of the 3D IoU
  std::uint64_t seed = 0;     ///< of those samples
  /// of the estimate's world with the truth's; nothing: `none` where the estimate was given its camera poses,
  /// else `poses`
  std::optional<AlignmentKind> alignment;
  BodyFrame body_frame = BodyFrame::none;  ///< of objects' pose errors
  ObjectChoice objects;                    ///< that are scored
  /// nothing: ignored where the truth says that its labels are partial, else counted false
  std::optional<Unlabelled> unlabelled;
  bool verify = true;  ///< the truth's text files against its hashes.txt
  bool quiet = false;
  bool force = false;  ///< replace an existing output folder
};

/// Compares an estimate with the truth, a folder of Tracks or, of a recording whose truth nobody knows, its
/// sequence folder, and writes `evaluation.json` (CLI contract: keys sorted, units in
/// names), `frames.csv` (one row per frame and object) and `poses.csv` (both sides' poses and semi-axes, in
/// the truth's world) to `out`. Throws InputError for folders that cannot be read or compared: an estimate of
/// another scene, stamps of another recording. Stamps that do not fit the truth's frames are warned of on
/// stderr (stamp_check.h). Those of later outputs of the estimate (kLaterOutputs) are written to folders of
/// their names in `out`.
void evaluate(const std::filesystem::path& truth, const std::filesystem::path& estimate,
              const EvaluateOptions& options, const std::filesystem::path& out);

}  // namespace uniquadric
