#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/sequence/imu.h"

namespace uniquadric {

/// What of an IMU's readings is no measurement of what is wanted: the longest time between two stamps without
/// a reading, several times that between readings, and means that a wrong unit would give. A sentence each.
/// `samples` (one at least) in order of time; stamps of one clock.
std::vector<std::string> imu_faults(const std::vector<ImuSample>& samples, const ImuCalibration& calibration,
                                    std::int64_t first_ns, std::int64_t last_ns);

}  // namespace uniquadric
