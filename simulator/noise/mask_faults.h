#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "simulator/scene/scene.h"

namespace uniquadric {

constexpr int kFirstFalseId = 60000;  ///< of masks that belong to no object

/// Ids (16UC1) as a segmenter sees them that mixes things up, by the probabilities of `noise`:
/// - merge: of two objects that touch, the one with the larger id takes the other's;
/// - split: the part of an object on one side of a line through its middle takes an id of its own;
/// - leak: an object takes the background below it in the image, leak_px far;
/// - false: an ellipse of background, of 2 to 10 % of the image's width, becomes an object.
/// A fault lasts half a second: it depends on (seed, half second, object) alone.
cv::Mat mask_faults(const cv::Mat& ids, const SegmenterNoise& noise, std::uint64_t seed, double time_s);

}  // namespace uniquadric
