#include "estimator/objects/seen_extents.h"

#include <gtest/gtest.h>

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

// From the side, without points: of an outline that touches a plane x = end.
PointView side_view(double end_m) {
  static const Eigen::Matrix3Xd none(3, 0);
  PointView view{{Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY()),
                  {end_m, -2, 0}},
                 &none,
                 &none};
  const auto in_camera = [&](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(view.body_from_camera.rotation.conjugate() * v);
  };
  view.touches = {{in_camera({1, 0, 0}), in_camera({0, 2, -0.1}), in_camera({0, 2, 0.1})}};
  return view;
}

Shape with_ends(const View& view, const std::vector<PointView>& more = {}, double fitted = 1.1) {
  Pose body_from_camera;
  body_from_camera.translation = {1, 1, 1};
  body_from_camera.rotation =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d(-1, -1, -1));
  View in_camera = view;
  const Eigen::Matrix3d R = body_from_camera.rotation.conjugate().toRotationMatrix();
  in_camera.points = R * (view.points.colwise() - body_from_camera.translation);
  in_camera.normals = R * view.normals;
  Shape shape;
  shape.semi_axes_m = fitted * kHalf;
  shape.exponents = {1, 1, 1};
  shape.variances.setConstant(1e-6);
  std::vector<PointView> views(3, PointView{body_from_camera, &in_camera.points, &in_camera.normals});
  views.insert(views.end(), more.begin(), more.end());
  return with_seen_extents(shape, views, 0.2);
}

TEST(SeenExtents, AreThoseOfThePoints) {
  const Shape shape = with_ends(View(0, 0));
  const Eigen::Vector3d far_end = shape.body_from_object.translation + shape.semi_axes_m;
  EXPECT_LT((far_end - kHalf).cwiseAbs().maxCoeff(), 0.005);
}

// A few millimetres are the points' own error, of which a fit of all of them and of outlines has less.
TEST(SeenExtents, LeaveAFitThatAgrees) {
  for (const double fitted : {0.99, 1.01}) {
    const Shape shape = with_ends(View(0, 0), {}, fitted);
    const Eigen::Vector3d far_end = shape.body_from_object.translation + shape.semi_axes_m;
    EXPECT_LT((far_end - fitted * kHalf).cwiseAbs().maxCoeff(), 4e-4) << fitted;
    EXPECT_GE(shape.variances.head<3>().minCoeff(), 4e-6) << fitted;  // of the half that is seen, at its best
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

// A third of the points of every view lies a metre off: nothing of the model is there.
TEST(SeenExtents, DoNotFollowStraysFarBeyondTheModel) {
  const Shape shape = with_ends(View(1.2, 300));
  EXPECT_NEAR(shape.semi_axes_m.x() + shape.body_from_object.translation.x(), 1.1 * kHalf.x(), 0.01);
  EXPECT_GT(shape.variances[0], 0.2);  // and say that it is not known
}

}  // namespace
}  // namespace uniquadric
