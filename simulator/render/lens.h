#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>

#include "core/geometry/camera.h"

namespace uniquadric {

/// How a camera with lens distortion is drawn: OpenGL draws what an ideal camera at its place sees, and each
/// pixel takes what stands at its ray there. Depth is z along the optical axis, which both share.
struct Lens {
  /// Without distortion, wide enough for the rays of all pixels. Its focal lengths are twice the camera's, so
  /// that the nearest of its pixels is at most a quarter of the camera's pixels away along an axis.
  Camera ideal;
  cv::Mat places;         ///< 32FC2, of the camera's size: where the pixels' rays meet the ideal image [px]
  cv::Mat cells, shares;  ///< the same less half a pixel each way, in the fixed point of cv::remap
  double steepest = 0;    ///< tangent of the widest angle between a pixel's ray and the optical axis
};

/// Why a camera's distortion cannot be drawn: it has no inverse at some pixel, a ray leaves the axis by more
/// than 85 degrees, or the ideal image has more than 16 Mpx. Nothing where it can.
std::optional<std::string> lens_fault(const Camera& camera);

/// Asserts that the lens has no fault.
Lens make_lens(const Camera& camera);

/// Colour (8UC4). A pixel is the mean over 2 x 2 pixels of the ideal image, which is as large as itself in
/// the middle of the image.
void see_color(const Lens& lens, const cv::Mat& ideal, cv::Mat& rgba);

/// Ids (16UC1) of the nearest pixels of the ideal image.
void see_ids(const Lens& lens, const cv::Mat& ideal, cv::Mat& ids);

/// Stencil bits (8UC1) of the nearest pixels; `ideal` holds `part` of the ideal image, 0 stands outside.
cv::Mat see_bits(const Lens& lens, const cv::Mat& ideal, const cv::Rect& part);

/// Depth (32FC1) [m]. Inverse depth is linear in the ideal image of a plane, so it is interpolated where the
/// four pixels about a ray have one id and lie on one surface: there depth is exact on planes. Elsewhere it
/// is that of the nearest pixel, so that no depth stands between two surfaces.
void see_depth(const Lens& lens, const cv::Mat& ideal_m, const cv::Mat& ideal_ids, cv::Mat& depth_m);

}  // namespace uniquadric
