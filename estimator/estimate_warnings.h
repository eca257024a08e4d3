#pragma once

#include "estimator/estimate.h"
#include "estimator/perception/perception_files.h"

namespace uniquadric {

/// Where the calibration says what no camera has: all that follows would be of another size or shape, or
/// nothing.
void warn_of_the_calibration(const Sequence& sequence);

/// Of input that contradicts itself (suspicions). Scans are watched as they are read. An IMU whose clock the
/// variant knows, or that it does not use, is not compared. Who kept a perception that is there was warned
/// then.
void warn_of_suspicions(Sequence sequence, const Variant& variant, const EstimateOptions& run);

/// Of a result that has hardly anything in it: it is one, but should not be taken for a good one. A scan is
/// lost for a reason; an image may show nothing to follow.
void warn_of_little(const Perception& perception, const Tracks& tracks, bool has_images, bool wants_objects);

}  // namespace uniquadric
