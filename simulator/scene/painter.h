#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "core/base/random.h"
#include "simulator/scene/texture.h"

namespace uniquadric {

using Color = cv::Scalar;  ///< blue, green, red in 0..255

/// An image in the making and what its marks are drawn with. Draws happen in the order of the calls: where
/// one expression makes several, brace initialisers keep their order the same for every compiler.
struct Painter {
  const Material& material;
  RandomStream random;
  cv::Mat image;  ///< CV_8UC3
  int unit;       ///< px: side of a medium mark

  static Color shade(const Eigen::Vector3d& rgb, double gain);
  Color tone();       ///< either colour, brighter or darker by as much as the contrast allows
  Color ink();        ///< far from the mean tone, for marks that must stand out
  cv::Point place();  ///< anywhere on the image
  /// px: `low` to `high` medium marks, small ones more often.
  int length(double low, double high);
  /// Marks on the whole image.
  int count(double per_square_unit) const;
};

/// Adds smooth brightness noise at several scales: octaves of random lattices, each twice as fine as the last
/// and weaker.
void add_value_noise(Painter& painter);

}  // namespace uniquadric
