#include "estimator/variant.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Variant load_text(const std::string& text) {
  const TempFolder temp;
  write_text(temp.path() / "variant.yaml", text);
  return load_variant(temp.path() / "variant.yaml");
}

// Another value for a line `  key: value` of a variant file; empty for the head of a section.
std::string other_value(const std::string& key, const std::string& value) {
  static const std::map<std::string, std::string> kOthers = {
      {"true", "false"},           {"false", "true"},         {"automatic", "sequence"},
      {"surface", "corner"},       {"blend_best", "literal"}, {"previous", "world"},
      {"tangent", "vector"},       {"hull", "bbox"},          {"hard", "soft"},
      {"single_frame", "windows"}, {"final", "causal"},       {"virtual", "threads"},
      {"sequence", "fixed"},       {"ultrafast", "fast"},     {"none", "renyi"},
      {"object", "global"},        {"perception", "backend"}, {"given", "rgbd"},
      {"flow", "nanotrack"},       {"frames", "scans"},       {"recorded", "images"},
      {"points", "features"}};
  if (value.empty()) return "";
  if (key == "fit") return "pca";
  if (key == "undistortion") return "ego";
  if (key == "exponents") return "3";
  if (key == "outline_noise") return "measured";
  if (key == "axis_samples") return "extents";
  if (const auto other = kOthers.find(value); other != kOthers.end()) return other->second;
  if (const auto whole = parse_integer(value)) return std::to_string(*whole + (*whole < 100 ? 1 : -1));
  if (const auto number = parse_double(value)) return fmt::format("{}", *number * 0.75);
  return "\"other\"";  // a text
}

TEST(VariantFile, EveryOptionReadsBack) {
  const std::string yaml = variant_yaml(Variant{});
  int changed = 0;
  for (std::size_t begin = 0; begin < yaml.size(); begin = yaml.find('\n', begin) + 1) {
    const std::size_t colon = yaml.find(':', begin), end = yaml.find('\n', begin);
    const std::size_t key_begin = yaml.find_first_not_of(' ', begin);
    const std::string key = yaml.substr(key_begin, colon - key_begin);
    const std::string value = colon + 1 < end ? yaml.substr(colon + 2, end - colon - 2) : "";
    const std::string other = other_value(key, value);
    if (other.empty() || key == "schema") continue;
    const std::string expected = yaml.substr(0, colon + 2) + other + yaml.substr(end);
    EXPECT_EQ(variant_yaml(load_text(expected)), expected) << key;
    ++changed;
  }
  EXPECT_GT(changed, 100);  // of some 160
}

TEST(VariantFile, OptionsOfTheShapesPartsAreKeys) {
  const Variant variant = load_text(
      "schema: 1\nshape:\n  surface_cloud: {max_points: 77}\n"
      "  axis_fusion: {bandwidth: 0.8}\n  sphere_sigma: 0.4\n  search_keyframes: 3\n"
      "lifecycle: {acceleration_mps2: 5, angular_acceleration_radps2: 6}\n");
  EXPECT_EQ(variant.body.shape.surface.max_points, 77);
  EXPECT_EQ(variant.body.shape.fusion.bandwidth, 0.8);
  EXPECT_EQ(variant.body.shape.sphere_sigma, 0.4);
  EXPECT_EQ(variant.body.shape.search_keyframes, 3);
  EXPECT_EQ(variant.body.lifecycle.acceleration_mps2, 5);
  EXPECT_EQ(variant.body.lifecycle.angular_acceleration_radps2, 6);
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
      {"schema: 1\nshape: {obb: {fit: convex}}\n",
       "'convex' is none of: surface, tight_surface, minimum_volume, pca"},
      {"schema: 1\nlong_window: {exponents: 2}\n", ":2: long_window.exponents: '2' is none of: 0, 1, 3"},
      {"schema: 1\nego: {source: slam}\n", ":2: ego.source: 'slam' is none of: given"},
      {"schema: 1\nbackend: dual_window\n", ":2: backend: 'dual_window' is none of: single_frame, windows"},
      {"schema: 1\npoints: {voxel_m: .nan}\n", "points.voxel_m: expected a finite number"},
      {"schema: 1\nfeatures: {depth: {max_jump: 1}}\n",
       ":2: features.depth.max_jump: expected 0.0001 to 0.9, found 1"},
      {"schema: 1\ndepth: {lidar: {max_jump: 0}}\n",
       ":2: depth.lidar.max_jump: expected 0.0001 to 0.9, found 0"},
      {"schema: 1\ndepth:\n  lidar: {reach_px: 1e9}\n",
       ":3: depth.lidar.reach_px: expected 0.5 to 200, found 1000000000"},
      {"schema: 1\ndepth: {lidar: {reach_px: 0}}\n",
       ":2: depth.lidar.reach_px: expected 0.5 to 200, found 0"},
      {"schema: 1\nshape: {surface_cloud: {min_hits: 0}}\n", "min_hits: expected 1 to 1000, found 0"},
      {"schema: 1\nshape: {axis_fusion: {literal_alpha: 1}}\n", "literal_alpha: expected 0 to 0.99, found 1"},
      {"schema: 1\nshort_window: {keyframe_gap_s: 1e-10}\n",
       ":2: short_window.keyframe_gap_s: expected 0.001 to 1000000, found 1e-10"},
      {"schema: 1\nlong_window: {outline_sigma_px: 1e-3}\n",
       ":2: long_window.outline_sigma_px: expected 0.01 to 1000, found 0.001"},
      {"schema: 1\nlong_window: {surface_sigma_m: 1e-300}\n",
       "long_window.surface_sigma_m: expected 1e-05 to 10, found 1e-300"},
      {"schema: 1\nlong_window: {outline_sigma_px: 1e9}\n", "expected 0.01 to 1000, found 1000000000"},
      {"schema: 1\nego: {lidar: {range_sigma_m: 1e-9}}\n", "expected 1e-05 to 10, found 1e-09"},
      {"schema: 1\nego: {lidar: {map: {cell_m: 1e-300}}}\n", "expected 1e-09 to 1000000000, found 1e-300"},
      {"schema: 1\nlifecycle: {acceleration_mps2: 0}\n", "expected a number greater than 0"},
      {"schema: 1\nshape: [1]\n", ":2: shape: expected a map"},
      {"schema: 1\nname: [\n", "malformed YAML"},
  };
  for (const auto& [text, what] : cases) {
    try {
      load_text(text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(what), std::string::npos) << e.what();
    }
  }
}

TEST(VariantFile, ThoseOfTheProjectLoadUnderTheirOwnNames) {
  int loaded = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants")) {
    if (entry.is_directory()) continue;
    EXPECT_EQ(load_variant(entry.path()).name, entry.path().stem().string());
    ++loaded;
  }
  EXPECT_GE(loaded, 1);
}

TEST(VariantFile, TheDefaultIsOursForTheSensors) {
  const fs::path variants = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants";
  const auto expect_default = [&](const Sequence& sequence, const std::string& name) {
    const Variant variant = default_variant(sequence);
    EXPECT_EQ(variant.name, name);
    EXPECT_EQ(variant_yaml(variant), variant_yaml(load_variant(variants / (name + ".yaml"))));
  };
  Sequence sequence;
  sequence.lidar.emplace();
  expect_default(sequence, "lidar_only");
  sequence.frames.resize(2);
  expect_default(sequence, "lidar_masks");
  sequence.frames[1].depth = "depth/1.png";
  expect_default(sequence, "superquadric");
  sequence.lidar.reset();
  expect_default(sequence, "superquadric");
}

}  // namespace
}  // namespace uniquadric
