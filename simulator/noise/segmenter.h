#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <set>

#include "simulator/scene/scene.h"

namespace uniquadric {

/// Whether masks come for a frame at all (every_n_frames, outages).
bool is_segmented(const SegmenterNoise& noise, std::uint64_t seed, std::int64_t frame, double rate_hz);

/// How long the segmenter takes for a frame [s]: log-normal, with mean latency_s and standard deviation
/// latency_sigma_s, each frame's of its own. Masks that wait for those of an earlier frame arrive later.
double latency_s(const SegmenterNoise& noise, std::uint64_t seed, std::int64_t frame);

/// The simulated segmenter: a sensor whose masks come from the true ids (16UC1, of visible surfaces), its
/// errors being those of `noise`. Each object's outline moves along its normal by a smooth Gaussian field
/// with standard deviation boundary_sigma_px and autocorrelation exp(-r^2 / (2 boundary_length_px^2)), of its
/// own for each frame and object; a pixel that two moved outlines hold goes to the one it lies deeper in.
/// Objects whose true mask has fewer than min_pixels and, with miss_probability, any object are not found.
/// Before that, mask_faults() changes what it sees, of `objects`, the ids of all objects of the scene. 16UC1,
/// 0 is background.
cv::Mat segment(const cv::Mat& ids, const SegmenterNoise& noise, std::uint64_t seed, std::int64_t frame,
                double rate_hz, const std::set<int>& objects = {});

}  // namespace uniquadric
