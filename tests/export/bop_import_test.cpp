#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/import/bop.h"
#include "core/sequence/calibration.h"
#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kPoseTolerance = 1e-9;  // [m, rad] rounding of rotations and millimetres

class BopImport : public Export {
 protected:
  BopImport() {
    options.quiet = true;
    options.rate_hz = 10;
  }
  void import() { import_bop(scene, options, folder() / "imported"); }
  Sequence imported() const { return open_sequence(folder() / "imported/sequence"); }
  std::string refusal() {
    std::string message = input_error([&] { import(); });
    EXPECT_FALSE(fs::exists(folder() / "imported"));
    return message;
  }
  void change(const char* file, const std::function<void(json&)>& edit) const {
    json value = json::parse(read_text(scene / file));
    edit(value);
    write_text(scene / file, value.dump());
  }

  ImportBopOptions options;
  fs::path out = run("bop"), scene = out / "test/000000", truth = folder() / "imported/truth";
};

TEST_F(BopImport, GivesTheExportedSequence) {
  import();
  const Sequence sequence = imported();
  ASSERT_EQ(sequence.frames.size(), sequence_.frames.size());
  EXPECT_EQ(sequence.camera.matrix(), sequence_.camera.matrix());
  EXPECT_EQ(sequence.camera.width, 160);
  EXPECT_EQ(sequence.camera.height, 120);
  EXPECT_DOUBLE_EQ(sequence.depth_units_per_m, sequence_.depth_units_per_m);
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const SequenceFrame &got = sequence.frames[i], &expected = sequence_.frames[i];
    EXPECT_EQ(got.stamp_ns, expected.stamp_ns);
    EXPECT_EQ(cv::norm(read_rgb(sequence, got), read_rgb(sequence_, expected)), 0);
    EXPECT_EQ(cv::norm(read_depth(sequence, got), read_depth(sequence_, expected)), 0);
    EXPECT_EQ(cv::norm(read_masks(sequence, got), instances(static_cast<int>(i))), 0);
    EXPECT_EQ(got.masks_arrival_ns, got.stamp_ns);
  }
}

TEST_F(BopImport, GivesTheExportedTruth) {
  import();
  const Tracks tracks = read_tracks(truth);
  ASSERT_EQ(tracks.camera.size(), truth_.camera.size());
  ASSERT_EQ(tracks.objects.size(), 2u);
  for (std::size_t i = 0; i < tracks.camera.size(); ++i)
    EXPECT_LT((tracks.camera[i].pose.matrix() - truth_.camera[i].pose.matrix()).norm(), kPoseTolerance);
  for (std::size_t k = 0; k < 2; ++k) {
    ASSERT_EQ(tracks.objects[k].states.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
      const Ellipsoid &got = tracks.objects[k].states[i].ellipsoid,
                      &expected = truth_.objects[k].states[i].ellipsoid;
      EXPECT_LT((got.world_from_object.matrix() - expected.world_from_object.matrix()).norm(),
                kPoseTolerance);
      EXPECT_LT((got.semi_axes_m - expected.semi_axes_m).norm(), kPoseTolerance);
    }
  }
}

TEST_F(BopImport, MovesTheFrameToTheCentreOfTheModelsBox) {
  const Eigen::Vector3d offset_mm(30, -40, 50);  // of the model's origin from its box's centre
  const fs::path models = out / "models";
  json info = json::parse(read_text(models / "models_info.json"));
  info["1"]["min_x"] = -200 - 30, info["1"]["min_y"] = -150 + 40, info["1"]["min_z"] = -100 - 50;
  write_text(models / "models_info.json", info.dump());
  change("scene_gt.json", [&](json& images) {
    for (auto& [number, list] : images.items()) {
      const auto R = list[0]["cam_R_m2c"].get<std::vector<double>>();
      auto t = list[0]["cam_t_m2c"].get<std::vector<double>>();
      for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t k = 0; k < 3; ++k) t[row] += R[3 * row + k] * offset_mm[static_cast<int>(k)];
      list[0]["cam_t_m2c"] = t;
    }
  });
  write_text(models / "obj_000001.ply",
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
             "-30 40 -50\n170 40 -50\n-30 190 -50\n3 0 1 2\n");
  import();
  const Tracks tracks = read_tracks(truth);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT((tracks.objects[0].states[i].ellipsoid.world_from_object.matrix() -
               truth_of(kBox, static_cast<int>(i)).ellipsoid.world_from_object.matrix())
                  .norm(),
              1e-7);  // min_x is written to single precision
  const SurfaceFile mesh = read_surface_ply(truth / "objects/1.ply");
  ASSERT_EQ(mesh.points.size(), 3u);
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_LT(mesh.points[0].norm(), 1e-6F);  // the centre, and half an extent off it
  EXPECT_LT((mesh.points[1] - Eigen::Vector3f(0.2F, 0, 0)).norm(), 1e-6F);
  EXPECT_LT((mesh.points[2] - Eigen::Vector3f(0, 0.15F, 0)).norm(), 1e-6F);
  EXPECT_FALSE(fs::exists(truth / "objects/2.ply"));
  EXPECT_EQ(read_objects_yaml(truth / "objects.yaml").at(0).mesh, "obj_000001.ply");
}

TEST_F(BopImport, WithoutWorldPosesObjectsAreInTheCamerasFrame) {
  change("scene_camera.json", [](json& images) {
    for (auto& [number, image] : images.items()) image.erase("cam_R_w2c");
  });
  import();
  EXPECT_FALSE(imported().given_camera);
  EXPECT_TRUE(read_truth_notes(truth / "objects.yaml").in_sensor_frame);
  EXPECT_FALSE(read_truth_notes(truth / "objects.yaml").is_partial);
  const Tracks tracks = read_tracks(truth);
  for (std::size_t i = 0; i < 4; ++i) {
    const Pose expected =
        truth_.camera[i].pose.inverse() * truth_of(kBall, static_cast<int>(i)).ellipsoid.world_from_object;
    EXPECT_LT((tracks.objects[1].states[i].ellipsoid.world_from_object.matrix() - expected.matrix()).norm(),
              kPoseTolerance);
  }
}

// The second object of a model gets an id of its own, in poses and masks.
TEST_F(BopImport, ObjectsOfOneModelHaveIdsOfTheirOwn) {
  change("scene_gt.json", [](json& images) {
    for (auto& [number, list] : images.items())
      for (json& object : list) object["obj_id"] = 2;
  });
  import();
  const Tracks tracks = read_tracks(truth);
  ASSERT_EQ(tracks.objects.size(), 2u);
  EXPECT_EQ(tracks.objects[0].id, 2);
  EXPECT_EQ(tracks.objects[1].id, 1002);
  EXPECT_LT((tracks.objects[1].states[0].ellipsoid.world_from_object.translation -
             truth_of(kBall, 0).ellipsoid.world_from_object.translation)
                .norm(),
            kPoseTolerance);
  const Sequence sequence = imported();
  const cv::Mat masks = read_masks(sequence, sequence.frames[0]);
  EXPECT_EQ(cv::norm(masks == 1002, instances(0) == kBall), 0);
  EXPECT_EQ(cv::norm(masks == 2, instances(0) == kBox), 0);
}

TEST_F(BopImport, StampsAreImageNumbersOverTheRate) {
  for (const char* file : {"scene_camera.json", "scene_gt.json"})
    change(file, [](json& images) {
      images["100"] = images["3"];
      images.erase("1");
      images.erase("3");
    });
  fs::rename(scene / "rgb/000003.png", scene / "rgb/000100.png");
  for (const char* object : {"000000", "000001"})
    fs::rename(scene / fmt::format("mask_visib/000003_{}.png", object),
               scene / fmt::format("mask_visib/000100_{}.png", object));
  options.rate_hz = 25;
  import();
  EXPECT_EQ(stamps_of(imported().frames), (std::vector<std::int64_t>{0, 80'000'000, 4'000'000'000}));
  EXPECT_TRUE(imported().frames[2].depth.empty());
}

TEST_F(BopImport, WithoutModelsTheTruthIsTheCamerasAlone) {
  fs::remove_all(out / "models");
  import();
  EXPECT_TRUE(read_objects_yaml(truth / "objects.yaml").empty());
  EXPECT_EQ(read_tum(truth / "camera.tum").size(), 4u);
}

TEST_F(BopImport, BadScenesAreRefused) {
  const std::string cameras = read_text(scene / "scene_camera.json"),
                    objects = read_text(scene / "scene_gt.json");
  const auto expect = [&](const std::string& what) {
    const std::string message = refusal();
    EXPECT_NE(message.find(what), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    write_text(scene / "scene_camera.json", cameras);
    write_text(scene / "scene_gt.json", objects);
  };
  change("scene_camera.json", [](json& images) { images["2"]["cam_K"][0] = 131; });
  expect("scene_camera.json: image 2: the intrinsics change");
  change("scene_camera.json", [](json& images) { images["2"]["depth_scale"] = 0.5; });
  expect("scene_camera.json: image 2: depth_scale changes");
  change("scene_camera.json", [](json& images) { images["2"]["cam_K"] = {130, 0, 79.5}; });
  expect("scene_camera.json: image 2: cam_K: expected 9 numbers");
  change("scene_camera.json", [](json& images) { images["x"] = images["2"]; });
  expect("scene_camera.json: 'x' is no image number");
  change("scene_camera.json", [](json& images) { images["7"] = images["2"]; });
  expect("rgb/000007.png: is missing");
  change("scene_gt.json", [](json& images) { images["7"] = images["2"]; });
  expect("scene_gt.json: image 7 does not stand in scene_camera.json");
  change("scene_gt.json", [](json& images) { images["1"][0]["cam_R_m2c"][0] = 3; });
  expect("scene_gt.json: image 1: cam_R_m2c is no rotation");
  change("scene_gt.json", [](json& images) { images["1"][0]["obj_id"] = 0; });
  expect("scene_gt.json: image 1: obj_id: expected");
  write_text(scene / "scene_gt.json", objects.substr(0, 200));
  expect("scene_gt.json: is no JSON");
  options.models = scene;
  expect("has no models_info.json");
  options.models.clear();
  fs::remove(scene / "mask_visib/000002_000001.png");
  expect("mask_visib/000002_000001.png: is missing");
  fs::remove(scene / "scene_camera.json");
  EXPECT_NE(refusal().find("there is no scene_camera.json"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
