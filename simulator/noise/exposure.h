#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "simulator/scene/scene.h"

namespace uniquadric {

/// Gains of red, green and blue at a time: slow random changes, sums of sinusoids of 0.05 to 0.5 Hz whose
/// logarithms have the standard deviations `exposure_drift` (all three) and `white_balance_drift` (red and
/// blue besides). They depend on (seed, "exposure", time) alone.
std::array<double, 3> exposure_gains(const Imaging& imaging, std::uint64_t seed, double time_s);

/// An image (8UC4: red, green, blue, and a channel that stays) times `gain`, the gains at that time and, with
/// auto_exposure_level, what brings its mean there (within a quarter to four times). Saturates at 255.
/// The same image where exposure does not change.
cv::Mat exposed(const cv::Mat& rgba, const Imaging& imaging, std::uint64_t seed, double time_s);

/// Error of a frame's stamp [s], offset and jitter: the picture was taken so much before its stamp. Less than
/// half the time between two frames, so that they keep their order.
double stamp_error_s(const Imaging& imaging, double rate_hz, std::uint64_t seed, std::int64_t frame);

}  // namespace uniquadric
