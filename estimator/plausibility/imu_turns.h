#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/plausibility/turns.h"

namespace uniquadric {

/// Whether a gyroscope turns as the camera does, or as it would in deg/s, in other axes, at another time, or
/// with its place inverted. A sentence, without the file.
std::optional<std::string> gyroscope_suspicion(const ImuCalibration& imu,
                                               const std::vector<ImuSample>& samples,
                                               const std::vector<Turn>& turns);

/// Whether gravity stays where it is as the gyroscope turns, and points down in the image.
std::optional<std::string> gravity_suspicion(const ImuCalibration& imu,
                                             const std::vector<ImuSample>& samples);

}  // namespace uniquadric
