#include "estimator/shape/obb_ransac.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "box_scene.h"
#include "core/geometry/box_symmetry.h"
#include "estimator/shape/object_points.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kHalf(0.25, 0.15, 0.1);  // m

ObbEstimate fit(const Eigen::Matrix3Xd& cloud, const ObbOptions& options, const Eigen::Matrix3d& reference,
                int seed = 0) {
  RandomStream random(seed, "obb_ransac_test");
  const auto result = fit_obb_ransac(cloud, options, reference, random);
  if (!result) throw std::runtime_error("no box was found");
  return *result;
}

struct Accuracy {
  BoxCloudOptions cloud;
  double axes_m, rotation_rad, centre_m;
};

// The bounds are three times the root mean square of 24 such clouds (docs/estimator/baseline.md).
TEST(Alg1, FindsTheBoxOfFullPartialNoisyAndPollutedClouds) {
  const std::vector<Accuracy> cases = {
      {{}, 0.012, 0.02, 0.012},
      {{.visible_only = true}, 0.015, 0.02, 0.018},
      {{.noise_m = 0.003, .visible_only = true}, 0.012, 0.045, 0.02},
      {{.noise_m = 0.003, .outliers = 0.05, .visible_only = true}, 0.012, 0.045, 0.02},
  };
  const OrientedBox truth = generic_box(kHalf);
  int fits = 0;
  for (std::size_t c = 0; c < cases.size(); ++c)
    for (int seed = 0; seed < 5; ++seed) {
      RandomStream random(seed, "clouds", c);
      Eigen::Matrix3Xd cloud = box_cloud(truth, cases[c].cloud, random);
      for (int round = 0; round < 2; ++round) cloud = drop_outliers(cloud, 12, 2.5);
      const ObbEstimate result = fit(cloud, ObbOptions{}, truth.axes, seed);
      const double rms = (result.box.half_extents_m - kHalf).norm() / std::sqrt(3);
      EXPECT_LT(rms, cases[c].axes_m) << "case " << c << " seed " << seed;
      EXPECT_LT(rotation_angle(truth.axes.transpose() * result.box.axes), cases[c].rotation_rad)
          << "case " << c << " seed " << seed;
      EXPECT_LT((result.box.center - truth.center).norm(), cases[c].centre_m)
          << "case " << c << " seed " << seed;
      ++fits;
    }
  EXPECT_EQ(fits, 20);
}

TEST(Alg1, AxesAreNamedByTheReferenceWhicheverOfTheTwentyFourItIs) {
  const OrientedBox truth = generic_box(kHalf);
  RandomStream random(3, "clouds");
  const Eigen::Matrix3Xd cloud = box_cloud(truth, {}, random);
  const ObbEstimate plain = fit(cloud, ObbOptions{}, truth.axes);
  int names = 0;
  for (const auto& P : box_rotations()) {
    const ObbEstimate renamed = fit(cloud, ObbOptions{}, truth.axes * P);
    const OrientedBox expected = relabel_axes(plain.box, P);
    EXPECT_LT((renamed.box.axes - expected.axes).norm(), 1e-12);
    EXPECT_EQ(renamed.box.half_extents_m, expected.half_extents_m);
    EXPECT_EQ(renamed.semi_axes_std_m, (P.cwiseAbs().transpose() * plain.semi_axes_std_m).eval());
    ++names;
  }
  EXPECT_EQ(names, 24);
}

TEST(Alg1, BlendsTheMeanOfTheAcceptedAxesWithTheBest) {
  const OrientedBox truth = generic_box(kHalf);
  RandomStream random(4, "clouds");
  const Eigen::Matrix3Xd cloud = box_cloud(truth, {.noise_m = 0.003}, random);
  const auto axes = [&](double weight, AxisRule rule) {
    ObbOptions options;
    options.best_weight = weight;
    options.axis_rule = rule;
    return fit(cloud, options, truth.axes).box.half_extents_m;
  };
  const Eigen::Vector3d mean = axes(0, AxisRule::blend_best), best = axes(1, AxisRule::blend_best);
  EXPECT_GT((mean - best).norm(), 1e-6);
  EXPECT_LT((axes(0.3, AxisRule::blend_best) - (0.7 * mean + 0.3 * best)).norm(), 1e-15);
  // As printed, l. 13's delta is zero and l. 14 leaves (1 - omega) of the mean: a box of 70 % at omega = 0.3.
  EXPECT_LT((axes(0.3, AxisRule::literal) - 0.7 * mean).norm(), 1e-15);
}

TEST(Alg1, CanonicalModelsSpreadLessThanModelsNamedAsTheyCome) {
  const OrientedBox truth = generic_box(kHalf);
  double canonical = 0, as_printed = 0;
  for (int seed = 0; seed < 8; ++seed) {
    RandomStream random(seed, "clouds");
    const Eigen::Matrix3Xd cloud = box_cloud(truth, {.noise_m = 0.003}, random);
    ObbOptions options;
    canonical += fit(cloud, options, truth.axes, seed).semi_axes_std_m.norm();
    options.canonicalise = false;
    as_printed += fit(cloud, options, truth.axes, seed).semi_axes_std_m.norm();
  }
  EXPECT_LT(canonical, 0.5 * as_printed);  // axes of 0.25 and 0.1 m under one name spread by 0.05 m
}

TEST(Alg1, TheLiteralInlierDistanceKeepsACornerAlone) {
  const OrientedBox truth = generic_box(kHalf);
  RandomStream random(5, "clouds");
  const Eigen::Matrix3Xd cloud = box_cloud(truth, {}, random);
  ObbOptions options;
  options.iterations = 300;
  const int surface = fit(cloud, options, truth.axes).inliers;
  options.inlier_distance = InlierDistance::corner;
  options.inlier_threshold_m = 0.03;
  EXPECT_GT(surface, 9 * cloud.cols() / 10);
  EXPECT_LT(fit(cloud, options, truth.axes).inliers, cloud.cols() / 50);
}

TEST(Alg1, ASingleFaceHasTheLeastThicknessAndFewPointsNoBox) {
  RandomStream random(6, "clouds");
  Eigen::Matrix3Xd face(3, 300);
  for (int i = 0; i < 300; ++i) face.col(i) << random.uniform(-0.3, 0.3), random.uniform(-0.2, 0.2), 2;
  const ObbOptions options;
  const ObbEstimate result = fit(face, options, Eigen::Matrix3d::Identity());
  EXPECT_EQ(result.box.half_extents_m.z(), options.min_semi_axis_m);
  EXPECT_FALSE(fit_obb_ransac(face.leftCols(3), options, Eigen::Matrix3d::Identity(), random).has_value());
}

}  // namespace
}  // namespace uniquadric
