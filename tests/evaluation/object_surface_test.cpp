// The points that an estimate keeps of its objects and of their surroundings, through the whole of evaluate.
#include <octomap/OcTree.h>

#include <sstream>

#include "core/base/error.h"
#include "core/sequence/ply.h"
#include "evaluation/metrics/surface_error.h"
#include "tests/evaluation/evaluate_fixture.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

// A tetrahedron about the origin: no symmetry that would hide a wrong frame.
SurfaceFile tetrahedron() {
  return {{{-0.3F, -0.2F, -0.1F}, {0.3F, -0.2F, -0.1F}, {-0.3F, 0.2F, -0.1F}, {-0.1F, 0, 0.1F}},
          {},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

// The estimate's frame of the first object is another than the true one.
const Pose kTruthFromBody{exp_so3({0.4, -1.2, 2.1}), Eigen::Vector3d(0.06, -0.03, 0.02)};

class ObjectSurface : public Evaluate {
 protected:
  // 20 mm outside of the tetrahedron's underside, whose normal is -z: 20 mm off.
  void write_points() {
    SurfaceFile points;
    for (const Eigen::Vector3d& p : sample_surface({tetrahedron().points, {}, {{0, 2, 1}}}, 500))
      points.points.push_back((kTruthFromBody.inverse() * (p - Eigen::Vector3d(0, 0, 0.02))).cast<float>());
    write_surface_ply(estimate() / "objects/10.ply", points, "");
  }
};

TEST_F(ObjectSurface, IsJudgedInTheFrameThatThePosesUsuallyHave) {
  write_surface_ply(truth() / "objects/1.ply", tetrahedron(), "");
  write_changed([](Tracks& tracks) {
    for (ObjectState& state : tracks.objects[0].states) {
      Pose& pose = state.ellipsoid.world_from_object;
      pose = pose * kTruthFromBody;
      if (state.frame % 3 == 0) pose = pose * Pose{exp_so3({0, 0, 1.5}), Eigen::Vector3d(0.1, 0.1, 0)};
    }
  });
  write_points();
  const json object = run()["objects"][0];
  const json& surface = object["surface"];
  constexpr double kMedianOfPoses = 1e-4;  // [m] of Weiszfeld's iteration, a third of the frames far off
  EXPECT_GT(object["ape"]["translation_m"]["max"], 0.05);
  EXPECT_NEAR(surface["error_m"]["median"], 0.02, kMedianOfPoses);
  EXPECT_NEAR(surface["error_m"]["quantile_90"], 0.02, kMedianOfPoses);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(surface["points_from_truth"]["position_m"][k], kTruthFromBody.inverse().translation[k],
                kMedianOfPoses);
  EXPECT_EQ(surface["error_m"]["n"], 500);
  EXPECT_NEAR(surface["within_m"], 0.05 * std::sqrt(0.36 + 0.16 + 0.04), 1e-7);
  EXPECT_GT(surface["completeness"], 0.3);  // the underside and the lower parts of the others
  EXPECT_LT(surface["completeness"], 0.7);
}

TEST_F(ObjectSurface, OfABoxNeedsNoMesh) {
  write_changed([](Tracks&) {});
  SurfaceFile points;  // along y, that has 0.2 m each way
  for (const float y : {0.F, 0.1F, 0.21F, 0.25F}) points.points.emplace_back(0.F, y, 0.F);
  for (const char* file : {"objects/10.ply", "objects/20.ply", "objects/30.ply"})
    write_surface_ply(estimate() / file, points, "");
  const json objects = run()["objects"];
  EXPECT_NEAR(objects[0]["surface"]["error_m"]["max"], 0.1, 1e-6);  // z has 0.1 m
  EXPECT_NEAR(objects[1]["surface"]["error_m"]["max"], 0.2, 1e-6);
  EXPECT_NEAR(objects[1]["surface"]["error_m"]["min"], 0.01, 1e-6);
  EXPECT_TRUE(objects[2]["surface"].is_null());  // a ball, of which the truth has no mesh
}

TEST_F(ObjectSurface, OfTheTruthItselfIsComplete) {
  write_surface_ply(truth() / "objects/1.ply", tetrahedron(), "");
  const json objects = run(truth(), truth())["objects"];
  EXPECT_LT(objects[0]["surface"]["error_m"]["max"], 1e-7);
  EXPECT_EQ(objects[0]["surface"]["completeness"], 1);
  EXPECT_TRUE(objects[1]["surface"].is_null());
}

// A floor of 4 x 4 m in the truth; the estimate, in a world of its own, has half of it and something above.
TEST_F(ObjectSurface, TheMapIsComparedInTheTruthsWorld) {
  octomap::OcTree floor(0.25);
  for (int x = 0; x < 16; ++x)
    for (int y = 0; y < 16; ++y)
      floor.setNodeValue(octomap::point3d(0.125F + 0.25F * float(x), 0.125F + 0.25F * float(y), 0.1F), 3.F);
  floor.toMaxLikelihood();
  std::ostringstream bytes;
  bytes << "# Octomap OcTree binary file\nid OcTree\nsize " << floor.size() << "\nres 0.25\ndata\n";
  floor.writeBinaryData(bytes);
  write_text(truth() / "map.bt", bytes.str());
  const Pose other{exp_so3({0.2, -0.3, 1}), Eigen::Vector3d(3, -2, 1)};  // estimate_from_truth
  write_changed([&](Tracks& tracks) {
    for (StampedPose& pose : tracks.camera) pose.pose = other * pose.pose;
    tracks.objects.clear();
  });
  EXPECT_TRUE(run()["map"].is_null());
  SurfaceFile map;
  const auto add = [&](double x, double y, double z) {
    map.points.push_back((other * Eigen::Vector3d(x, y, z)).cast<float>());
  };
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 16; ++y) add(0.1 + 0.25 * x, 0.2 + 0.25 * y, 0.15);
  for (int y = 0; y < 16; ++y) add(0.1, 0.2 + 0.25 * y, 1.1);
  write_surface_ply(estimate() / "map.ply", map, "");
  const json found = run()["map"];
  EXPECT_EQ(found["resolution_m"], 0.25);
  EXPECT_EQ(found["true_occupied_voxels"], 256);
  EXPECT_EQ(found["both_occupied_voxels"], 128);
  EXPECT_EQ(found["precision"], 128 / 144.);
  EXPECT_EQ(found["completeness"], 9 / 16.);
  EXPECT_FALSE(found.contains("program"));
}

TEST_F(ObjectSurface, FilesThatAreNoneAreRefused) {
  write_changed([](Tracks&) {});
  write_text(estimate() / "objects/10.ply", "ply\nformat text 1.0\nend_header\n");
  EXPECT_NE(input_error([&] { run(); }).find("objects/10.ply:2: expected format"), std::string::npos);
  write_points();
  SurfaceFile cloud = tetrahedron();
  cloud.triangles.clear();
  write_surface_ply(truth() / "objects/1.ply", cloud, "");
  EXPECT_NE(input_error([&] { run(); }).find("objects/1.ply: has no faces"), std::string::npos);
  EXPECT_FALSE(fs::exists(root_ / "out"));
}

}  // namespace
}  // namespace uniquadric
