#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>
#include <vector>

namespace uniquadric {

/// `count` low-discrepancy points in the unit cube, shifted at random: by the stream of that seed and name,
/// each replicate by another shift.
std::vector<Eigen::Vector3d> shifted_sequence(int count, std::uint64_t seed, std::string_view name,
                                              int replicate);

/// Randomly shifted copies of the sequence that an estimate is made of: their spread tells its error.
inline constexpr int kReplicates = 32;

/// Standard error of a mean over kReplicates: their number is finite (Student's t), and two samples are
/// counted beside those seen (Agresti and Coull). `of_sample`: by how much one changes the mean.
double replicates_error(double variance_of_mean, double of_sample);

}  // namespace uniquadric
