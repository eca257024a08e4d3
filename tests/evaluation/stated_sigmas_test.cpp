// What is stated of the states' errors, against the errors.
#include <cmath>

#include "core/base/text.h"
#include "tests/evaluation/evaluate_fixture.h"

namespace uniquadric {
namespace {

// By hand: the centre is off by 0.03 m against sigmas of 0.01 along each axis, 3 / sqrt(3) of what they sum
// to; the turn by 0.02 rad against 0.01, 0.02, 0.02; the axes by 0.03, 0, 0.04 against 0.1 in all.
TEST_F(Evaluate, ErrorsAreHeldAgainstTheSigmasThatAreStated) {
  write_changed([](Tracks& tracks) {
    for (ObjectState& state : tracks.objects[0].states) {
      Ellipsoid& e = state.ellipsoid;
      e.world_from_object.translation += Eigen::Vector3d(0, 0.03, 0);
      e.world_from_object.rotation = e.world_from_object.rotation * exp_so3({0.02, 0, 0});
      e.semi_axes_m += Eigen::Vector3d(0.03, 0, 0.04);
      state.covariance_diagonal << 0.0036, 0.0064, 0, 1e-4, 1e-4, 1e-4, 1e-4, 4e-4, 4e-4;
    }
    for (ObjectState& state : tracks.objects[1].states) state.covariance_diagonal[4] = 1;  // y alone
  });
  const json objects = run()["objects"], &cuboid = objects[0]["consistency"];
  EXPECT_NEAR(cuboid["translation"]["rmse"].get<double>(), std::sqrt(3.0), 1e-6);
  EXPECT_NEAR(cuboid["rotation"]["rmse"].get<double>(), 2.0 / 3, 1e-6);
  EXPECT_NEAR(cuboid["semi_axes"]["rmse"].get<double>(), 0.5, 1e-6);
  EXPECT_EQ(cuboid["translation"]["n"], kFrames);
  EXPECT_EQ(objects[1]["consistency"]["translation"], objects[2]["consistency"]["rotation"]);
  EXPECT_TRUE(objects[1]["consistency"]["translation"].is_null());
  std::vector<std::string> last;  // of the header and of each row
  for_each_line(
      root_ / "out/frames.csv", [&](int, const auto& fields) { last.emplace_back(fields.back()); }, ',');
  EXPECT_EQ(last[0], "sigma_semi_axes_m");
  EXPECT_NEAR(std::stod(last[1]), 0.1, 1e-9);
}

}  // namespace
}  // namespace uniquadric
