#pragma once

#include <Eigen/Core>
#include <vector>

namespace uniquadric {

/// Points as the columns of a matrix (3 x n).
template <typename Scalar>
Eigen::Matrix3X<Scalar> to_matrix(const std::vector<Eigen::Vector3<Scalar>>& points) {
  Eigen::Matrix3X<Scalar> matrix(3, std::ssize(points));
  for (Eigen::Index i = 0; i < matrix.cols(); ++i) matrix.col(i) = points[static_cast<std::size_t>(i)];
  return matrix;
}

}  // namespace uniquadric
