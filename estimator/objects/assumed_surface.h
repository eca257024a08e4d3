#pragma once

#include "estimator/window/cloud_alignment.h"

namespace uniquadric {

/// Fills the model's assumed points: of its shape, where no point of the model that faces the same way is
/// near. Needs shape and body_from_object.
void assume_unseen(SurfaceModel& model);

}  // namespace uniquadric
