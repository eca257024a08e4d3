#include "evaluation/iou/solid_iou.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "evaluation/iou/box_iou.h"
#include "tests/evaluation/random_ellipsoid.h"
#include "tests/evaluation/solid_meshes.h"

namespace uniquadric {
namespace {
using std::numbers::pi;

constexpr int kCandidates = 32768;
constexpr SuperExponents kBox{1, 1, 1};

Pose at(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), {x, y, z}};
}

MeanIou iou_of(const Solid& truth, const Superellipsoid& other, const Pose& pose = {}) {
  const SolidIou pair = solid_iou(SolidSamples(truth, kCandidates, 1), other, pose);
  return mean_iou(std::span(&pair, 1));
}

// Within some standard errors, which are to be small.
void expect_iou(const MeanIou& iou, double expected, double errors = 3) {
  EXPECT_LT(iou.standard_error, 0.003);
  EXPECT_NEAR(iou.mean, expected, errors * iou.standard_error + 1e-12);
}

// Second way: the middles of the cells of a grid over both bodies' boxes in the first one's frame, and the
// defining inequality without any short cut.
double grid_iou(const Superellipsoid& a, const Superellipsoid& b, const Pose& a_from_b, int n) {
  const auto power = [](const Superellipsoid& body, const Eigen::Vector3d& point) {
    if ((point.cwiseAbs() - body.semi_axes_m).maxCoeff() > 0) return 2.0;
    const auto dual = [](double q) { return q / (q - 1); };
    const int k = body.profile_axis, i = (k + 1) % 3, j = (k + 2) % 3;
    const double p = dual(body.exponents.outline);
    const double r = dual(point[k] > 0 ? body.exponents.upper : body.exponents.lower);
    const double outline = std::pow(std::pow(std::abs(point[i]) / body.semi_axes_m[i], p) +
                                        std::pow(std::abs(point[j]) / body.semi_axes_m[j], p),
                                    1 / p);
    return std::pow(outline, r) + std::pow(std::abs(point[k]) / body.semi_axes_m[k], r);
  };
  Eigen::AlignedBox3d box(-a.semi_axes_m, a.semi_axes_m);
  for (int i = 0; i < 8; ++i)
    box.extend(
        a_from_b *
        b.semi_axes_m.cwiseProduct(Eigen::Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)).eval());
  const Pose b_from_a = a_from_b.inverse();
  int common = 0, all = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        const Eigen::Vector3d point =
            box.min() + box.sizes().cwiseProduct(Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5) / n);
        const bool in_a = power(a, point) <= 1, in_b = power(b, b_from_a * point) <= 1;
        common += in_a && in_b;
        all += in_a || in_b;
      }
  return static_cast<double>(common) / all;
}

TEST(SolidIou, OfABoxInABoxIsExact) {
  const MeanIou iou = iou_of({{{1, 2, 3}, kBox}}, {{0.5, 1, 1.5}, kBox}, at(0.5, 0.9, -1.4));
  EXPECT_NEAR(iou.mean, 0.125, 1e-12);
  EXPECT_EQ(iou.standard_error, 0);
}

TEST(SolidIou, OfABallInItsBox) {
  expect_iou(iou_of({{{1, 2, 3}, kBox}}, {{1, 2, 3}}), pi / 6);
  expect_iou(iou_of({{{1, 2, 3}}}, {{1, 2, 3}, kBox}), pi / 6);
}

TEST(SolidIou, OfACubeMeshAndItsInscribedAndItsOwnSolid) {
  const Solid cube = solid_of(box_mesh({0, 0, 0}, {0.5F, 0.5F, 0.5F}));
  expect_iou(iou_of(cube, {{0.5, 0.5, 0.5}}), pi / 6);
  EXPECT_NEAR(iou_of(cube, {{0.5, 0.5, 0.5}, kBox}).mean, 1, 1e-6);
}

TEST(SolidIou, OfTurnedBoxesAgreesWithTheExactOne) {
  for (std::uint64_t i = 0; i < 10; ++i) {
    RandomStream random(3, "solid_boxes", i);
    const Ellipsoid a = random_ellipsoid(random, 0.3, 3), b = random_ellipsoid(random, 0.3, 3);
    const Solid mesh = solid_of(box_mesh({0, 0, 0}, a.semi_axes_m.cast<float>()));
    expect_iou(iou_of(mesh, {b.semi_axes_m, kBox}, relative_pose(a.world_from_object, b.world_from_object)),
               box_iou(a, b), 4);
  }
}

TEST(SolidIou, OfTouchingBodiesIsZero) {
  const Solid cube = solid_of(box_mesh({0, 0, 0}, {1, 1, 1}));
  const MeanIou iou = iou_of(cube, {{1, 1, 1}, kBox}, at(2, 0, 0));
  EXPECT_EQ(iou.mean, 0);
  EXPECT_GT(iou.standard_error, 0);  // that nothing was hit proves little
}

TEST(SolidIou, OfThinBodies) {
  const Superellipsoid rod{{1, 0.01, 0.01}, {2, 1, 1}, 0};  // a cylinder along x
  expect_iou(iou_of({{{1, 0.01, 0.01}, kBox}}, rod), pi / 4, 4);
  expect_iou(iou_of({{{1, 0.01, 0.01}, kBox}}, rod, at(1, 0, 0)), pi / 8 / (1 + pi / 4 - pi / 8), 4);
}

TEST(SolidIou, IsTheSameFarFromTheOrigin) {
  const Pose far{Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5), {1e4, -1e4, 1e4}};
  const Pose near{exp_so3({0.1, 0.2, 0.3}), {0.1, 0.2, 0}};
  const Solid box{{{1, 0.5, 0.7}, kBox}};
  const Superellipsoid other{{1, 0.6, 0.7}, {1.2, 1.5, 1.7}, 1};
  EXPECT_NEAR(iou_of(box, other, relative_pose(far, far * near)).mean, iou_of(box, other, near).mean, 1e-3);
}

TEST(SolidIou, OfSuperellipsoidsAgreesWithAGrid) {
  constexpr int kCells = 50;
  constexpr double kGridError = 0.004;  // measured: up to half of that with 80 cells
  for (std::uint64_t i = 0; i < 20; ++i) {
    RandomStream random(2, "solid_pairs", i);
    const auto body = [&](const Ellipsoid& e) {
      const auto q = [&] { return random.uniform(1.05, 2); };
      const double outline = q(), upper = q(), lower = q();
      return Superellipsoid{e.semi_axes_m, {outline, upper, lower}, static_cast<int>(random.below(3))};
    };
    const Ellipsoid first = random_ellipsoid(random, 0.2, 3), second = random_ellipsoid(random, 0.2, 3);
    const Superellipsoid a = body(first), b = body(second);
    const Pose a_from_b = relative_pose(first.world_from_object, second.world_from_object);
    const MeanIou iou = iou_of({a}, b, a_from_b);
    EXPECT_LT(iou.standard_error, 0.003);
    EXPECT_NEAR(iou.mean, grid_iou(a, b, a_from_b, kCells), 3 * iou.standard_error + kGridError);
  }
}

TEST(SolidIou, OfTheSameBodyIsOne) {
  const Superellipsoid body{{1, 2, 3}, {1.2, 1.5, 1.9}, 0};
  const MeanIou iou = iou_of({body}, body);
  EXPECT_EQ(iou.mean, 1);
  EXPECT_EQ(iou.standard_error, 0);
}

// Over frames with the same points the error is that of one, not less by the root of their number.
TEST(SolidIou, MeanOfEqualFramesHasTheErrorOfOne) {
  const SolidSamples samples({{{1, 2, 3}, kBox}}, kCandidates, 1);
  const SolidIou pair = solid_iou(samples, {{1, 2, 3}}, {});
  const std::vector<SolidIou> frames(100, pair);
  const MeanIou one = mean_iou(std::span(&pair, 1)), many = mean_iou(frames);
  EXPECT_NEAR(many.mean, one.mean, 1e-12);
  EXPECT_NEAR(many.standard_error, one.standard_error, 1e-12);
}

// Errors in units of the stated ones, over seeds: neither far too large nor far too small.
TEST(SolidIou, StatesItsError) {
  double squares = 0;
  constexpr int kSeeds = 60;
  const Solid cube = solid_of(box_mesh({0, 0, 0}, {1, 1, 1}));
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const SolidIou pair = solid_iou(SolidSamples(cube, 4096, seed), {{0.9, 1, 1.1}}, {});
    static const double truth =
        mean_iou(std::array{solid_iou(SolidSamples(cube, 1 << 20, 1000), {{0.9, 1, 1.1}}, {})}).mean;
    const MeanIou iou = mean_iou(std::span(&pair, 1));
    squares += std::pow((iou.mean - truth) / iou.standard_error, 2);
  }
  EXPECT_GT(std::sqrt(squares / kSeeds), 0.5);
  EXPECT_LT(std::sqrt(squares / kSeeds), 1.5);
}

TEST(Solid, VolumeOfASuperellipsoidIsThatOfItsSamples) {
  const Superellipsoid body{{1, 2, 3}, {1.3, 1.8, 1.1}, 1};
  std::vector<Eigen::Vector3d> points;
  constexpr int n = 80;
  for (int i = 0; i < n * n * n; ++i) {
    const Eigen::Vector3d cell(i % n, i / n % n, i / n / n);
    points.emplace_back((2 * (cell.array() + 0.5) / n - 1).matrix().cwiseProduct(body.semi_axes_m));
  }
  const auto inside = contains(Solid{body}, points);
  EXPECT_NEAR(static_cast<double>(std::ranges::count(inside, 1)) * 48 / (n * n * n),
              superellipsoid_volume(body), 0.1);
}

TEST(Solid, VolumesInClosedForm) {
  const Eigen::Vector3d a(1, 2, 3);
  EXPECT_NEAR(superellipsoid_volume({a}), 8 * pi, 1e-12);
  EXPECT_NEAR(superellipsoid_volume({a, kBox}), 48, 1e-12);
  EXPECT_NEAR(superellipsoid_volume({a, {2, 1, 1}, 2}), 12 * pi, 1e-12);  // an upright cylinder
  EXPECT_NEAR(superellipsoid_volume({a, {2, 1, 2}, 2}), 10 * pi, 1e-12);  // with a round underside
  EXPECT_NEAR(superellipsoid_volume({a, {1.4, 1.4, 1.4}, 0}), superellipsoid_volume(a, 1.4), 1e-12);
}

std::vector<char> inside_of(const TestMesh& mesh, const std::vector<Eigen::Vector3d>& points) {
  return MeshSolid(mesh.corners, mesh.triangles).contains(points);
}

MeshKind kind_of(const TestMesh& mesh) {
  return MeshSolid(mesh.corners, mesh.triangles).kind();
}

TEST(MeshSolid, OverlappingPartsAreAUnion) {
  const TestMesh both = joined(box_mesh({0, 0, 0}, {1, 1, 1}), box_mesh({1, 0, 0}, {1, 1, 1}));
  EXPECT_EQ(kind_of(both), MeshKind::closed);
  EXPECT_EQ(inside_of(both, {{-0.5, 0, 0}, {0.5, 0.1, 0.2}, {1.5, 0, 0}, {2.5, 0, 0}, {0, 0, 1.1}}),
            (std::vector<char>{1, 1, 1, 0, 0}));
  EXPECT_NEAR(SolidSamples(solid_of(both), kCandidates, 1).volume(), 12, 1e-9);
}

TEST(MeshSolid, VolumeIsKnownWherePartsLieApart) {
  const TestMesh box = box_mesh({0, 0, 0}, {1, 2, 0.5F}), other = box_mesh({5, 0, 0}, {0.5F, 0.5F, 0.5F});
  const auto volume = [](const TestMesh& mesh) {
    return MeshSolid(mesh.corners, mesh.triangles).known_volume();
  };
  EXPECT_NEAR(volume(box).value(), 8, 1e-6);
  EXPECT_NEAR(volume(joined(box, other)).value(), 9, 1e-6);
  EXPECT_FALSE(volume(joined(box, box_mesh({1, 0, 0}, {1, 1, 1}))));
  TestMesh open = box;
  open.triangles.pop_back();
  EXPECT_FALSE(volume(open));
}

// Hardly a sample of the mesh's box would meet the ball.
TEST(SolidIou, OfAMeshWithAFarPart) {
  const TestMesh mesh = joined(ball_mesh(64), box_mesh({1000, 1000, 1000}, {0.01F, 0.01F, 0.01F}));
  const MeshSolid solid(mesh.corners, mesh.triangles);
  const SolidSamples ball({{{1, 1, 1}}}, kCandidates, 1);
  const SolidIou pair = solid_iou(ball, solid, solid.known_volume().value(), {});
  const double share = solid.known_volume().value() / (4 * pi / 3);  // the mesh lies in the ball
  EXPECT_NEAR(pair.iou, share, 0.002);
  EXPECT_LE(solid_iou(ball, solid, 1e-9, {}).iou, 1);
}

TEST(MeshSolid, FacesMayLookInwards) {
  TestMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  for (auto& [a, b, c] : box.triangles) std::swap(b, c);
  EXPECT_EQ(kind_of(box), MeshKind::closed);
  EXPECT_EQ(inside_of(box, {{0.9, 0.9, -0.9}, {0, 1.1, 0}}), (std::vector<char>{1, 0}));
}

TEST(MeshSolid, FacesThatLookEitherWayAreCounted) {
  TestMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  std::swap(box.triangles[3][1], box.triangles[3][2]);
  std::swap(box.triangles[10][1], box.triangles[10][2]);
  EXPECT_EQ(kind_of(box), MeshKind::closed_unoriented);
  EXPECT_EQ(inside_of(box, {{0.9, 0.9, -0.9}, {0, 1.1, 0}, {-1.5, -0.5, -2}}), (std::vector<char>{1, 0, 0}));
}

TEST(MeshSolid, WithoutALidIsOpenAndNearlyTheBox) {
  TestMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  box.triangles.resize(box.triangles.size() - 2);
  EXPECT_EQ(kind_of(box), MeshKind::open);
  EXPECT_NEAR(iou_of(solid_of(box), {{1, 1, 1}, kBox}).mean, 0.95, 0.05);
  EXPECT_EQ(inside_of(box, {{0, 0, -0.5}, {0, 0, 0.5}, {0, 0, 1.5}, {1.2, 0, 0}}),
            (std::vector<char>{1, 1, 0, 0}));
}

TEST(MeshSolid, OfManyTrianglesAgreesWithTheBall) {
  const TestMesh ball = ball_mesh(50);
  EXPECT_EQ(kind_of(ball), MeshKind::closed);
  expect_iou(iou_of(solid_of(ball), {{1, 1, 1}}), 0.996, 4);
}

TEST(MeshSolid, WithoutTrianglesEnclosesNothing) {
  EXPECT_EQ(SolidSamples(solid_of({}), 64, 1).volume(), 0);
}

}  // namespace
}  // namespace uniquadric
