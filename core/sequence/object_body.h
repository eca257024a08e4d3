#pragma once

#include "core/geometry/superquadric.h"
#include "core/sequence/tracks.h"

namespace uniquadric {

/// The body that a state describes, in its own frame.
inline Superellipsoid body_of(const ObjectState& state) {
  return {state.ellipsoid.semi_axes_m, state.exponents, state.profile_axis};
}

}  // namespace uniquadric
