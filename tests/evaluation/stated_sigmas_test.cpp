// What is stated of the states' errors, against the errors.
#include <cmath>

#include "core/base/text.h"
#include "tests/evaluation/evaluate_fixture.h"

namespace uniquadric {
namespace {

// By hand, along each axis: the centre is off by 0.03 m along one, against sigmas of 0.01; the turn by 0.02
// rad about the first against 0.01, and nothing about the others, of which one is not known at all; the axes
// by 0.03, 0, 0.04 against 0.06, 0.08, 0.05.
TEST_F(Evaluate, ErrorsAreHeldAgainstTheSigmasThatAreStated) {
  write_changed([](Tracks& tracks) {
    for (ObjectState& state : tracks.objects[0].states) {
      Ellipsoid& e = state.ellipsoid;
      e.world_from_object.translation += Eigen::Vector3d(0, 0.03, 0);
      e.world_from_object.rotation = e.world_from_object.rotation * exp_so3({0.02, 0, 0});
      e.semi_axes_m += Eigen::Vector3d(0.03, 0, 0.04);
      state.covariance_diagonal << 0.0036, 0.0064, 0.0025, 1e-4, 1e-4, 1e-4, 1e-4, 4e-4, 9;
    }
    for (ObjectState& state : tracks.objects[1].states) state.covariance_diagonal[4] = 1;  // y alone
  });
  const json objects = run()["objects"], &cuboid = objects[0]["consistency"];
  EXPECT_NEAR(cuboid["translation"]["rmse"].get<double>(), std::sqrt(3.0), 1e-6);
  EXPECT_NEAR(cuboid["rotation"]["rmse"].get<double>(), 2 / std::sqrt(3.0), 1e-6);
  EXPECT_NEAR(cuboid["semi_axes"]["rmse"].get<double>(), std::sqrt((0.25 + 0.64) / 3), 1e-6);
  EXPECT_EQ(cuboid["translation"]["n"], kFrames);
  EXPECT_EQ(objects[1]["consistency"]["translation"], objects[2]["consistency"]["rotation"]);
  EXPECT_TRUE(objects[1]["consistency"]["translation"].is_null());
  std::vector<std::string> last;  // of the header and of each row
  for_each_line(
      root_ / "out/frames.csv", [&](int, const auto& fields) { last.emplace_back(fields.back()); }, ',');
  EXPECT_EQ(last[0], "sigma_semi_axes_m");
  EXPECT_NEAR(std::stod(last[1]), std::sqrt(0.0125), 1e-9);
}

// Sigmas go by the names that the estimate gave its axes, of whichever of them it speaks.
TEST_F(Evaluate, SigmasFollowTheirAxesWhateverTheirNames) {
  const auto rotation_and_size = [&](bool renamed) {
    write_changed([&](Tracks& tracks) {
      for (ObjectState& state : tracks.objects[0].states) {
        Ellipsoid& e = state.ellipsoid;
        e.world_from_object.translation += e.world_from_object.rotation * Eigen::Vector3d(0.03, 0.01, 0);
        e.world_from_object.rotation = e.world_from_object.rotation * exp_so3({0.02, 0.01, 0});
        e.semi_axes_m += Eigen::Vector3d(0.003, 0.001, 0.002);
        state.covariance_diagonal << 1e-4, 2e-4, 3e-4, 4e-4, 5e-4, 6e-4, 7e-4, 8e-4, 9e-4;
        if (!renamed) continue;  // x, y, z become y, z, x of old
        Eigen::Matrix3d old_from_new;
        old_from_new << 0, 0, 1, 1, 0, 0, 0, 1, 0;
        e.world_from_object.rotation = e.world_from_object.rotation * Eigen::Quaterniond(old_from_new);
        e.semi_axes_m = old_from_new.transpose() * e.semi_axes_m;
        for (int part = 0; part < 9; part += 3)
          state.covariance_diagonal.segment<3>(part) =
              (old_from_new.transpose() * state.covariance_diagonal.segment<3>(part)).eval();
      }
    });
    const json c = run()["objects"][0]["consistency"];
    return Eigen::Vector3d(c["translation"]["rmse"], c["rotation"]["rmse"], c["semi_axes"]["rmse"]);
  };
  const Eigen::Vector3d named = rotation_and_size(false);
  EXPECT_NEAR(named[1], std::sqrt((4 / 7. + 1 / 8.) / 3), 1e-3);
  EXPECT_TRUE(rotation_and_size(true).isApprox(named, 1e-6));
}

}  // namespace
}  // namespace uniquadric
