#include "estimator/objects/unseen_ends.h"

#include <gtest/gtest.h>

#include "estimator/shape/to_matrix.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kAxes(0.3, 0.2, 0.1);

Eigen::Matrix3Xd corners(double least_x) {
  std::vector<Eigen::Vector3d> result;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner =
        kAxes.cwiseProduct(Eigen::Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    if (corner.x() > least_x) result.push_back(corner);
  }
  return to_matrix(result);
}

// A box (q = 1) reaches furthest at its corners.
TEST(UnseenEnds, OfABoxAreTheCornersThatWereNotSeen) {
  Shape box;
  box.semi_axes_m = kAxes;
  box.exponents = {1, 1, 1};
  const Eigen::Matrix3Xd ends = unseen_ends(box, corners(0), 0.2);
  ASSERT_GT(ends.cols(), 20);
  for (const auto& end : ends.colwise()) {
    EXPECT_LT((end.cwiseAbs() - kAxes).norm(), 0.002);
    EXPECT_LT(end.x(), 0);
  }
  EXPECT_EQ(unseen_ends(box, corners(-1), 0.2).cols(), 0);
  EXPECT_EQ(unseen_ends(box, Eigen::Matrix3Xd(3, 0), 0.2).cols(), 100);
}

}  // namespace
}  // namespace uniquadric
