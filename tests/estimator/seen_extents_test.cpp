#include "estimator/objects/seen_extents.h"

#include <gtest/gtest.h>

#include <array>

#include "core/base/random.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kHalf(0.25, 0.15, 0.1);

// The box's three faces that a camera at (1, 1, 1) sees, each with its normals, and strays a metre beside it.
struct View {
  Eigen::Matrix3Xd points{3, 900}, normals{3, 900};
  explicit View(double strays_m, int count) {
    RandomStream random(1, "seen_extents_test");
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const int axis = static_cast<int>(i % 3);
      for (int k = 0; k < 3; ++k) points(k, i) = k == axis ? kHalf[k] : kHalf[k] * (2 * random.uniform() - 1);
      normals.col(i) = Eigen::Vector3d::Unit(axis);
      if (i < count) points.col(i) = Eigen::Vector3d(strays_m, 0.1 * random.uniform(), 0);
      if (i < count) normals.col(i) = Eigen::Vector3d::UnitX();
    }
  }
};

// Without points: of an outline that a camera sees touch, to the right of it, a plane along z.
PointView outline_view(const Eigen::Vector3d& camera, const Eigen::Vector3d& sight) {
  static const Eigen::Matrix3Xd none(3, 0);
  PointView view{{Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), sight), camera}, &none, &none};
  const auto in_camera = [&](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(view.body_from_camera.rotation.conjugate() * v);
  };
  const Eigen::Vector3d up = 0.05 * Eigen::Vector3d::UnitZ();
  view.touches = {{in_camera(sight.cross(Eigen::Vector3d::UnitZ()).normalized()), in_camera(sight - up),
                   in_camera(sight + up)}};
  return view;
}

// From the side: of a plane x = end.
PointView side_view(double end_m) {
  return outline_view({end_m, -2, 0}, Eigen::Vector3d::UnitY());
}

Pose looking_at_middle() {
  return {Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d(-1, -1, -1)),
          Eigen::Vector3d(1, 1, 1)};
}

// Its axes and its middle with a variance of 1e-6 each.
Shape fitted(const Eigen::Vector3d& semi_axes_m) {
  Shape shape;
  shape.semi_axes_m = semi_axes_m;
  shape.exponents = {1, 1, 1};
  shape.variances.setConstant(1e-6);
  return shape;
}

Shape with_ends(const View& view, const std::vector<PointView>& more = {},
                const Eigen::Vector3d& fitted_m = 1.1 * kHalf,
                const Eigen::Vector3d& center_m = Eigen::Vector3d::Zero(), bool is_cut = false) {
  const Pose body_from_camera = looking_at_middle();
  View in_camera = view;
  const Eigen::Matrix3d R = body_from_camera.rotation.conjugate().toRotationMatrix();
  in_camera.points = R * (view.points.colwise() - body_from_camera.translation);
  in_camera.normals = R * view.normals;
  Shape shape = fitted(fitted_m);
  shape.body_from_object.translation = center_m;
  std::vector<PointView> views(3, PointView{body_from_camera, &in_camera.points, &in_camera.normals});
  const Eigen::Vector3d x = R.col(0);
  if (is_cut)
    for (PointView& seen : views) seen.cut.push_back(x.head<2>().normalized());
  views.insert(views.end(), more.begin(), more.end());
  return with_seen_extents(shape, views, 0.2);
}

TEST(SeenExtents, AreThoseOfThePoints) {
  const Shape shape = with_ends(View(0, 0));
  const Eigen::Vector3d far_end = shape.body_from_object.translation + shape.semi_axes_m;
  EXPECT_LT((far_end - kHalf).cwiseAbs().maxCoeff(), 0.005);
}

// The same view five times, off by up to 20 mm to all sides: of noise, 15 mm by the median deviation.
Shape with_noisy_ends(const Eigen::Vector3d& fitted_m) {
  const Pose body_from_camera = looking_at_middle();
  const View view(0, 0);
  const Eigen::Matrix3d R = body_from_camera.rotation.conjugate().toRotationMatrix();
  const Eigen::Matrix3Xd normals = R * view.normals;
  std::array<Eigen::Matrix3Xd, 5> points;
  std::vector<PointView> views;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double off_m = 0.01 * (static_cast<double>(i) - 2);
    points[i] =
        R * (view.points.colwise() + (Eigen::Vector3d::Constant(off_m) - body_from_camera.translation));
    views.push_back({body_from_camera, &points[i], &normals});
  }
  return with_seen_extents(fitted(fitted_m), views, 0.2);
}

// Of the fit and of points each counts by its variance: 0.01^2 times 1.4826^2, and 2e-6.
TEST(SeenExtents, LeaveAFitThatIsKnownBetterThanNoisyPoints) {
  for (const double share : {0.9, 1.1}) {
    const Shape shape = with_noisy_ends(share * kHalf);
    const Eigen::Vector3d far_end = shape.body_from_object.translation + shape.semi_axes_m;
    const double of_fit = 2.198e-4 / (2.198e-4 + 2e-6);
    const Eigen::Vector3d mean_m = (of_fit * share + (1 - of_fit)) * kHalf;
    EXPECT_LT((far_end - mean_m).cwiseAbs().maxCoeff(), 2e-4) << share;
    EXPECT_GE(shape.variances.head<3>().minCoeff(), 4e-6) << share;  // of the half that is seen, at its best
  }
}

// Where the outline and the whole fit agree that it goes on beyond its points, it does; of the fit alone, or
// of an outline that goes further, as one that is another body's, less is believed.
TEST(SeenExtents, AreNotShortOfTheOutline) {
  const auto end_x = [](double outlined_m) {
    const Shape shape = with_ends(View(0, 0), {side_view(outlined_m)});
    return shape.semi_axes_m.x() + shape.body_from_object.translation.x();
  };
  EXPECT_NEAR(end_x(0.2), kHalf.x(), 0.005);
  EXPECT_NEAR(end_x(0.26), 0.26, 0.003);
  EXPECT_NEAR(end_x(0.4), 1.1 * kHalf.x(), 1e-6);
  const Shape shape = with_ends(View(0, 0), {side_view(0.2)});
  EXPECT_GT(shape.variances[0], 1e-4);  // points end 25 mm before the fit
}

// Something hides the end along x in every view: how far the body goes on behind it is not known.
TEST(SeenExtents, OfWhatIsCutInEveryViewAreUnknown) {
  const auto sigmas = [](bool is_cut) {
    const Shape shape = with_ends(View(0, 0), {}, kHalf, Eigen::Vector3d::Zero(), is_cut);
    return Eigen::Vector3d(shape.variances.head<3>().cwiseSqrt());
  };
  EXPECT_LT(sigmas(false).x(), 0.02);
  EXPECT_GT(sigmas(true).x(), 0.09);  // half of a radius
  EXPECT_LT(sigmas(true).y(), 0.02);
}

// Ends that no camera saw are not far beyond points beside them, as far as a body can hide.
TEST(SeenExtents, DoNotFollowAFitFarBeyondWhatItWouldShow) {
  const Eigen::Vector3d half = 0.05 * Eigen::Vector3d::Ones();
  const Shape shape = with_ends(View(0, 0), {}, kHalf + half, -half);
  EXPECT_NEAR(shape.body_from_object.translation.x() - shape.semi_axes_m.x(), -kHalf.x(), 0.03);
}

// Of ends that no camera saw the fit knows little where it is far off what was seen beside them.
TEST(SeenExtents, AreUncertainWhereTheFitIsFarOff) {
  const auto sigma = [](double beyond_m) {
    const Eigen::Vector3d half = 0.5 * Eigen::Vector3d::Constant(beyond_m);  // the ends that are seen agree
    return with_ends(View(0, 0), {}, kHalf + half, -half).variances.head<3>().cwiseSqrt().minCoeff();
  };
  EXPECT_LT(sigma(0.002), 0.01);
  EXPECT_GT(sigma(0.1), 0.03);
}

// An outline that passes the edge (0.25, 0.15) at an angle: by a fit that ends before it in y, the body would
// reach further in x than it does.
TEST(SeenExtents, OfOutlinesAreJudgedWithinThePointsOfTheOtherAxes) {
  const PointView aslant = outline_view(Eigen::Vector3d(0.75, -0.85, 0), Eigen::Vector3d(-0.5, 1, 0));
  const Shape shape = with_ends(View(0, 0), {aslant}, {0.29, 0.03, kHalf.z()});
  const Eigen::Vector3d far_end = shape.body_from_object.translation + shape.semi_axes_m;
  EXPECT_NEAR(far_end.x(), kHalf.x(), 0.005);
  EXPECT_NEAR(far_end.y(), kHalf.y(), 0.005);
}

// A third of the points of every view lies a metre off: nothing of the model is there.
TEST(SeenExtents, DoNotFollowStraysFarBeyondTheModel) {
  const Shape shape = with_ends(View(1.2, 300));
  EXPECT_NEAR(shape.semi_axes_m.x() + shape.body_from_object.translation.x(), 1.1 * kHalf.x(), 0.01);
  EXPECT_GT(shape.variances[0], 0.2);  // and say that it is not known
}

}  // namespace
}  // namespace uniquadric
