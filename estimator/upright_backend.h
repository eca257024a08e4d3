#pragma once

#include "estimator/backend.h"

namespace uniquadric {

/// Every body of a perception as a box that stands upright on the ground and moves along its length: an
/// extended Kalman filter over the ends that each frame shows, and its smoother. Bodies need points and, to
/// reach down to it, the ground under them (`contact`).
BackendResult estimate_upright(const Perception& perception, const Variant& variant);

}  // namespace uniquadric
