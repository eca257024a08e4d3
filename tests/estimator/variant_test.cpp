#include "estimator/variant.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/files.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Variant load_text(const std::string& text) {
  const TempFolder temp;
  write_text(temp.path() / "variant.yaml", text);
  return load_variant(temp.path() / "variant.yaml");
}

TEST(VariantFile, EveryOptionReadsBack) {
  Variant variant;
  variant.name = "other";
  variant.segmentation = {MaskSource::grabcut_depth, {7, 3, 0.3, 0.7, 0.04, 0.25, 0.06, 0.05}};
  variant.points = {3, 0.05, 20, 0.02, 8, 3, 2, 500, 40};
  variant.obb = {BoxFit::pca, InlierDistance::corner, AxisRule::literal, false, 12, 33, 0.03, 0.25, 0.001};
  variant.axis_naming = AxisNaming::world;
  const std::string yaml = variant_yaml(variant);
  EXPECT_NE(yaml, variant_yaml(Variant{}));
  const Variant back = load_text(yaml);
  EXPECT_EQ(variant_yaml(back), yaml);
  EXPECT_EQ(back.obb.fit, BoxFit::pca);
  EXPECT_EQ(back.points.max_points, 500);
  EXPECT_EQ(back.segmentation.grabcut_depth.depth_jump, 0.05);
  int lines_changed =
      0;  // every option differs from its default: all but schema, section heads, ego and backend
  const auto lines = [](const std::string& text) {
    std::vector<std::string> result;
    for (std::size_t begin = 0; begin < text.size(); begin = text.find('\n', begin) + 1)
      result.push_back(text.substr(begin, text.find('\n', begin) - begin));
    return result;
  };
  const auto a = lines(yaml), b = lines(variant_yaml(Variant{}));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) lines_changed += a[i] != b[i];
  EXPECT_EQ(lines_changed, static_cast<int>(a.size()) - 9);
}

TEST(VariantFile, WhatIsLeftOutHasTheDefaultAndTheNameOfTheFile) {
  Variant expected;
  expected.name = "variant";
  EXPECT_EQ(variant_yaml(load_text("schema: 1\n")), variant_yaml(expected));
}

TEST(VariantFile, BadFilesAreRefusedByLine) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"schema: 2\n", ":1: schema: expected 1 to 1, found 2"},
      {"name: x\n", "missing key 'schema'"},
      {"schema: 1\nshapes: {}\n", ":2: unknown key 'shapes'"},
      {"schema: 1\nshape:\n  obb:\n    iteration: 5\n", ":4: unknown key 'shape.obb.iteration'"},
      {"schema: 1\nshape: {obb: {iterations: 0}}\n",
       ":2: shape.obb.iterations: expected 1 to 1000000, found 0"},
      {"schema: 1\nshape: {obb: {sample_size: 3}}\n",
       ":2: shape.obb.sample_size: expected at least 4, found 3"},
      {"schema: 1\nshape: {obb: {best_weight: 1.5}}\n", "best_weight: expected 0 to 1, found 1.5"},
      {"schema: 1\nshape: {obb: {inlier_threshold_m: -1}}\n", "expected a number greater than 0"},
      {"schema: 1\nshape: {obb: {fit: convex}}\n", "'convex' is none of: surface, minimum_volume, pca"},
      {"schema: 1\nego: {source: rgbd}\n", ":2: ego.source: 'rgbd' is none of: given"},
      {"schema: 1\nbackend: dual_window\n", ":2: backend: 'dual_window' is none of: single_frame"},
      {"schema: 1\npoints: {voxel_m: .nan}\n", "points.voxel_m: expected a finite number"},
      {"schema: 1\nshape: [1]\n", ":2: shape: expected a map"},
      {"schema: 1\nname: [\n", "malformed YAML"},
  };
  int refused = 0;
  for (const auto& [text, what] : cases) {
    try {
      load_text(text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(what), std::string::npos) << e.what();
      ++refused;
    }
  }
  EXPECT_EQ(refused, 14);
}

TEST(VariantFile, ThoseOfTheProjectLoadUnderTheirOwnNames) {
  int loaded = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants")) {
    EXPECT_EQ(load_variant(entry.path()).name, entry.path().stem().string());
    ++loaded;
  }
  EXPECT_GE(loaded, 1);
}

}  // namespace
}  // namespace uniquadric
