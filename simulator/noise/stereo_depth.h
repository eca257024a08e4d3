#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "simulator/noise/pixel_rays.h"

namespace uniquadric {

// Errors that a stereo camera has whatever its noise. Depth: 32FC1, z along the optical axis [m], 0 =
// nothing.

/// Pixels (8UC1, 255) that the second imager, focal_baseline / z to the left in its image, cannot see: what
/// lies right of them lands at their place there or left of it. So a near edge at z_1 throws a shadow of
/// focal_baseline (1 / z_1 - 1 / z_2) pixels to its left on what is z_2 away. focal_baseline: f_x B [px m].
/// `columns` (64FC1, empty: u) are those of PixelRays. With distortion a row is taken as the second imager's
/// line of sight too, though it is a little bent.
cv::Mat stereo_shadow(const cv::Mat& depth_m, double focal_baseline, const cv::Mat& columns = {});

/// Pixels (8UC1, 255) whose surface is seen at more than max_incidence_deg from its normal. The normal is
/// that of the plane through the pixel and, in its row and its column, the neighbour with the more similar
/// depth; where a neighbour is nothing, none is.
cv::Mat flat_incidence(const cv::Mat& depth_m, const PixelRays& rays, double max_incidence_deg);

/// Moves pixels of `edges` (8UC1) with the given probability to a place drawn evenly between the nearest and
/// the farthest depth among them and their 4 neighbours, at random numbers of (seed, "depth_flying", frame,
/// row).
void scatter_edges(cv::Mat& depth_m, const cv::Mat& edges, double probability, std::uint64_t seed,
                   std::int64_t frame);

}  // namespace uniquadric
