#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <set>

#include "simulator/scene/scene.h"

namespace uniquadric {

constexpr int kFirstFalseId = 60000;  ///< of masks that belong to no object

/// An id from kFirstFalseId on that no object of the scene has. `of_object` is the split object's id, or 0
/// for a mask of nothing. In one `period` each object has another one; the next period has new ones, as of a
/// segmenter without memory. Throws InputError where the objects leave too few.
int false_id(const std::set<int>& objects, std::uint64_t period, int of_object);

/// Ids (16UC1) as a segmenter sees them that mixes things up, by the probabilities of `noise`:
/// - merge: two objects that touch become one; all that are joined so have the smallest id among them;
/// - split: the part of an object on one side of a line through its middle takes a false_id();
/// - leak: an object takes the background below it in the image, leak_px far;
/// - false: an ellipse of background, of 2 to 10 % of the image's width, becomes an object with a
///   false_id().
/// A fault lasts half a second: it depends on (seed, half second, objects) alone. `objects` are the ids of
/// all objects of the scene.
cv::Mat mask_faults(const cv::Mat& ids, const SegmenterNoise& noise, std::uint64_t seed, double time_s,
                    const std::set<int>& objects);

}  // namespace uniquadric
