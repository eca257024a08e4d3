// The estimated bodies against the true ones, through the whole of evaluate.
#include <numbers>

#include "core/sequence/ply.h"
#include "tests/evaluation/evaluate_fixture.h"
#include "tests/evaluation/solid_meshes.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
using std::numbers::pi;

class ObjectSolid : public Evaluate {
 protected:
  void write_mesh(int id, const Eigen::Vector3f& half) {
    const TestMesh mesh = box_mesh({0, 0, 0}, half);
    write_surface_ply(truth() / "objects" / (std::to_string(id) + ".ply"), {mesh.corners, {}, mesh.triangles},
                      "");
  }
};

TEST_F(ObjectSolid, OfBoxesAndBallsIsExact) {
  write_changed([](Tracks& tracks) {
    for (ObjectState& state : tracks.objects[0].states) state.exponents = {1, 1, 1};
  });
  const json objects = run()["objects"];
  EXPECT_NEAR(objects[0]["iou3d_solid"]["mean"], 1, 1e-9);
  EXPECT_EQ(objects[0]["iou3d_solid"]["truth_solid"], "box");
  EXPECT_EQ(objects[0]["iou3d_solid"]["n"], kFrames);
  EXPECT_EQ(objects[2]["iou3d_solid"]["truth_solid"], "ellipsoid");
  EXPECT_NEAR(objects[2]["iou3d_solid"]["mean"], 1, 1e-9);
}

// The ellipsoids are the same, the bodies are not.
TEST_F(ObjectSolid, OfAnEllipsoidInItsBoxIsNotOne) {
  write_changed([](Tracks&) {});
  const json cube = run()["objects"][1];
  EXPECT_NEAR(cube["iou3d"]["mean"], 1, 1e-9);
  const double error = cube["iou3d_solid"]["stderr"];
  EXPECT_LT(error, 0.002);
  EXPECT_NEAR(cube["iou3d_solid"]["mean"], pi / 6, 4 * error);
}

TEST_F(ObjectSolid, TakesTheMeshBeforeTheShape) {
  write_mesh(2, {0.2F, 0.2F, 0.1F});  // half of the cube that objects.yaml says
  write_changed([](Tracks& tracks) {
    for (ObjectState& state : tracks.objects[1].states) state.exponents = {1, 1, 1};
  });
  const json cube = run()["objects"][1]["iou3d_solid"];
  EXPECT_EQ(cube["truth_solid"], "closed");
  EXPECT_NEAR(cube["mean"], 0.5, 1e-5);
}

// Half a cube, whatever the states' shapes are.
TEST_F(ObjectSolid, TakesTheEstimatesMesh) {
  write_changed([](Tracks&) {});
  const TestMesh half = box_mesh({0, 0, 0.1F}, {0.2F, 0.2F, 0.1F});
  fs::create_directories(estimate() / "solids");
  write_surface_ply(estimate() / "solids/20.ply", {half.corners, {}, half.triangles}, "");
  const json cube = run()["objects"][1];
  const double error = cube["iou3d_solid"]["stderr"];
  EXPECT_LT(error, 0.002);
  EXPECT_NEAR(cube["iou3d_solid"]["mean"], 0.5, 4 * error + 0.001);
  EXPECT_EQ(cube["iou3d_solid"]["estimate_solid"], "closed");
  // half the points of the truth and three quarters of the estimate's are on the other's surface
  EXPECT_NEAR(cube["surface_f1"]["mean"], 2 * 0.5 * 0.75 / 1.25, 0.05);
  EXPECT_EQ(run()["objects"][0]["iou3d_solid"]["estimate_solid"], "states");
}

TEST_F(ObjectSolid, RefusesMeshesThatAreNoBodies) {
  write_changed([](Tracks&) {});
  fs::create_directories(estimate() / "solids");
  const auto refusal = [&](const char* name, const SurfaceFile& mesh) {
    write_surface_ply(estimate() / "solids" / name, mesh, "");
    const std::string error = input_error([&] { run(); });
    fs::remove(estimate() / "solids" / name);
    return error.substr(error.find("solids/"));
  };
  const SurfaceFile flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {{0, 1, 2}}};
  EXPECT_EQ(refusal("20.ply", {{{0, 0, 0}}, {}}), "solids/20.ply: has no faces: a body is a mesh");
  EXPECT_EQ(refusal("20.ply", flat), "solids/20.ply: encloses no volume");
  EXPECT_EQ(refusal("77.ply", flat), "solids/77.ply: is no mesh (ID.ply) of an object of the estimate");
}

TEST_F(ObjectSolid, SurfacesOfTheSameBodyAreOne) {
  write_changed([](Tracks& tracks) {
    for (ObjectState& state : tracks.objects[0].states) state.exponents = {1, 1, 1};
  });
  const json objects = run()["objects"];
  for (const int i : {0, 2}) {
    EXPECT_EQ(objects[i]["surface_f1"]["mean"], 1) << i;
    EXPECT_EQ(objects[i]["surface_f1"]["n"], kFrames) << i;
    EXPECT_EQ(objects[i]["surface_f1"]["within_m"], 0.01) << i;
    EXPECT_NEAR(objects[i]["chamfer_m"]["mean"], 0, 1e-6) << i;
  }
}

// A box of 4 x 2 x 2 m whose estimate becomes 6 cm higher halfway.
TEST_F(ObjectSolid, SurfacesFollowTheMeshAndEachFramesShape) {
  const TestMesh box = box_mesh({0, 0, 0}, {2, 1, 1});
  write_surface_ply(truth() / "objects/1.ply", {box.corners, {}, box.triangles}, "");
  write_changed([](Tracks& tracks) {
    auto& states = tracks.objects[0].states;
    for (std::size_t k = 0; k < states.size(); ++k) {
      states[k].exponents = {1, 1, 1};
      states[k].ellipsoid.semi_axes_m =
          k < kFrames / 2 ? Eigen::Vector3d(2, 1, 1) : Eigen::Vector3d(2, 1, 1.03);
    }
  });
  const json cuboid = run()["objects"][0];
  EXPECT_EQ(cuboid["surface_f1"]["within_m"], 0.04);  // of 4 m
  EXPECT_EQ(cuboid["surface_f1"]["mean"], 1);
  EXPECT_NEAR(cuboid["chamfer_m"]["min"], 0, 1e-6);
  // top and bottom, 16 of 40 m^2, are 0.03 m off
  EXPECT_NEAR(cuboid["chamfer_m"]["max"], 0.03 * 16 / 40, 0.001);
}

TEST_F(ObjectSolid, IsEmptyWithoutATrueBody) {
  std::vector<ObjectDescription> objects = kObjects;
  for (ObjectDescription& object : objects) object.shape = "mesh";
  write_objects_yaml(truth() / "objects.yaml", objects);
  write_changed([](Tracks&) {});
  const json cuboid = run()["objects"][0];
  for (const char* figure : {"iou3d_solid", "surface_f1", "chamfer_m"})
    EXPECT_TRUE(cuboid[figure].is_null()) << figure;
}

}  // namespace
}  // namespace uniquadric
