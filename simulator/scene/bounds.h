#pragma once

#include <Eigen/Core>
#include <string>

namespace uniquadric {

class ConfigNode;

// Of several keys. All are ours: what no sensor exceeds, and far from where numbers overflow.
constexpr double kMostSize_px = 100;  ///< of errors in the image, a sixth of 640 px
constexpr double kLeastSize_px =
    0.1;                            ///< of a length over which noise is alike: below, each pixel has its own
constexpr double kMostDelay_s = 1;  ///< of a stamp: a slow interface
constexpr double kMostLatency_s = 60;                            ///< of a segmenter: a slow network
constexpr double kLeastOutage_s = 1e-3, kMostOutage_s = 86'400;  ///< a day
constexpr double kMostRange_m = 100'000;                         ///< that a sensor sees
constexpr double kMostRangeError_m = 10;
constexpr double kMostAngle_deg = 45;  ///< of a beam's width and of its errors
constexpr double kMostOffset_m = 100;  ///< of a sensor from the camera: both ends of a ship
constexpr double kMostTurn_deg = 360;

/// Each is the number at `key`, or `fallback` where there is none. It throws InputError with file and line
/// for one that is out of bounds or not finite.
double read_between(const ConfigNode& node, const std::string& key, double fallback, double least,
                    double most);
/// From 0 on, without a bound above.
double read_at_least_0(const ConfigNode& node, const std::string& key, double fallback);
/// From 0 on.
double read_at_most(const ConfigNode& node, const std::string& key, double fallback, double most);
/// Above 0.
double read_positive(const ConfigNode& node, const std::string& key, double fallback, double most);
/// 0, which switches something off, or from `least` on.
double read_zero_or(const ConfigNode& node, const std::string& key, double fallback, double least,
                    double most);
/// Either sign.
double read_within(const ConfigNode& node, const std::string& key, double fallback, double most);
/// The same of each of three.
Eigen::Vector3d read_within(const ConfigNode& node, const std::string& key, const Eigen::Vector3d& fallback,
                            double most);

}  // namespace uniquadric
