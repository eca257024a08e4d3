#pragma once

#include "simulator/scene/scene.h"

namespace uniquadric {

constexpr double kMostNoiseScale = 1000;  ///< beyond, an outline's errors are larger than any image

/// Multiplies the amplitudes of all of a scene's noise by `scale` (finite, at least 0; asserted): those of
/// depth (k, disparity_sigma_px), the segmenter's outline (boundary_sigma_px), the image (sigma;
/// electrons_per_level is divided by the square), the IMU (noises and walks) and, when it is read, the LiDAR
/// (scale_noise of LidarNoise). Rates, ranges, delays, quantisation and given biases stay: they are no
/// amplitudes of noise. A scene's hash becomes another one unless `scale` is 1.
void scale_noise(Scene& scene, double scale);

}  // namespace uniquadric
