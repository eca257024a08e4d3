#pragma once

#include <vector>

#include "estimator/shape/reach.h"
#include "estimator/window/long_window.h"

namespace uniquadric {

/// Points and cut sides of a view, in the body's frame; `view` has to outlive it. Cut is also where the
/// points end far inside the outline: they may be those of an earlier mask, which lost a part.
PointView point_view(const Camera& camera, const ShapeView& view);

/// The shape with the ends that points show along its axes, stated as uncertain as they are. The model's
/// family of shapes is small: where points show how far the body reaches, they count. `radius_m`: of the
/// body's first sphere.
Shape with_seen_extents(Shape shape, const std::vector<PointView>& views, double radius_m);

}  // namespace uniquadric
