#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/pose.h"

namespace uniquadric {

enum class AlignmentKind { none, first, se3, sim3, scale, posyaw, poses };
const char* to_string(AlignmentKind kind);
std::optional<AlignmentKind> parse_alignment_kind(std::string_view text);
bool fits_scale(AlignmentKind kind);

/// x -> scale * (rotation x) + translation, applied to an estimate from the left (world frame).
struct Alignment {
  double scale = 1;
  Pose reference_from_estimate;

  /// The pose's position is scaled, its rotation only turned.
  Pose operator*(const Pose& pose) const;
};

/// What align() throws where positions leave the transform open.
struct OpenAlignment : InputError {
  OpenAlignment(const std::string& what, bool reference_alone)
      : InputError(what), of_reference(reference_alone) {}
  bool of_reference;  ///< it is the reference's positions and not the estimate's
};

/// The transform of `kind` that carries the estimate's poses onto the reference's: `first` makes the first
/// poses coincide, `se3` and `sim3` are least squares of the positions (Umeyama, "Least-squares estimation of
/// transformation parameters between two point patterns", PAMI 1991), `scale` keeps only the scale of sim3
/// (evo's correct_scale), `posyaw` fits positions by a translation and a turn about the world's z axis,
/// `poses` is least squares of positions and orientations, a turn of 1 rad weighing as `lever_m` metres: it
/// is determined by any path, also by one along a line or none. Lists of equal length, in pairs. Throws
/// InputError for fewer than 3 pairs, OpenAlignment when the positions of a side do not determine the
/// transform: all on one line (se3, sim3, scale), or all in one point of the plane (posyaw).
Alignment align(AlignmentKind kind, const std::vector<Pose>& reference, const std::vector<Pose>& estimate,
                double lever_m = 1);

}  // namespace uniquadric
