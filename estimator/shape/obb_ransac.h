#pragma once

#include <optional>

#include "core/base/random.h"
#include "estimator/shape/oriented_box.h"

namespace uniquadric {

enum class BoxFit { surface, tight_surface, minimum_volume, pca };
enum class InlierDistance { surface, corner };
enum class AxisRule { blend_best, literal };

/// Options of Alg. 1.
struct ObbOptions {
  BoxFit fit = BoxFit::surface;  // ours: the paper names no fit; measured, docs/estimator/baseline.md
  InlierDistance inlier_distance = InlierDistance::surface;  // ours; `corner` is Eq. 12 as printed
  AxisRule axis_rule = AxisRule::blend_best;                 // ours; `literal` is Alg. 1 l. 13-14 as printed
  bool canonicalise = true;  // ours: the paper averages axes whatever their order
  int iterations = 100;      // ours: the paper's Num has no value; more gain nothing on the tested clouds
  int sample_size = 20;      // ours: more points meet more outliers, fewer shrink the box
  double inlier_threshold_m = 0.01;  // ours: epsilon; three sigmas of an RGB-D camera's depth at 1.5 m
  double best_weight = 0.7;          // ours: omega has no value in the paper
  double min_semi_axis_m = 0.005;    // ours: a single visible face has no thickness, a quadric needs one
};

struct ObbEstimate {
  OrientedBox box;  ///< axes named as they are nearest to the reference
  /// Standard deviation of the accepted models' half extents, along the same axes [m].
  Eigen::Vector3d semi_axes_std_m = Eigen::Vector3d::Zero();
  int inliers = 0;  ///< of the best model
};

/// Oriented bounding box by RANSAC with the uncertainty of its axes (Alg. 1) from points (3 x n, metres), its
/// axes named by the box rotation nearest to `reference`. The paper prints delta = mean(A - mu), which is 0,
/// and blends it with mu; we take the standard deviation and blend mu with the best model's axes. Nothing for
/// fewer than 4 points or when no model has an inlier.
std::optional<ObbEstimate> fit_obb_ransac(const Eigen::Matrix3Xd& points, const ObbOptions& options,
                                          const Eigen::Matrix3d& reference, RandomStream& random);

}  // namespace uniquadric
