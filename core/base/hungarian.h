#pragma once

#include <Eigen/Core>
#include <vector>

namespace uniquadric {

/// The assignment of rows to columns that makes the sum of the chosen entries of `weights` greatest, each row
/// and each column at most once: the column of each row, -1 where none is left for it. Any shape, finite
/// entries; of equal assignments always the same one. (Kuhn-Munkres with potentials, O(n^3).)
std::vector<int> maximum_assignment(const Eigen::MatrixXd& weights);

}  // namespace uniquadric
