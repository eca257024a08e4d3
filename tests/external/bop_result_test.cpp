#include "core/import/bop_result.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr const char* kModels =
    R"({"2": {"diameter": 500, "min_x": -100, "min_y": -100, "min_z": 0, "size_x": 200, "size_y": 200, "size_z": 400}})";
constexpr const char* kHeader = "scene_id,im_id,obj_id,score,R,t,time\n";

class BopResult : public testing::Test {
 protected:
  BopResult() {
    for (int i = 0; i < 3; ++i) {
      sequence_.frames.emplace_back().frame = i;
      sequence_.frames.back().stamp_ns = i * 100'000'000;
    }
  }
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder() / name).parent_path());
    write_text(folder() / name, text);
  }
  std::string refusal_of(const std::string& rows) const {
    write("mine.csv", kHeader + rows);
    return input_error([&] { read_bop_result(folder(), sequence_); });
  }
  fs::path folder() const { return temp_.path() / "mine"; }
  const TempFolder temp_;
  Sequence sequence_;
};

// A quarter turn about z and a model whose origin is its foot: the best of two instances.
TEST_F(BopResult, RowsAreModelsInTheCameraInMillimetres) {
  write("mine.csv", std::string(kHeader) +
                        "5,1,2,0.4,1 0 0 0 1 0 0 0 1,9 9 9,-1\n"
                        "5,1,2,0.8,0 -1 0 1 0 0 0 0 1,100 200 3000,0.1\n"
                        "5,2,2,0.8,1 0 0 0 0 -1 0 1 0,0 0 1000,0.1\n");
  write("models_info.json", kModels);
  write("scene_camera.json",
        R"({"1": {"cam_K": [1,0,0,0,1,0,0,0,1], "cam_R_w2c": [1,0,0,0,1,0,0,0,1], "cam_t_w2c": [0,0,500]},
            "2": {"cam_R_w2c": [1,0,0,0,1,0,0,0,1], "cam_t_w2c": [0,0,0]}})");
  const Tracks tracks = read_bop_result(folder(), sequence_);
  EXPECT_EQ(tracks.camera.size(), 2u);
  ASSERT_EQ(tracks.objects.size(), 1u);
  const auto& states = tracks.objects[0].states;
  ASSERT_EQ(states.size(), 2u);
  EXPECT_EQ(states[0].frame, 1);
  EXPECT_EQ(states[0].exponents, (SuperExponents{1, 1, 1}));
  EXPECT_TRUE(states[0].ellipsoid.semi_axes_m.isApprox(Eigen::Vector3d(0.1, 0.1, 0.2)));
  const Pose& first = states[0].ellipsoid.world_from_object;
  EXPECT_TRUE(first.translation.isApprox(Eigen::Vector3d(0.1, 0.2, 3.0 + 0.2 - 0.5)));
  EXPECT_TRUE((first.rotation * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
  // model z is camera -y
  EXPECT_TRUE(states[1].ellipsoid.world_from_object.translation.isApprox(Eigen::Vector3d(0, -0.2, 1)));
}

TEST_F(BopResult, SizesMayStandInObjectsYaml) {
  write("mine.csv", "0,0,7,1,1 0 0 0 1 0 0 0 1,0 0 1000,-1\n");
  write("objects.yaml", "7: {semi_axes_m: [0.1, 0.2, 0.3]}\n");
  const Tracks tracks = read_bop_result(folder() / "mine.csv", sequence_);
  EXPECT_EQ(tracks.objects.at(0).states.at(0).ellipsoid.semi_axes_m, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(tracks.objects[0].states[0].exponents, SuperExponents());
}

TEST_F(BopResult, SaysWhatIsWrong) {
  EXPECT_NE(refusal_of("").find("has no sizes"), std::string::npos);
  write("models_info.json", kModels);
  const std::string pose = "1 0 0 0 1 0 0 0 1,0 0 1000,-1\n";
  EXPECT_NE(refusal_of("0,3,2,1," + pose).find("mine.csv:2: im_id '3' is no whole number from 0 to 2"),
            std::string::npos);
  EXPECT_NE(refusal_of("0,1,4,1," + pose).find("mine.csv:2: obj_id 4 has no size"), std::string::npos);
  EXPECT_NE(refusal_of("0,1,2,1,1 0 0 0 1 0 0 0,0 0 1000,-1\n").find("R: expected 9 numbers, found 8"),
            std::string::npos);
  EXPECT_NE(refusal_of("0,1,2,1,1 0 0 0 1 0 0 0 2,0 0 1000,-1\n").find("is no rotation"), std::string::npos);
  EXPECT_NE(refusal_of("0,1,2,1," + pose + "1,1,2,1," + pose).find("mine.csv:3: scene_id 1 after 0"),
            std::string::npos);
}

// scene_gt.json of an export, as rows of a result, is the truth again.
TEST_F(BopResult, OfAnExportIsTheTruth) {
  const fs::path data = temp_.path() / "data", exported = temp_.path() / "bop", out = temp_.path() / "out";
  write("small.yaml", small_scene_yaml());
  ASSERT_EQ(run_program({"simulate", folder() / "small.yaml", data, "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_program({"export", "bop", data / "sequence", exported, "--quiet"}).exit_code, 0);
  const fs::path scene = exported / "test/000000";
  std::string rows = kHeader;
  const auto truths = nlohmann::json::parse(read_text(scene / "scene_gt.json"));
  for (const auto& [image, poses] : truths.items())
    for (const auto& pose : poses)
      rows += fmt::format("0,{},{},1,{},{},-1\n", image, pose["obj_id"].get<int>(),
                          fmt::join(pose["cam_R_m2c"].get<std::vector<double>>(), " "),
                          fmt::join(pose["cam_t_m2c"].get<std::vector<double>>(), " "));
  write("result/mine.csv", rows);
  fs::copy(exported / "models", folder() / "result/models", fs::copy_options::recursive);
  fs::copy(scene / "scene_camera.json", folder() / "result");
  const ProgramRun run =
      run_program({"convert-result", "bop", folder() / "result", out, "--sequence", data / "sequence"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const Tracks truth = read_tracks(data / "truth"), result = read_tracks(out);
  ASSERT_EQ(result.objects.size(), 2u);
  EXPECT_EQ(result.camera.size(), truth.camera.size());
  for (const ObjectTrack& track : result.objects)
    for (const ObjectState& state : track.states) {
      const Ellipsoid& expected = truth.objects.at(track.id - 1).states.at(state.frame).ellipsoid;
      EXPECT_LT((state.ellipsoid.semi_axes_m - expected.semi_axes_m).norm(), 1e-9);
      EXPECT_LT(log_se3(expected.world_from_object.inverse() * state.ellipsoid.world_from_object).norm(),
                1e-7);
    }
}

}  // namespace
}  // namespace uniquadric
