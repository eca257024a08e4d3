#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// All numbers are ours.
struct PatchAlignmentOptions {
  int half_window_px = 5;  // 11x11: half of a small body's face still has corners whose patch is on it
  int iterations = 10;     // converges in three or four
  static constexpr double max_shift_px = 2;       // from where it is sought: beyond, it is another corner
  static constexpr double min_correlation = 0.7;  // of the patches, after gain and offset
};

/// What a corner looked like where it was found. Later sightings are aligned to it, so that their errors do
/// not add up from frame to frame.
struct PatchAnchor {
  cv::Mat patch;                                    ///< CV_8UC1 around the pixel
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< of the feature in the patch
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< raw image
  Pose camera_from_map;
};

/// Nothing where the patch would reach over the image's border.
std::optional<PatchAnchor> make_anchor(const cv::Mat& gray, const Eigen::Vector2d& pixel,
                                       const Pose& camera_from_map);

/// A piece of a plane, in the frame of a body's map.
struct SurfaceElement {
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::UnitZ();
};

/// How the anchor's surroundings, on that surface, appear now: d pixel_now / d pixel_anchor at the feature;
/// nothing for surfaces that one of the views sees from behind or edge on.
std::optional<Eigen::Matrix2d> anchor_warp(const PatchAnchor& anchor, const SurfaceElement& surface,
                                           const Camera& lens, const Pose& camera_from_map);

struct PatchAlignment {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< raw image
  double correlation = 0;                           ///< of anchor and image there, at most 1
  double sigma_px = 0;                              ///< of the worse direction, from the residuals
};

/// The pixel near `start` whose surroundings fit the warped anchor best: translation by inverse compositional
/// Lucas-Kanade (Baker and Matthews, 2004), gain and offset of the grey levels free. Nothing when it does not
/// converge or the patches do not correlate.
std::optional<PatchAlignment> align_patch(const PatchAnchor& anchor, const Eigen::Matrix2d& warp,
                                          const cv::Mat& gray, const Eigen::Vector2d& start,
                                          const PatchAlignmentOptions& options);

}  // namespace uniquadric
