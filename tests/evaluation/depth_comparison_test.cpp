#include "evaluation/metrics/depth_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/sequence.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
using nlohmann::json;
namespace fs = std::filesystem;

class DepthMetric : public testing::Test {
 protected:
  // An image of two rows.
  std::string write(const fs::path& name, const std::vector<std::uint16_t>& pixels) {
    fs::create_directories((temp_.path() / name).parent_path());
    write_png(temp_.path() / name, cv::Mat(pixels, true).reshape(1, 2));
    return temp_.path() / name;
  }
  static DepthOptions in_units(double units_per_m) {
    DepthOptions options;
    options.units_per_m = units_per_m;
    return options;
  }
  void write_sequence_yaml(const char* name, const std::string& text) {
    fs::create_directories(temp_.path() / name);
    write_text(temp_.path() / name / "sequence.yaml", text);
  }
  std::string folder(const char* name) const { return temp_.path() / name; }
  static json compare(const std::string& truth, const std::string& estimate,
                      const DepthOptions& options = in_units(5000)) {
    return json::parse(figures_json(figures(compare_depth(truth, estimate, options))));
  }
  static std::string refusal(const std::string& truth, const std::string& estimate,
                             const DepthOptions& options = in_units(5000)) {
    return input_error([&] { compare_depth(truth, estimate, options); });
  }

  TempFolder temp_;
};

TEST_F(DepthMetric, FiguresOfFourPixels) {
  // 1, 2, 4 and 3 m; the estimate is off by 0.2, 0.5 and -1 m, and has nothing for the last.
  const std::string truth = write("true.png", {5000, 10000, 20000, 15000});
  const std::string estimate = write("estimate.png", {6000, 12500, 15000, 0});
  const json found = compare(truth, estimate);
  EXPECT_EQ(found["true_pixels"], 4);
  EXPECT_EQ(found["n"], 3);
  EXPECT_EQ(found["coverage"], 0.75);
  EXPECT_NEAR(found["rmse_m"], std::sqrt((0.04 + 0.25 + 1) / 3), 1e-12);
  EXPECT_NEAR(found["median_m"], 0.5, 1e-12);
  EXPECT_NEAR(found["absolute_relative_error"], (0.2 + 0.25 + 0.25) / 3, 1e-12);
  EXPECT_NEAR(found["delta_1"], 1 / 3., 1e-12);  // 1.2; just 1.25 and 4/3 are not
  const DepthOptions in_mm = in_units(1000);
  EXPECT_NEAR(compare(truth, estimate, in_mm)["rmse_m"], 5 * found["rmse_m"].get<double>(), 1e-12);
  EXPECT_EQ(compare(truth, estimate, in_mm)["absolute_relative_error"], found["absolute_relative_error"]);
}

TEST_F(DepthMetric, IdentityIsPerfectAndNoMeasurementCounts) {
  const std::string truth = write("true.png", {0, 65535, 1, 65534});
  const json same = compare(truth, truth);
  EXPECT_EQ(same["n"], 2);
  for (const char* key : {"coverage", "delta_1"}) EXPECT_EQ(same[key], 1) << key;
  for (const char* key : {"rmse_m", "median_m", "absolute_relative_error"}) EXPECT_EQ(same[key], 0) << key;
  const json far = compare(truth, write("far.png", {9, 9, 65534, 1}));
  EXPECT_NEAR(far["median_m"], 65533 / 5000., 1e-9);
  EXPECT_EQ(far["n"], 2);
  const json none = compare(truth, write("none.png", {7, 7, 0, 65535}));
  EXPECT_EQ(none["coverage"], 0);
  for (const char* key : {"rmse_m", "median_m", "absolute_relative_error", "delta_1"})
    EXPECT_TRUE(none[key].is_null()) << key;
}

TEST_F(DepthMetric, MedianOfAnEvenNumberIsTheMeanOfTheMiddleTwo) {
  const std::string truth = write("true.png", {5000, 5000, 5000, 5000});
  EXPECT_NEAR(compare(truth, write("estimate.png", {5500, 5000, 4000, 5002}))["median_m"], 0.0502, 1e-12);
}

TEST_F(DepthMetric, FoldersAreOneSampleAndAMissingImageIsNotCovered) {
  write("true/a.png", {5000, 5000, 0, 0});
  write("true/b.png", {5000, 5000, 5000, 0});
  write("true/c.png", {5000, 5000, 5000, 0});
  write("estimate/a.png", {10000, 5000, 5000, 5000});
  write("estimate/b.png", {5000, 5000, 0, 0});
  const json found = compare(folder("true"), folder("estimate"));
  EXPECT_EQ(found["images"], 3);
  EXPECT_EQ(found["missing_images"], 1);
  EXPECT_EQ(found["coverage"], 0.5);
  EXPECT_NEAR(found["rmse_m"], 0.5, 1e-12);
}

// 2 m against 2.5 m, and 1 m against 1 m, in mm and in 0.2 mm.
TEST_F(DepthMetric, EachSideHasTheScaleOfItsSequence) {
  write("a/depth/1.png", {2000, 1000, 0, 0});
  write("b/depth/1.png", {12500, 5000, 0, 0});
  write_sequence_yaml("a", "schema: 1\ndepth: {units_per_m: 1000}\n");
  write_sequence_yaml("b", "schema: 1\ndepth: {units_per_m: 5000}\n");
  for (const std::string images : {"depth", "depth/", "depth/1.png"}) {
    const json found = compare(folder("a/") + images, folder("b/") + images, {});
    EXPECT_EQ(found["true_units_per_m"], 1000) << images;
    EXPECT_EQ(found["estimate_units_per_m"], 5000) << images;
    EXPECT_NEAR(found["rmse_m"], 0.5 / std::sqrt(2), 1e-12) << images;
    EXPECT_NEAR(found["median_m"], 0.25, 1e-12) << images;
    EXPECT_NEAR(found["absolute_relative_error"], 0.125, 1e-12) << images;
    EXPECT_EQ(found["delta_1"], 0.5) << images;
  }
  EXPECT_EQ(compare(folder("a/depth"), folder("a/depth"), {})["true_units_per_m"], 1000);
}

TEST_F(DepthMetric, WithoutASequenceTheOptionSaysTheScale) {
  const std::string truth = write("a/depth/1.png", {2000, 1000, 0, 0});
  const std::string estimate = write("alone/deep/1.png", {10000, 5000, 0, 0});
  write_sequence_yaml("a", "depth: {units_per_m: 1000}\n");
  EXPECT_EQ(compare(truth, estimate, in_units(5000))["rmse_m"], 0);  // of the other side alone
  EXPECT_NE(refusal(truth, estimate, {}).find("1.png: no sequence.yaml"), std::string::npos);
  EXPECT_NE(refusal(truth, estimate, {}).find("--scale"), std::string::npos);
  EXPECT_EQ(refusal(truth, truth, in_units(5000)), "--scale 5000: the images' sequence.yaml says 1000");
  write_sequence_yaml("a", "depth: {units_per_m: 0}\n");
  EXPECT_NE(refusal(truth, truth, {}).find("sequence.yaml:1"), std::string::npos);
}

TEST_F(DepthMetric, MasksRestrictToAnId) {
  write("true/a.png", {5000, 5000, 10000, 10000});
  write("estimate/a.png", {5000, 6000, 10000, 0});
  write("masks/a.png", {3, 3, 0, 4});
  DepthOptions options = in_units(5000);
  options.masks = folder("masks");
  options.id = 3;
  const json found = compare(folder("true"), folder("estimate"), options);
  EXPECT_EQ(found["n"], 2);
  EXPECT_EQ(found["coverage"], 1);
  EXPECT_NEAR(found["rmse_m"], 0.2 / std::sqrt(2), 1e-12);
  options.id = 4;
  EXPECT_EQ(compare(folder("true"), folder("estimate"), options)["coverage"], 0);
  options.id = 5;
  EXPECT_NE(refusal(folder("true"), folder("estimate"), options).find("masks: no true depth under the id 5"),
            std::string::npos);
  write("masks/a.png", {3, 3, 0, 4, 3, 3});
  EXPECT_NE(refusal(folder("true"), folder("estimate"), options).find("a.png: is 3x2, the true depth 2x2"),
            std::string::npos);
}

TEST_F(DepthMetric, RefusesWhatCannotBeCompared) {
  const std::string truth = write("true.png", {5000, 5000, 0, 0});
  const auto refused = [&](const std::string& one, const std::string& other, const std::string& what) {
    const std::string message = refusal(one, other);
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  refused(truth, write("wide.png", {1, 1, 1, 1, 1, 1}), "wide.png: is 3x2, the true depth 2x2");
  refused(truth, folder("none.png"), "none.png: cannot be read");
  refused(write("zero.png", {0, 0, 0, 65535}), truth, "zero.png: has no depth");
  write_png(folder("grey.png"), cv::Mat(2, 2, CV_8UC1, cv::Scalar(7)));
  refused(truth, folder("grey.png"), "grey.png: is no 16-bit image");
  write_text(folder("text.png"), "depth");
  refused(folder("text.png"), truth, "text.png: is not an image");
  write("images/a.png", {1, 1, 1, 1});
  write("others/b.png", {1, 1, 1, 1});
  fs::create_directory(folder("empty"));
  refused(truth, folder("images"), "one is a folder");
  refused(folder("empty"), folder("images"), "empty: has no PNG images");
  refused(folder("images"), folder("others"), "others: has none of the images of");
}

}  // namespace
}  // namespace uniquadric
