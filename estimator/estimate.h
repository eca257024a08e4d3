#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "estimator/variant.h"

namespace uniquadric {

struct EstimateOptions {
  std::uint64_t seed = 0;
  std::optional<std::uint64_t> perception_seed;  ///< of the perception stage alone; nothing: `seed`
  int threads = 0;                               ///< 0: as many as the machine has
  bool quiet = false;
  bool force = false;        ///< replace an existing output folder, and a kept perception of another sequence
  bool camera_only = false;  ///< no objects; masks that the sequence has keep moving ones out of the motion
  bool verify = true;        ///< the sequence's text files against its hashes.txt
  Prompts prompts;
  std::filesystem::path perception;  ///< where the perception stage's result is kept and taken from; empty:
                                     ///< nowhere
};

/// Runs a variant of the estimator on a sequence folder, of which it reads observations alone, and writes to
/// `out`: Tracks (camera.tum, objects/ID.tum, objects.csv), camera.yaml, timing.csv (frame,stage,ms),
/// run.yaml (program, seed, counts and all resolved options) and, where the segmenter worked from prompts,
/// the masks it found (masks/FRAME.png, 16-bit ids). Frames without depth, masks or a camera pose, and
/// objects with too few points, have no state and are counted in run.yaml. The same sequence, variant and
/// seed give the same bytes (timing.csv excepted) for any number of threads, and whether or not the
/// perception stage's result was there. With `feedback: backend` the bodies' estimators go along with
/// perception, frame by frame, and their predictions are its hints; the states are then made from the whole
/// perception as ever, whose camera poses and outlines are those known at the end. Throws InputError for bad
/// sequences and prompts, when such a perception is to be kept, when the camera's poses are to be given and
/// are not, and when no frame has depth, masks and a camera pose; then nothing is left at `out`.
void estimate(const std::filesystem::path& sequence, const Variant& variant, const EstimateOptions& options,
              const std::filesystem::path& out);

/// The perception stage alone, into options.perception, unless its result is there already; `force` lets it
/// replace it, and a folder that holds anything else than one of the same sequence, which else is refused.
void keep_perception(const std::filesystem::path& sequence, const Variant& variant,
                     const EstimateOptions& options);

}  // namespace uniquadric
