#pragma once

#include <map>
#include <opencv2/core/mat.hpp>

#include "core/geometry/camera.h"
#include "estimator/observation/perception.h"

namespace uniquadric {

/// How masks become silhouettes.
struct SilhouetteOptions {
  int directions = 16;  // ours: what is gained beyond is within the noise (4: the paper's RotBbox)
  int min_pixels = 50;  // ours: under 8 px across a pixel of noise is more than a tenth of the size
  static constexpr double min_share =
      0.15;  // ours: smaller parts beside the largest are specks of a bad mask
  // The outermost point of a noisy outline lies too far out, the more so the longer the stretch that competes
  // to be outermost. Its mean can be taken off: 0.75 outline_noise_px ln(1 + L / outline_length_px), L the
  // length of the hull beside the tangent, each piece weighted by exp(-1.5 gap / outline_noise_px). Measured
  // over drawn discs, boxes and hexagons with noise of 1 px (sigma) and 15 px (length), bias and rms of the
  // error in px: 16 directions +0.20 1.23 as they are, -0.16 1.21 with it; sides of polygons +0.83 1.38 and
  // +0.24 1.10.
  double outline_noise_px =
      0;  // ours: outlines fitted to depth edges (mask_edges.h) have no bias to speak of
  static constexpr double outline_length_px = 15;
  static constexpr double border_px =
      2.5;  // ours: an outline this near to the image's border may be cut by it
  static constexpr double touch_px = 1.5;  // ours: outline points this near to a tangent are what it touches
  static constexpr double cut_share =
      0.25;  // ours: of the points touched; more of them cut and the tangent is not free
  static constexpr double occluder_jump =
      0.03;  // ours: relative; six sigma of depth noise of 0.5 %, the floor's slope is less
  static constexpr int occluder_reach_px =
      6;  // ours: how far outside a neighbour is looked for: masks are pixels off
};

/// The silhouette of each body in `masks` (CV_16UC1 ids, 0 none) with at least `min_pixels`. A tangent is
/// free unless what it touches lies at the image's border or has something nearer beside it: depth that is
/// clearly less (`depth` CV_32FC1 [m], 0 none; may be empty), or another id that is not known to be farther.
/// `segmented` and `known_at_frame` are left to the caller.
std::map<int, Silhouette> silhouettes(const cv::Mat& masks, const cv::Mat& depth, const Camera& camera,
                                      const SilhouetteOptions& options);

}  // namespace uniquadric
