#include "estimator/window/cloud_alignment.h"

#include <gtest/gtest.h>

#include <numbers>

#include "synthetic_perception.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kAxes(0.3, 0.2, 0.15);
const Superellipsoid kBox{kAxes, {1, 1, 1}};

Pose still(double) {
  return {exp_so3({0.2, -0.1, 0.4}), {0, 0, 1}};
}

// Above it, so that the top and two sides are seen.
Pose camera(double away) {
  const Eigen::Vector3d from = Eigen::Vector3d(0, 0, 1) + away * Eigen::Vector3d(1.2, -1.6, 1),
                        z = (Eigen::Vector3d(0, 0, 1) - from).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return {Eigen::Quaterniond(R), from};
}

// Each face of a box has a colour of its own.
Eigen::Matrix3Xf face_colors(const Eigen::Matrix3Xd& normals) {
  return (50 * normals.array().round().cast<float>() + 25).matrix();
}

struct Scene {
  explicit Scene(const Eigen::Vector3d& semi_axes_m = kAxes, double away = 1)
      : body(box_body(semi_axes_m, still)), camera_from_body(camera(away).inverse() * still(0)) {
    SyntheticOptions options;
    options.frames = 1;
    options.world_from_camera = [away](double) { return camera(away); };
    perception = synthetic_perception({body}, options);
  }
  SyntheticBody body;
  SyntheticPerception perception;
  Pose camera_from_body;
  const BodyObservation& seen() const { return perception.frames[0].bodies[0]; }
};

Pose moved(const Pose& pose, const Eigen::Vector3d& shift, const Eigen::Vector3d& turn) {
  return pose * Pose{exp_so3(turn), shift};
}

void expect_near(const Pose& found, const Pose& truth, double translation_m, double rotation_rad) {
  EXPECT_LT((found.translation - truth.translation).norm(), translation_m);
  EXPECT_LT(found.rotation.angularDistance(truth.rotation), rotation_rad);
}

TEST(CloudAlignment, FindsABodyFromAPredictionThatIsCentimetresOff) {
  const Scene scene;
  const SurfaceModel model{scene.body.points.leftCols(2000), scene.body.normals.leftCols(2000), {}};
  const Pose predicted = moved(scene.camera_from_body, {0.03, -0.02, 0.02}, {0.08, -0.05, 0.06});
  const auto found =
      align_to_cloud(scene.perception.camera, scene.seen(), model, predicted, {0.05, 0.1}, false, {});
  ASSERT_TRUE(found);
  expect_near(found->camera_from_body, scene.camera_from_body, 0.004, 0.01);
  EXPECT_GT(found->matched, 0.9);
  EXPECT_FALSE(found->new_face);
  EXPECT_GT(found->predicted_distance_m, 2 * found->distance_m);
}

double sigma_of(const Matrix6d& information, const Vector6d& direction) {
  return 1 / std::sqrt(direction.dot(information * direction));
}

// What was predicted is no evidence of what is seen.
TEST(CloudAlignment, StatesWhatTheFrameSaysAlone) {
  const Scene scene;
  const SurfaceModel model{scene.body.points.leftCols(2000), scene.body.normals.leftCols(2000), {}};
  const auto information = [&](const PoseSigmas& sigmas) {
    return align_to_cloud(scene.perception.camera, scene.seen(), model, scene.camera_from_body, sigmas, false,
                          {})
        ->information;
  };
  const Matrix6d loose = information({0.1, 0.3}), tight = information({1e-4, 1e-4});
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(tight(k, k) / loose(k, k), 1, 0.2) << k;
}

TEST(CloudAlignment, ABlankCylindersTurnIsNotKnown) {
  const SyntheticBody body = cylinder_body(0.15, 0.2, still);
  SyntheticOptions options;
  options.frames = 1;
  options.world_from_camera = [](double) { return camera(1); };
  const SyntheticPerception perception = synthetic_perception({body}, options);
  const auto found = align_to_cloud(perception.camera, perception.frames[0].bodies[0],
                                    {body.points.leftCols(4000), body.normals.leftCols(4000), {}},
                                    camera(1).inverse() * still(0), {0.02, 0.02}, false, {});
  ASSERT_TRUE(found);
  for (int k = 0; k < 5; ++k) EXPECT_LT(sigma_of(found->information, Vector6d::Unit(k)), 0.02) << k;
  EXPECT_GT(sigma_of(found->information, Vector6d::Unit(5)), 0.2);
}

// A third of it was never seen: what is known ends far inside the outline, and lies where it did.
TEST(CloudAlignment, FindsABodyOfWhichAPartIsKnown) {
  const Scene scene;
  std::vector<Eigen::Index> known;
  for (Eigen::Index i = 0; i < 2000; ++i)
    if (scene.body.points(0, i) < kAxes.x() / 3) known.push_back(i);
  SurfaceModel model{scene.body.points(Eigen::all, known), scene.body.normals(Eigen::all, known), {}};
  const Pose predicted = moved(scene.camera_from_body, {0.02, -0.02, 0.02}, {0.05, -0.05, 0.05});
  const auto align = [&] {
    return align_to_cloud(scene.perception.camera, scene.seen(), model, predicted, {0.05, 0.1}, false, {});
  };
  auto found = align();
  ASSERT_TRUE(found);
  expect_near(found->camera_from_body, scene.camera_from_body, 0.02, 0.03);
  // where its shape is known to go on, the outline does not pull at what is known
  model.body_from_object = Pose{};
  model.shape = kBox;
  found = align();
  ASSERT_TRUE(found);
  expect_near(found->camera_from_body, scene.camera_from_body, 0.004, 0.01);
}

// One face of it is seen, and beside an occluder two of its edges: points of the surface, which end some way
// before the edges, put it further along them than the shape does.
TEST(CloudAlignment, AShapeTellsWhereThePointsEndBeforeTheOutline) {
  const Scene scene(kAxes, 1);
  std::vector<Eigen::Index> known;
  for (Eigen::Index i = 0; i < scene.body.points.cols(); ++i)
    if ((scene.body.points.col(i).cwiseQuotient(kAxes).array().abs() > 0.97).count() < 2) known.push_back(i);
  SurfaceModel model{scene.body.points(Eigen::all, known), scene.body.normals(Eigen::all, known), {}};
  BodyObservation seen = scene.seen();
  for (SupportLine& line : seen.silhouette->support) line.free = line.normal.x() < -0.1;
  const auto error = [&] {
    const auto found =
        align_to_cloud(scene.perception.camera, seen, model, scene.camera_from_body, {0.1, 0.3}, false, {});
    return found ? (found->camera_from_body.translation - scene.camera_from_body.translation).norm() : 1;
  };
  const double by_points = error();
  model.body_from_object = Pose{};
  model.shape = kBox;
  EXPECT_GT(by_points, 0.01);
  EXPECT_LT(error(), 0.003);
}

TEST(CloudAlignment, TriesTurnedStartsWhenThePredictionIsStale) {
  const Scene scene;
  const SurfaceModel model{scene.body.points.leftCols(2000), scene.body.normals.leftCols(2000), {}};
  const Pose predicted = moved(scene.camera_from_body, {0.02, 0, 0}, {0, 0, 0.6});
  const auto found =
      align_to_cloud(scene.perception.camera, scene.seen(), model, predicted, {0.2, 1.0}, true, {});
  ASSERT_TRUE(found);
  expect_near(found->camera_from_body, scene.camera_from_body, 0.005, 0.02);
}

// A grid on each face, the same from all six sides.
SurfaceModel cube_model(double semi_axis_m) {
  constexpr int kSide = 17;
  SurfaceModel model{Eigen::Matrix3Xd(3, 6 * kSide * kSide), Eigen::Matrix3Xd(3, 6 * kSide * kSide), {}};
  for (int i = 0; i < model.points.cols(); ++i) {
    const int face = i / (kSide * kSide), u = i % kSide, v = i / kSide % kSide, axis = face / 2;
    Eigen::Vector3d p;
    p[axis] = face % 2 == 0 ? 1 : -1;
    p[(axis + 1) % 3] = 2.0 * u / (kSide - 1) - 1;
    p[(axis + 2) % 3] = 2.0 * v / (kSide - 1) - 1;
    model.points.col(i) = semi_axis_m * p;
    model.normals.col(i) = p[axis] * Eigen::Vector3d::Unit(axis);
  }
  return model;
}

// A cube looks the same after a quarter turn, but for its colours.
TEST(CloudAlignment, ColorsTellWhichFaceOfACubeIsSeen) {
  Scene scene(Eigen::Vector3d::Constant(0.2));
  SurfaceModel model = cube_model(0.2);
  const Pose predicted = moved(scene.camera_from_body, {0.02, 0, 0}, {0, 0, 1.0});
  const auto turn_found = [&] {
    const auto found =
        align_to_cloud(scene.perception.camera, scene.seen(), model, predicted, {0.2, 0.5}, true, {});
    return found ? found->camera_from_body.rotation.angularDistance(scene.camera_from_body.rotation) : -1;
  };
  EXPECT_NEAR(turn_found(), std::numbers::pi / 2, 0.02);  // what is nearer to the prediction
  BodyObservation& seen = scene.perception.frames[0].bodies[0];
  const Eigen::Matrix3d body_from_camera = scene.camera_from_body.rotation.inverse().toRotationMatrix();
  seen.colors = face_colors(body_from_camera * seen.normals);
  model.colors = face_colors(model.normals);
  EXPECT_NEAR(turn_found(), 0, 0.02);
}

// The model knows the faces that the camera does not see.
TEST(CloudAlignment, GoesOnByTheOutlineWhenAFaceIsNew) {
  const Scene scene;
  std::vector<Eigen::Index> hidden;
  for (Eigen::Index i = 0; i < 2000; ++i) {
    const Eigen::Vector3d n = scene.camera_from_body.rotation * scene.body.normals.col(i);
    if (n.dot(scene.camera_from_body * Eigen::Vector3d(scene.body.points.col(i))) > 0) hidden.push_back(i);
  }
  const SurfaceModel model{scene.body.points(Eigen::all, hidden), scene.body.normals(Eigen::all, hidden), {}};
  const Pose predicted = moved(scene.camera_from_body, {0.005, -0.005, 0}, {0.02, 0, -0.02});
  const auto found =
      align_to_cloud(scene.perception.camera, scene.seen(), model, predicted, {0.02, 0.03}, false, {});
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->new_face);
  expect_near(found->camera_from_body, scene.camera_from_body, 0.05, 0.06);
}

TEST(CloudAlignment, OfABodyThatIsNotThereIsNothing) {
  const Scene scene;
  const SyntheticBody other = ellipsoid_body({0.1, 0.1, 0.4}, still);
  const SurfaceModel model{other.points, other.normals, {}};
  EXPECT_FALSE(align_to_cloud(scene.perception.camera, scene.seen(), model, scene.camera_from_body,
                              {0.02, 0.03}, true, {}));
}

TEST(CloudAlignment, OfABodyAroundTheCameraIsNothing) {
  const Scene scene;
  const SurfaceModel model{scene.body.points.leftCols(2000), scene.body.normals.leftCols(2000), {}};
  const Pose around{scene.camera_from_body.rotation, {0, 0, 0.2}};
  EXPECT_FALSE(align_to_cloud(scene.perception.camera, scene.seen(), model, around, {0.02, 0.03}, false, {}));
}

// What shows of a body at an occluder's edge has the outline of a small one, which it would be far away.
TEST(CloudAlignment, OutlineDoesNotPutABodyBehindItsPoints) {
  const Scene near, far(kAxes, 2);
  const SurfaceModel model{near.body.points.leftCols(2000), near.body.normals.leftCols(2000), {}};
  BodyObservation sliver = far.seen();
  const auto align = [&] {
    return align_to_cloud(near.perception.camera, sliver, model, far.camera_from_body, {2, 1}, true, {});
  };
  ASSERT_TRUE(align());
  sliver.points = near.seen().points;
  sliver.normals = near.seen().normals;
  EXPECT_FALSE(align());
}

// Sightings of points of the body, as seen from a pose of it.
std::vector<LandmarkSighting> sightings_at(const Scene& scene, const Pose& camera_from_body, int count) {
  std::vector<LandmarkSighting> sightings;
  for (int k = 0; k < count; ++k) {
    LandmarkSighting s;
    s.point_in_body = scene.body.points.col(7 * k);
    const Eigen::Vector3d seen = camera_from_body * s.point_in_body;
    s.pixel = *scene.perception.camera.project(seen);
    s.depth_m = seen.z();
    s.depth_sigma_m = 0.002;
    s.point_sigma_m = 0.001;
    sightings.push_back(s);
  }
  return sightings;
}

// A few sightings that agree on a place where the body is not, as those of a highlight, are outweighed by
// surface, outline and the way there. Many are not.
TEST(CloudAlignment, WeighsSightingsAgainstSurfaceOutlineAndWay) {
  const Scene scene;
  const SurfaceModel model{scene.body.points.leftCols(2000), scene.body.normals.leftCols(2000), {}};
  const Pose& truth = scene.camera_from_body;
  const Pose wrong = moved(truth, {0.12, 0.05, 0}, {0, 0, 0});
  for (const int count : {6, 40}) {
    CloudAlignmentOptions steady;
    steady.impacts = false;
    const auto weigh = [&](const CloudAlignmentOptions& options) {
      return disagreements(scene.perception.camera, scene.seen(), model, sightings_at(scene, wrong, count),
                           {}, {truth}, {0.02, 0.02}, {truth, wrong}, options);
    };
    const auto against = weigh(steady);
    ASSERT_EQ(against.size(), 2u);
    EXPECT_LT(against[0].surface, 5);
    EXPECT_EQ(against[0].way, 0);
    EXPECT_NEAR(against[1].way, 0.5 * (0.13 * 0.13) / (0.02 * 0.02), 1e-6);
    EXPECT_NEAR(weigh({})[1].way, 17 + against[1].way / 100, 1e-6);  // an impact is likelier
    EXPECT_NEAR(against[1].sightings, 0, 1e-6);
    EXPECT_EQ(against[0].sightings, count * 0.5 * 3.5 * 3.5);  // each at the gate
    if (count == 6) EXPECT_LT(against[0].all() + 10, against[1].all());
    if (count == 40) EXPECT_GT(against[0].all(), against[1].all() + 10);
  }
}

// Those about the outline vouch for nothing.
TEST(CloudAlignment, WeighsNoSightingsAboutTheOutline) {
  const Scene scene;
  const SurfaceModel model{scene.body.points.leftCols(2000), scene.body.normals.leftCols(2000), {}};
  const Pose wrong = moved(scene.camera_from_body, {0.05, 0, 0}, {0, 0, 0});
  auto sightings = sightings_at(scene, wrong, 10);
  for (LandmarkSighting& s : sightings) s.rim = true;
  const auto against = disagreements(scene.perception.camera, scene.seen(), model, sightings, {},
                                     {scene.camera_from_body}, {0.02, 0.02}, {scene.camera_from_body}, {});
  EXPECT_EQ(against.front().sightings, 0);
}

}  // namespace
}  // namespace uniquadric
