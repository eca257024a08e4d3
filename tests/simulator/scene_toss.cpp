#include <gtest/gtest.h>

#include <cmath>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/sequence/trajectory.h"
#include "simulator/scene/contact.h"
#include "simulator/scene/motion_reader.h"
#include "simulator/scene/shape_reader.h"
#include "simulator/scene/toss.h"
#include "tests/simulator/motion_differences.h"
#include "tests/simulator/scene_support.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kGravity_mps2 = 9.81;
const Vector3d kX = Vector3d::UnitX(), kZ = Vector3d::UnitZ();

std::vector<Vector3d> box(const Vector3d& semi_axes) {
  std::vector<Vector3d> corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back(semi_axes.cwiseProduct(Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
  return corners;
}

const Vector3d kSemiAxes(0.05, 0.05, 0.05);

double lowest(const Pose& pose, const std::vector<Vector3d>& points) {
  double z = 1e9;
  for (const Vector3d& p : points) z = std::min(z, (pose * p).z());
  return z;
}

double energy(const Kinematics& k, const Vector3d& semi_axes) {  // of mass 1
  const Vector3d squares = semi_axes.cwiseAbs2() / 3;
  const Vector3d inertia = Vector3d::Constant(squares.sum()) - squares;
  return kGravity_mps2 * k.pose.translation.z() + k.velocity_mps.squaredNorm() / 2 +
         inertia.dot(k.angular_velocity_radps.cwiseAbs2()) / 2;
}

std::vector<TossOptions> tumbling_tosses() {
  std::vector<TossOptions> list;
  for (int k = 0; k < 6; ++k)
    list.push_back({.start = {exp_so3({0.3 * k, 0.7, -0.2 * k}), {0, 0, 0.3 + 0.1 * k}},
                    .velocity_mps = {1.0 + 0.2 * k, -0.5, 0.4 * k},
                    .angular_velocity_radps = {5.0 - 3 * k, 8, 2.0 * k},
                    .restitution = 0.15 * k,
                    .friction = 0.1 + 0.1 * k});
  return list;
}

TEST(TossMotion, FliesAParabolaAndSpinsEvenly) {
  const Vector3d velocity(1, -2, 3), spin(0, 0, 7);  // about a principal axis of the turned box
  const Pose start{exp_so3(0.4 * kZ), {0, 0, 5}};
  const Motion motion =
      toss_motion({.start = start, .velocity_mps = velocity, .angular_velocity_radps = spin, .begins_s = 0.5},
                  box({0.1, 0.2, 0.05}));
  EXPECT_EQ(motion.at(0.49).translation, start.translation);
  EXPECT_EQ(motion.kinematics(0.49).velocity_mps, Vector3d::Zero());
  for (const double t : {0.1, 0.41234, 0.9}) {
    const Kinematics found = motion.kinematics(0.5 + t);
    const Vector3d place = start.translation + t * velocity - kGravity_mps2 / 2 * t * t * kZ;
    EXPECT_LT((found.pose.translation - place).norm(), 1e-10);
    EXPECT_LT((found.velocity_mps - (velocity - kGravity_mps2 * t * kZ)).norm(), 1e-9);
    EXPECT_LT(log_so3(found.pose.rotation.conjugate() * exp_so3(t * spin) * start.rotation).norm(), 1e-10);
    EXPECT_LT((found.angular_velocity_radps - spin).norm(), 1e-9);
  }
}

TEST(TossMotion, KeepsMomentumAndEnergyInFlight) {
  const Vector3d semi_axes(0.1, 0.2, 0.05);
  const Motion motion = toss_motion(
      {.start = {{1, 0, 0, 0}, {0, 0, 30}}, .angular_velocity_radps = {0.1, 0.1, 12}}, box(semi_axes));
  const Motion unstable = toss_motion(
      {.start = {{1, 0, 0, 0}, {0, 0, 30}}, .angular_velocity_radps = {12, 0.1, 0.1}}, box(semi_axes));
  for (const Motion& m : {motion, unstable})
    for (double t = 0.1; t < 2; t += 0.3)
      EXPECT_NEAR(energy(m.kinematics(t), semi_axes), energy(m.kinematics(0.001), semi_axes), 1e-4);
}

TEST(TossMotion, MatchesDifferencesOfItsPoses) {
  for (const TossOptions& options : tumbling_tosses()) {
    const Motion motion = toss_motion(options, box(kSemiAxes));
    for (int k = 0; k < 4000; k += 331)  // in the middle of a step, impacts among them
      scene_test::expect_derivatives(motion, (k + 0.5) * 2.5e-4, 2e-5, 1e-5, 1.0);
  }
}

TEST(TossMotion, ReboundsAsItsRestitutionSays) {
  constexpr double kTwoSteps_m = 2 * 2.5e-4 * 3.2;  // at the landing's speed: it bounces up to a step early
  for (const double restitution : {0.3, 0.6, 0.9}) {
    const Motion motion =
        toss_motion({.start = {{1, 0, 0, 0}, {0, 0, 0.55}}, .restitution = restitution}, box(kSemiAxes));
    const double landing_s = std::sqrt(2 * 0.5 / kGravity_mps2);
    const double apex_s = landing_s * (1 + restitution);
    const Pose apex = motion.at(apex_s);
    EXPECT_NEAR(apex.translation.z() - 0.05, restitution * restitution * 0.5, kTwoSteps_m);
    EXPECT_LT(log_so3(apex.rotation).norm(), 1e-5);  // it fell flat
  }
}

TEST(TossMotion, NeverGainsEnergyNorSinksIn) {
  const std::vector<Vector3d> corners = box(kSemiAxes);
  for (const TossOptions& options : tumbling_tosses()) {
    const Motion motion = toss_motion(options, corners);
    double before = energy(motion.kinematics(0), kSemiAxes);
    for (int k = 0; k < 20'000; ++k) {
      const Kinematics found = motion.kinematics(k * 2.5e-4);
      const double now = energy(found, kSemiAxes);
      ASSERT_LT(now, before + 1e-5) << k;  // m^2/s^2; rounding of a turn's second order
      ASSERT_GT(lowest(found.pose, corners), -1e-3) << k;
      before = now;
    }
  }
}

TEST(TossMotion, EndsAtRestOnAFace) {
  const std::vector<Vector3d> corners = box(kSemiAxes);
  for (const TossOptions& options : tumbling_tosses()) {
    const Motion motion = toss_motion(options, corners);
    const Kinematics end = motion.kinematics(30);
    EXPECT_EQ(end.velocity_mps, Vector3d::Zero());
    EXPECT_EQ(motion.at(15).translation, end.pose.translation) << "still under way";
    EXPECT_NEAR(end.pose.translation.z(), 0.05, 1e-4);
    const Vector3d up = end.pose.rotation.conjugate() * kZ;
    EXPECT_GT(up.cwiseAbs().maxCoeff(), 1 - 1e-6);
  }
}

TEST(TossMotion, SlidesAsFarAsFrictionLetsIt) {
  const double friction = 0.3, speed = 1.5;
  const Motion motion =
      toss_motion({.start = {{1, 0, 0, 0}, {0, 0, 0.02}}, .velocity_mps = speed * kX, .friction = friction},
                  box({0.1, 0.1, 0.02}));
  const double way = speed * speed / (2 * friction * kGravity_mps2);
  EXPECT_NEAR(motion.at(10).translation.x(), way, 0.005 * way);
  EXPECT_NEAR(motion.at(10).translation.y(), 0, 1e-3);
}

TEST(TossMotion, IsTheSameEachTime) {
  for (const TossOptions& options : tumbling_tosses()) {
    const Motion one = toss_motion(options, box(kSemiAxes)), other = toss_motion(options, box(kSemiAxes));
    for (double t = 0; t < 4; t += 0.37)
      EXPECT_TRUE(one.at(t).translation == other.at(t).translation &&
                  one.at(t).rotation.coeffs() == other.at(t).rotation.coeffs());
  }
}

// Of a recorded toss of a cube the flight's beginning is taken; heights, way and time of the tumbling are
// chance, but of an order.
TEST(TossMotion, ResemblesARecordedToss) {
  const std::filesystem::path file = scene_test::kData / "tosses/toss_00.tum";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
  const Trajectory recorded = read_tum(file);
  const auto pose = [&](std::size_t k) { return recorded[k].pose; };
  const double step_s = static_cast<double>(recorded[4].stamp_ns - recorded[0].stamp_ns) * 1e-9;
  const TossOptions options{
      .start = pose(2),
      .velocity_mps = (pose(4).translation - pose(0).translation) / step_s,
      .angular_velocity_radps = log_so3(pose(4).rotation * pose(0).rotation.conjugate()) / step_s,
      .floor_m = -0.002,  // the recording's own error
      .restitution = 0.3,
      .friction = 0.25};
  const Motion motion = toss_motion(options, box(Vector3d::Constant(0.0524)));
  const double end_s = static_cast<double>(recorded.back().stamp_ns) * 1e-9;
  EXPECT_NEAR(motion.at(end_s).translation.z(), pose(recorded.size() - 1).translation.z(), 0.01);
  EXPECT_LT((motion.at(end_s).translation - pose(recorded.size() - 1).translation).norm(), 0.3);
}

Motion read(const std::string& yaml, const std::string& shape, Mover mover = Mover::body) {
  std::vector<std::filesystem::path> files;
  const SceneShape body = read_shape(ConfigNode::parse(shape, "shape.yaml"), {1, TextureAmount::none});
  return read_motion(ConfigNode::parse(yaml, "motion.yaml"), {mover, files, body.meshes});
}

TEST(TossMotion, IsReadForABodysOwnShape) {
  const std::string toss = "kind: toss\nstart: {position_m: [0, 0, 1]}\n";
  for (const std::string shape : {"rounded_box", "cylinder", "car", "ball"}) {
    SCOPED_TRACE(shape);
    const std::string body = "primitive: " + shape + "\nsize_m: [0.2, 0.2, 0.2]\n";
    const Motion motion = read(toss +
                                   "floor_m: 0.1\nvelocity_mps: [0.3, 0.1, 0]\n"
                                   "angular_velocity_degps: [100, 300, 50]\n",
                               body);
    EXPECT_GT(motion.at(30).translation.z(), 0.1 + 0.06);
    EXPECT_LT(motion.at(30).translation.z(), 0.1 + 0.15);
  }
  const std::string ball = "primitive: ball\nsize_m: [0.2, 0.2, 0.2]\n";
  EXPECT_THROW(read(toss, ball, Mover::camera), InputError);
  EXPECT_THROW(read(toss + "floor_m: 0.95\n", ball), InputError);
  EXPECT_THROW(read(toss + "restitution: 1.2\n", ball), InputError);
  EXPECT_THROW(read(toss + "friction: -1\n", ball), InputError);
}

TEST(ContactPoints, AreTheCornersOfABoxAndSpanATightBox) {
  const SceneShape shape = read_shape(ConfigNode::parse("primitive: box\nsize_m: [1, 2, 3]\n", "shape.yaml"),
                                      {1, TextureAmount::none});
  EXPECT_EQ(contact_points(shape.meshes).size(), 8u);
}

}  // namespace
}  // namespace uniquadric
