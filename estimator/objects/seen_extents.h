#pragma once

#include <vector>

#include "estimator/shape/reach.h"
#include "estimator/window/long_window.h"

namespace uniquadric {

/// Points and cut sides of a view, in the body's frame; `view` has to outlive it. Cut is also where the
/// points end far inside the outline: they may be those of an earlier mask, which lost a part.
PointView point_view(const Camera& camera, const ShapeView& view);

/// Where a shape's lengths come from.
enum class Lengths { fitted, assumed };

/// The shape with the ends that points show along its axes, stated as uncertain as they are. The model's
/// family of shapes is small, and points are noisy: an end is the mean of what the views' points show and of
/// the fit, each weighted by its variance. That of points is how far the views disagree. On a side on which
/// the body stood it ends at the plane. `radius_m`: of the body's first sphere, positive. Lengths
/// that no fit gave count only where no view shows an end.
Shape with_seen_extents(const Shape& shape, const std::vector<PointView>& views, double radius_m,
                        const std::vector<ContactSide>& contacts = {}, Lengths lengths = Lengths::fitted);

}  // namespace uniquadric
