#pragma once

#include "estimator/window/cloud_alignment.h"
#include "estimator/window/long_window.h"

namespace uniquadric {

/// Fills the model's assumed points: of its shape, where no point of the model that faces the same way is
/// near. Needs shape and body_from_object.
void assume_unseen(SurfaceModel& model);

/// Whether the stated sigmas say where all sides of a shape are: two of each semi-axis's are within the
/// distance at which a seen point stands for an assumed one.
bool is_known_all_around(const Shape& shape);

}  // namespace uniquadric
