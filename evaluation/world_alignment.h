#pragma once

#include <cstdint>
#include <optional>

#include "core/sequence/tracks.h"
#include "evaluation/align/alignment.h"

namespace uniquadric {

/// The one transform that carries an estimate's world onto the truth's, taken from the camera's trajectory
/// and applied to camera and objects alike (SPEC 6: one left transform a sequence).
struct WorldAlignment {
  AlignmentKind kind = AlignmentKind::none;
  Alignment truth_from_estimate;
  double lever_m = 1;  ///< of AlignmentKind::poses
};

/// Mean distance of the true objects from the true camera over all frames: what a turn of the estimate's
/// world would displace them by, per radian. 1 m without objects.
double object_distance_m(const Tracks& truth);

/// `kind` over all pairs of nearest stamps. Fewer than 3 pairs: no alignment, the caller refuses them.
/// Throws InputError when the poses do not determine the transform.
WorldAlignment align_world(AlignmentKind kind, const Tracks& truth, const Tracks& estimate,
                           std::int64_t max_difference_ns);

/// The estimate in the truth's world; a scale also scales the objects and, squared, the variances of
/// lengths, which lie along the objects' axes.
Tracks in_true_world(const WorldAlignment& alignment, const Tracks& estimate);

}  // namespace uniquadric
