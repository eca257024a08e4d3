// Every option of `uniquadric trajectory` through the program.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "core/base/files.h"
#include "core/sequence/trajectory.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
using nlohmann::json;
constexpr double kRounding = 1e-9;  // m or rad
constexpr int kPoses = 300;

// A helix of radius 50 m, a pose every 0.1 s; the estimate twice as small and lifted by 1 m, without every
// tenth pose.
class TrajectoryCommand : public testing::Test {
 protected:
  TrajectoryCommand() {
    Trajectory reference, estimate;
    for (int i = 0; i < kPoses; ++i) {
      const double angle = 0.02 * i;
      const Pose pose = {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
                         {50 * std::cos(angle), 50 * std::sin(angle), 0.1 * i}};
      reference.push_back({i * 100'000'000LL, pose});
      if (i % 10 != 9)
        estimate.push_back({i * 100'000'000LL + 2'000'000,
                            {pose.rotation, 0.5 * pose.translation + Eigen::Vector3d(0, 0, 1)}});
    }
    write_tum(path("ref.tum"), reference);
    write_tum(path("est.tum"), estimate);
  }
  std::string path(const std::string& name) const { return folder_.path() / name; }
  ProgramRun run(std::vector<std::string> options) const {
    options.insert(options.begin(), {"trajectory", path("ref.tum"), path("est.tum")});
    return run_program(options);
  }
  json answer(std::vector<std::string> options) const {
    options.push_back("--json");
    const ProgramRun result = run(options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return json::parse(result.out);
  }

 private:
  TempFolder folder_;
};
}  // namespace

TEST_F(TrajectoryCommand, AnswersInJson) {
  const json c = answer({"--align", "sim3"});
  EXPECT_EQ(c["n_pairs"], 270);
  EXPECT_DOUBLE_EQ(c["coverage"], 0.9);
  EXPECT_NEAR(c["alignment"]["reference_from_estimate"]["scale"], 2, kRounding);
  EXPECT_NEAR(c["alignment"]["reference_from_estimate"]["position_m"][2], -2, kRounding);
  for (const char* relation : {"ape", "rpe"}) {
    for (const char* part : {"translation_m", "rotation_rad"})
      for (const char* figure : {"rmse", "mean", "median", "std", "min", "max", "sse"})
        EXPECT_NEAR(c[relation][part][figure], 0, 1e-7) << relation << part << figure;
    EXPECT_EQ(c[relation].contains("full"), false);
  }
  EXPECT_EQ(c["ape"]["translation_m"]["n"], 270);
  EXPECT_EQ(c["rpe"]["translation_m"]["n"], 269);
  EXPECT_EQ(run({"--json"}).out, run({"--json", "--threads", "1", "--quiet"}).out);
}

TEST_F(TrajectoryCommand, TakesEveryOption) {
  for (const char* align : {"none", "first", "se3", "sim3", "scale", "posyaw", "poses"}) {
    std::vector<std::string> options = {"--align", align, "--relation", "ape"};
    const bool is_fitted = align != std::string("none") && align != std::string("first");
    if (is_fitted) options.insert(options.end(), {"--align-n", "200"});
    const json c = answer(options);
    EXPECT_EQ(c["alignment"]["kind"], align);
    EXPECT_FALSE(c.contains("rpe"));
    const double scale = c["alignment"]["reference_from_estimate"]["scale"];
    EXPECT_NEAR(scale, align == std::string("sim3") || align == std::string("scale") ? 2 : 1, kRounding)
        << align;
  }
  EXPECT_EQ(answer({"--align", "se3", "--align-n", "200"})["alignment"]["n"], 200);
  const json full = answer({"--relation", "rpe", "--part", "full"});
  EXPECT_EQ(full["rpe"].size(), 2u);  // and delta
  EXPECT_FALSE(full.contains("ape"));
  // a chord of the circle is half as long in the estimate, also its rise
  const json metres = answer({"--relation", "rpe", "--part", "translation", "--delta", "10m"});
  EXPECT_NEAR(metres["rpe"]["translation_m"]["mean"], 5, 0.5);
  const json shorter = answer({"--relation", "rpe", "--delta", "10m", "--pairs-from", "est"});
  EXPECT_NEAR(shorter["rpe"]["translation_m"]["mean"], 10, 1);
  EXPECT_EQ(shorter["rpe"]["delta"]["pairs_from"], "est");
  EXPECT_GT(answer({"--delta", "10m", "--all-pairs"})["rpe"]["translation_m"]["n"],
            metres["rpe"]["translation_m"]["n"]);
  EXPECT_EQ(answer({"--delta", "1s"})["rpe"]["delta"]["unit"], "s");
  EXPECT_EQ(answer({"--delta", "10deg"})["rpe"]["delta"]["value"], 10);
  EXPECT_EQ(answer({"--association", "one_to_one", "--max-dt", "0.002"})["n_pairs"], 270);
  EXPECT_EQ(answer({"--max-dt", "0.2"})["n_pairs"], 270);
  const json evo = answer({"--compat", "evo", "--delta", "10m"});
  EXPECT_EQ(evo["rpe"]["delta"]["pairs_from"], "est");
  EXPECT_NEAR(evo["ape"]["rotation_part"]["rmse"], 0, kRounding);
}

TEST_F(TrajectoryCommand, DriftAndKitti) {
  const json c = answer({"--drift", "--kitti"});
  // half as long: at the far side of the circle 2 * 25 m are missing, and half of the rise
  EXPECT_NEAR(c["drift"]["first"]["max_translation_m"], 50, 2);
  EXPECT_NEAR(c["drift"]["first"]["yaw"]["max_deg"], 0, 1e-6);
  EXPECT_GT(c["drift"]["calibrated"]["max_translation_m"], 1);
  EXPECT_EQ(c["drift"]["calibrated"]["alignment"], "calibrated");
  EXPECT_EQ(c["kitti"]["lengths"].size(), 2u);  // the path is 298 m long
  EXPECT_NEAR(c["kitti"]["rotation_deg_per_100m"], 0, 1e-6);
  // the chord of an arc of 100 m
  EXPECT_NEAR(c["kitti"]["lengths"][0]["translation_percent"], 100 * std::sin(1) / 2, 1);
  EXPECT_TRUE(answer({"--align", "scale", "--kitti"})["kitti"].contains("parts"));
}

TEST_F(TrajectoryCommand, TableForPeople) {
  const ProgramRun table = run({"--align", "se3", "--drift", "--kitti"});
  EXPECT_EQ(table.exit_code, 0);
  for (const char* text :
       {"270 (nearest, 0.01 s), coverage 0.9", "alignment  se3 by 270 pairs", "APE transl. [m]",
        "RPE rotation [rad]", "greatest drift, the first poses laid on one another:\n  translation ",
        "greatest drift, calibrated:", "% of the reference's path up to there)", "t_rel [%]"})
    EXPECT_NE(table.out.find(text), std::string::npos) << text;
}

TEST_F(TrajectoryCommand, WritesAPicture) {
  EXPECT_EQ(run({"--plot", path("out.svg")}).exit_code, 0);
  const std::string picture = read_text(path("out.svg"));
  EXPECT_TRUE(picture.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"")) << picture.substr(0, 80);
  for (const char* text :
       {"est.tum against /", "x [m]", "z [m]", "APE translation [m]", "RPE rotation [rad]"})
    EXPECT_NE(picture.find(text), std::string::npos) << text;
  EXPECT_EQ(picture.find("nan"), std::string::npos);
  EXPECT_EQ(run({"--plot", path("out.png")}).exit_code, 0);
  EXPECT_TRUE(read_text(path("out.png")).starts_with("\x89PNG\r\n\x1a\n"));
  expect_refused(run({"--plot", path("out.eps")}), "out.eps' does not end in .svg, .pdf or .png");
  EXPECT_FALSE(std::filesystem::exists(path("out.pdf")));
  const std::string before = read_text(path("ref.tum"));
  expect_refused(run({"--plot", path("ref.tum")}), "ref.tum");
  EXPECT_EQ(read_text(path("ref.tum")), before);
}

TEST_F(TrajectoryCommand, RefusesOptionsWithoutEffect) {
  expect_refused(run({"--align-n", "200"}), "--align-n: --align none is not fitted on poses");
  expect_refused(run({"--align", "first", "--align-n", "200"}),
                 "--align-n: --align first is not fitted on poses");
  for (const std::vector<std::string>& option :
       {std::vector<std::string>{"--delta", "10m"}, {"--all-pairs"}, {"--pairs-from", "est"}}) {
    std::vector<std::string> options = {"--relation", "ape"};
    options.insert(options.end(), option.begin(), option.end());
    expect_refused(run(options), option.front() + " is of RPE's steps: --relation ape has none");
  }
}

TEST_F(TrajectoryCommand, RefusesOfEvoWhatItHasNot) {
  for (const std::string align : {"poses", "posyaw"}) {
    expect_refused(run({"--align", align, "--compat", "evo"}),
                   "--align: evo has no " + align + ", as --compat evo asks for");
    EXPECT_EQ(run({"--align", align}).exit_code, 0);
  }
  expect_refused(run({"--association", "one_to_one", "--compat", "evo"}),
                 "--association: evo has no one_to_one, as --compat evo asks for");
  for (const std::string align : {"none", "first", "se3", "sim3", "scale"})
    EXPECT_EQ(run({"--align", align, "--compat", "evo", "--association", "nearest"}).exit_code, 0) << align;
}

TEST_F(TrajectoryCommand, WarnsOfAnotherUnit) {
  Trajectory millimetres = read_tum(path("ref.tum"));
  for (StampedPose& pose : millimetres) pose.pose.translation *= 1000;
  write_tum(path("est.tum"), millimetres);
  for (const std::string align : {"none", "se3"}) {
    const ProgramRun result = run({"--align", align});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.err.find("est.tum: positions spread over "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("--align sim3"), std::string::npos) << result.err;
  }
  EXPECT_EQ(run({"--align", "sim3"}).err, "");
}

TEST_F(TrajectoryCommand, RefusesBadInputByNameAndLine) {
  expect_refused(run({"--align", "yaw"}), "--align");
  expect_refused(run({"--align-n", "0"}), "--align-n");
  expect_refused(run({"--delta", "10"}), "--delta: '10' is no step such as 1f, 10m, 1s, 10deg");
  expect_refused(run({"--delta", "9km"}), "--delta");
  expect_refused(run({"--delta", "1000m"}),
                 "delta 1000m: no two of the 270 pairs of poses lie that far apart");
  expect_refused(run({"--delta", "1s", "--compat", "evo"}), "evo has no steps in seconds");
  expect_refused(run({"--max-dt", "-1"}), "--max-dt");
  expect_refused(run({"--max-dt", "0.001"}),
                 "est.tum: 0 of 270 poses lie within 0.001 s of the reference's 300, at least 3 are needed");
  write_text(path("est.tum"), read_text(path("ref.tum")) + "29.95 0 0 0 0 0 0 2\n");
  expect_refused(run({}), "est.tum:302: quaternion has norm 2, not 1");
  write_text(path("est.tum"), "1 0 0 0 0 0 0 1\n0.9 0 0 0 0 0 0 1\n");
  expect_refused(run({}), "est.tum:2: timestamp 0.9 comes before 1.000000000");
  write_text(path("est.tum"), "");
  expect_refused(run({}), "est.tum: has no poses");
  std::filesystem::remove(path("est.tum"));
  expect_refused(run({}), "est.tum: cannot be read");
}

}  // namespace uniquadric
