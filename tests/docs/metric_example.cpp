// The example of docs/add_metric.md, which quotes it.
#include <gtest/gtest.h>

#include "core/geometry/ellipsoid.h"

namespace uniquadric {
namespace {

/// Volume of the estimate over that of the truth: above 1 where it came out too large. Poses do not count.
double volume_ratio(const Ellipsoid& estimate, const Ellipsoid& truth) {
  return estimate.semi_axes_m.cwiseQuotient(truth.semi_axes_m).prod();
}

TEST(VolumeRatio, GrowsWithTheCubeOfTheSizeAndDoesNotSeePoses) {
  const Ellipsoid truth{{exp_so3({0.2, -0.4, 0.1}), {1, 2, 3}}, {0.1, 0.2, 0.4}};
  const Ellipsoid doubled{{}, 2 * truth.semi_axes_m}, renamed{{}, {0.4, 0.1, 0.2}};
  EXPECT_DOUBLE_EQ(volume_ratio(doubled, truth), 8);
  EXPECT_DOUBLE_EQ(volume_ratio(truth, doubled), 0.125);
  EXPECT_DOUBLE_EQ(volume_ratio(renamed, truth), 1);
}

}  // namespace
}  // namespace uniquadric
