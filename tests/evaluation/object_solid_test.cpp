// The estimated bodies against the true ones, through the whole of evaluate.
#include <numbers>

#include "core/sequence/ply.h"
#include "tests/evaluation/evaluate_fixture.h"
#include "tests/evaluation/solid_meshes.h"

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

TEST_F(ObjectSolid, IsEmptyWithoutATrueBody) {
  std::vector<ObjectDescription> objects = kObjects;
  for (ObjectDescription& object : objects) object.shape = "mesh";
  write_objects_yaml(truth() / "objects.yaml", objects);
  write_changed([](Tracks&) {});
  EXPECT_TRUE(run()["objects"][0]["iou3d_solid"].is_null());
}

}  // namespace
}  // namespace uniquadric
