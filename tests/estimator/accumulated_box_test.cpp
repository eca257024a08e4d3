#include "estimator/shape/accumulated_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "estimator/shape/density_edge.h"
#include "tests/estimator/depth_views.h"

namespace uniquadric {
namespace {

const Eigen::Matrix3d kAxes = Eigen::Matrix3d::Identity();

AccumulatedCloud cloud_of(const RayBody& body, int views, const DepthViewOptions& options, int trial,
                          const CloudOptions& cloud_options = {}) {
  AccumulatedCloud cloud(cloud_options);
  for (int i = 0; i < views; ++i) {
    RandomStream random(5, "depth", static_cast<std::uint64_t>(trial), static_cast<std::uint32_t>(i));
    const Pose camera = arc_camera(i, views);
    cloud.add(depth_view(body, camera, options, random), camera);
  }
  return cloud;
}

std::vector<RayBody> bodies() {
  return {box_body("cuboid", {0.2, 0.15, 0.1}), box_body("cube", {0.15, 0.15, 0.15}),
          ellipsoid_body("ball", {0.12, 0.12, 0.12}), ellipsoid_body("egg", {0.12, 0.10, 0.16}),
          skateboard_body()};
}

struct SideErrors {
  double rms_m = 0, mean_m = 0, rms_in_sigmas = 0, rms_of_largest_m = 0;
  int sides = 0;
};

// Errors of the sides a body shows, over trials.
SideErrors side_errors(const RayBody& body, int views, const DepthViewOptions& options) {
  constexpr int kTrials = 6;
  SideErrors e;
  for (int trial = 0; trial < kTrials; ++trial) {
    const AccumulatedCloud cloud = cloud_of(body, views, options, trial);
    const auto box = accumulated_box(cloud, kAxes);
    EXPECT_TRUE(box);
    for (int i = 0; box && i < 6; ++i) {
      const BodySide& side = box->sides[i];
      if (!side.seen) continue;
      const double error = side.position_m - body.half_extents_m[i / 2];
      e.mean_m += error, e.rms_m += error * error;
      e.rms_in_sigmas += error * error / (side.sigma_m * side.sigma_m);
      const double largest = (cloud.points().transpose() * side.direction).maxCoeff();
      e.rms_of_largest_m += std::pow(largest - body.half_extents_m[i / 2], 2);
      ++e.sides;
    }
  }
  e.mean_m /= e.sides;
  for (double* square : {&e.rms_m, &e.rms_in_sigmas, &e.rms_of_largest_m})
    *square = std::sqrt(*square / e.sides);
  return e;
}

std::string describe(const RayBody& body, int views, const SideErrors& e) {
  const auto mm = [](double metres) { return std::to_string(1e3 * metres) + " mm"; };
  return body.name + " " + std::to_string(views) + ": rms " + mm(e.rms_m) + ", mean " + mm(e.mean_m) + ", " +
         std::to_string(e.rms_in_sigmas) + " sigmas, largest point " + mm(e.rms_of_largest_m) + "\n";
}

// Coordinates drawn with an end at 0.2 m, 0.01 m of noise and 2 % of outliers.
struct EdgeErrors {
  double rms_m = 0, rms_in_sigmas = 0, least_of_largest_m = 1;
};

template <typename Draw>
EdgeErrors edge_errors(const Draw& draw) {
  constexpr int kTrials = 20;
  EdgeErrors e;
  for (int trial = 0; trial < kTrials; ++trial) {
    RandomStream random(1, "points", static_cast<std::uint64_t>(trial));
    Eigen::VectorXd x(4000);
    for (double& value : x)
      value = random.uniform() < 0.02 ? random.uniform(-0.5, 0.5) : draw(random) + 0.01 * random.normal();
    const auto edge = upper_edge(x, Eigen::VectorXd::Ones(x.size()), 0.01);
    EXPECT_TRUE(edge);
    const double error = edge->position_m - 0.2;
    e.rms_m += error * error / kTrials;
    e.rms_in_sigmas += error * error / (edge->sigma_m * edge->sigma_m) / kTrials;
    e.least_of_largest_m = std::min(e.least_of_largest_m, x.maxCoeff());
  }
  e.rms_m = std::sqrt(e.rms_m), e.rms_in_sigmas = std::sqrt(e.rms_in_sigmas);
  return e;
}

TEST(DensityEdge, FindsTheEndOfAFaceASideASlopeAndABulgeUnderNoise) {
  const auto face = [](RandomStream& r) { return r.uniform() < 0.4 ? 0.2 : r.uniform(-0.2, 0.2); };
  const auto side = [](RandomStream& r) { return r.uniform(-0.2, 0.2); };
  const auto slope = [](RandomStream& r) { return 0.2 * std::sqrt(r.uniform()); };  // a ball from the front
  const auto bulge = [](RandomStream& r) {                                          // and from the side
    for (;;) {
      const double x = r.uniform(-0.2, 0.2), y = r.uniform(-0.2, 0.2);
      if (x * x + y * y < 0.04) return x;
    }
  };
  const EdgeErrors all[] = {edge_errors(face), edge_errors(side), edge_errors(slope), edge_errors(bulge)};
  const double limit_m[] = {0.001, 0.009, 0.006, 0.012};
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT(all[i].rms_m, limit_m[i]) << "kind " << i;
    EXPECT_LT(all[i].rms_in_sigmas, 1.6) << "kind " << i;
    EXPECT_GT(all[i].least_of_largest_m, 0.2 + 0.02);  // what is avoided
  }
}

TEST(DensityEdge, WeightsStandForSoManyPoints) {
  RandomStream random(2, "points");
  Eigen::VectorXd once(500), thrice(1500);
  for (int i = 0; i < 500; ++i) {
    once[i] = random.uniform(-0.2, 0.2) + 0.01 * random.normal();
    thrice.segment<3>(3 * i).setConstant(once[i]);
  }
  const auto a = upper_edge(once, Eigen::VectorXd::Constant(500, 3), 0.01);
  const auto b = upper_edge(thrice, Eigen::VectorXd::Ones(1500), 0.01);
  EXPECT_DOUBLE_EQ(a->position_m, b->position_m);
  EXPECT_FALSE(upper_edge(once.head(20), Eigen::VectorXd::Ones(20), 0.01));
  EXPECT_FALSE(upper_edge(Eigen::VectorXd(), Eigen::VectorXd(), 0.01));
}

// The figures of docs/shape.md.
TEST(AccumulatedBox, SidesAreRightWithinMillimetresWhereTheLargestPointIsNot) {
  std::string table;
  const std::map<std::string, double> limit_m = {
      {"cuboid", 0.004}, {"cube", 0.004}, {"ball", 0.006}, {"egg", 0.006}, {"skateboard", 0.004}};
  for (const RayBody& body : bodies())
    for (const int views : {1, 2, 5, 10}) {
      const SideErrors e = side_errors(body, views, {});
      EXPECT_LT(e.rms_m, limit_m.at(body.name)) << body.name << ", " << views << " views";
      EXPECT_GT(e.rms_of_largest_m, 0.1);  // an outlier
      EXPECT_LT(e.rms_in_sigmas, 1.3) << body.name << ", " << views << " views";
      EXPECT_GE(e.sides, 12);
      table += describe(body, views, e);
    }
  RecordProperty("sides", table);
}

TEST(AccumulatedBox, WithoutOutliersTheLargestPointIsStillBeyondTheSurface) {
  DepthViewOptions options;
  options.outliers = 0;
  std::string table;
  for (const RayBody& body : bodies()) {
    const SideErrors e = side_errors(body, 5, options);
    EXPECT_GT(e.rms_of_largest_m, 2.5 * e.rms_m) << body.name;
    EXPECT_LT(e.rms_m, 0.006) << body.name;
    table += describe(body, 5, e);
  }
  RecordProperty("sides", table);
}

TEST(AccumulatedBox, ATenthOfOutliersIsBorne) {
  DepthViewOptions options;
  options.outliers = 0.1;
  for (const RayBody& body : bodies()) {
    EXPECT_LT(side_errors(body, 10, options).rms_m, 0.008) << body.name;
  }
}

// The arc looks on +x, +y and +z alone.
TEST(AccumulatedBox, SidesThatNoCameraSawMakeNoClaim) {
  for (const RayBody& body : bodies()) {
    const auto box = accumulated_box(cloud_of(body, 5, {}, 0), kAxes);
    ASSERT_TRUE(box);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(box->sides[i].seen, i % 2 == 0) << body.name << " side " << i;
    for (int axis = 0; axis < 3; ++axis) EXPECT_FALSE(box->measured(axis));
    // What it says of them is the least: a ball's points end where it turns out of sight.
    for (int i = 1; i < 6; i += 2)
      EXPECT_LT(box->sides[i].position_m, body.half_extents_m[i / 2] + 0.01) << body.name << " side " << i;
  }
}

TEST(AccumulatedBox, FromAllAroundGivesCentreAndHalfExtentsInAnyFrame) {
  const RayBody body = box_body("cuboid", {0.2, 0.15, 0.1});
  const Pose frame_from_body{exp_so3({0.4, -0.3, 0.9}), {0.3, -0.1, 0.2}};
  AccumulatedCloud cloud;
  for (int i = 0; i < 8; ++i) {
    // Four about the body from above, four from below.
    const Pose around{exp_so3({0, 0, 1.57 * i}), {0, 0, 0}},
        over{exp_so3({i < 4 ? 0 : 3.1416, 0, 0}), {0, 0, 0}};
    const Pose camera = over * around * arc_camera(0, 1);
    RandomStream random(6, "depth", 0, static_cast<std::uint32_t>(i));
    cloud.add(depth_view(body, camera, {}, random), camera);
  }
  const auto at_home = accumulated_box(cloud, kAxes);
  cloud.transform(frame_from_body);
  const auto box = accumulated_box(cloud, frame_from_body.rotation.toRotationMatrix());
  ASSERT_TRUE(at_home && box);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_TRUE(box->measured(axis));
    EXPECT_NEAR(box->half_extent_m(axis), body.half_extents_m[axis], 0.003);
    EXPECT_NEAR(box->half_extent_m(axis), at_home->half_extent_m(axis), 0.002);  // other voxels
    EXPECT_LT(box->half_extent_sigma_m(axis), 0.004);
  }
  EXPECT_LT((box->center() - frame_from_body.translation).norm(), 0.003);
}

TEST(AccumulatedBox, TooFewPointsGiveNothing) {
  AccumulatedCloud cloud;
  EXPECT_FALSE(accumulated_box(cloud, kAxes));
  EXPECT_FALSE(accumulated_side(cloud, Eigen::Vector3d::UnitX()));
  cloud.add(Eigen::Matrix3Xd::Random(3, 100), {});
  EXPECT_FALSE(accumulated_box(cloud, kAxes));
}

TEST(AccumulatedCloud, KeepsCountAndMeanWithinItsBound) {
  CloudOptions options;
  options.max_voxels = 500;
  options.voxel_m = 0.001;
  AccumulatedCloud cloud(options);
  RandomStream random(3, "points");
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int frame = 0; frame < 20; ++frame) {
    Eigen::Matrix3Xd points(3, 1000);
    for (double& x : points.reshaped()) x = random.uniform(-0.3, 0.3);
    sum += points.rowwise().sum();
    cloud.add(points, {});
  }
  EXPECT_LE(cloud.points().cols(), 500);
  EXPECT_GT(cloud.points().cols(), 60);
  EXPECT_GT(cloud.voxel_m(), 0.05);
  EXPECT_DOUBLE_EQ(cloud.weights().sum(), 20'000);
  EXPECT_LT((cloud.points() * cloud.weights() - sum).norm(), 1e-9);
}

TEST(AccumulatedCloud, NoiseRunsAlongTheLineOfSight) {
  AccumulatedCloud cloud;
  Eigen::Matrix3Xd points = Eigen::Vector3d(0, 0, 2).replicate(1, 10);
  points.row(0).setLinSpaced(-0.1, 0.1);
  cloud.add(points, {});
  EXPECT_NEAR(std::sqrt(cloud.noise_variance(Eigen::Vector3d::UnitZ())), std::hypot(0.01, 0.003), 1e-4);
  EXPECT_NEAR(std::sqrt(cloud.noise_variance(Eigen::Vector3d::UnitY())), 0.003, 1e-6);
}

}  // namespace
}  // namespace uniquadric
