#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "simulator/noise/pixel_rays.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// What a depth sensor makes of exact depth. Both images 32FC1: z along the optical axis [m], 0 = nothing.
/// `rgba`: the colour image without noise, whose fourth channel is the share of the sensor's light that
/// returns; empty: every surface is bright and returns all.
///
/// `proportional`: the point moves along its ray by N(0, k d), d its distance from the optical centre; as z
/// is proportional to d along a ray, z is multiplied by 1 + N(0, k).
/// `stereo`: first disparities mix across edges (smear_disparity), and pixels beside an edge take a place
/// between its two sides with probability flying_pixels. Then the disparity f_x B / z gets the bias and
/// N(0, s), correlated over correlation_px, and is rounded to its step; near sigma_z = s z^2 / (f_x B). What
/// the second imager cannot see (stereo_shadow) and what is seen too flatly (flat_incidence) is lost.
/// In both models pixels beside a depth edge are lost with probability edge_dropout, dark ones and those that
/// return little as `dark_dropout` and `rgba` say, and those out of range always. With `none` depth is exact:
/// no edge is lost, the range holds. With every model depth is then moved as color_offset_m, registered and
/// registration_error_px say.
cv::Mat add_depth_noise(const cv::Mat& depth_m, const cv::Mat& rgba, const PixelRays& rays,
                        const DepthNoise& noise, std::uint64_t seed, std::int64_t frame);

/// Pixels (8UC1, 255) with a 4-neighbour that is nothing or whose z differs by more than 5 % of the nearer
/// one's.
cv::Mat depth_edges(const cv::Mat& depth_m);

}  // namespace uniquadric
