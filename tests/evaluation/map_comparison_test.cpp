#include "evaluation/metrics/map_comparison.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/random.h"
#include "core/sequence/ply.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
using nlohmann::json;
using Index = std::array<int, 3>;

class MapMetric : public testing::Test {
 protected:
  // An octree of cells named by their indices: the cell 0 reaches from the origin to one edge.
  std::string write(const std::string& name, const std::vector<Index>& occupied,
                    const std::vector<Index>& free, double resolution_m = 0.1) {
    octomap::OcTree tree(resolution_m);
    const auto set = [&](const Index& cell, bool value) {
      const auto middle = [&](int i) { return static_cast<float>((i + 0.5) * resolution_m); };
      tree.setNodeValue(octomap::point3d(middle(cell[0]), middle(cell[1]), middle(cell[2])),
                        value ? 3.f : -2.f);
    };
    for (const Index& cell : free) set(cell, false);
    for (const Index& cell : occupied) set(cell, true);
    std::ostringstream bytes;
    tree.toMaxLikelihood();
    tree.prune();
    bytes << "# Octomap OcTree binary file\nid OcTree\nsize " << tree.size() << "\nres " << resolution_m
          << "\ndata\n";
    tree.writeBinaryData(bytes);
    return write_bytes(name, bytes.str());
  }
  std::string write_bytes(const std::string& name, const std::string& bytes) {
    write_text(temp_.path() / name, bytes);
    return temp_.path() / name;
  }
  static json compare(const std::string& truth, const std::string& estimate, const MapOptions& options = {}) {
    return json::parse(figures_json(figures(compare_maps(truth, estimate, options))));
  }
  static std::string refusal(const std::string& truth, const std::string& estimate,
                             const MapOptions& options = {}) {
    return input_error([&] { compare_maps(truth, estimate, options); });
  }

  TempFolder temp_;
};

// A filled block of cells.
std::vector<Index> block(const Index& low, const Index& high) {
  std::vector<Index> cells;
  for (int x = low[0]; x < high[0]; ++x)
    for (int y = low[1]; y < high[1]; ++y)
      for (int z = low[2]; z < high[2]; ++z) cells.push_back({x, y, z});
  return cells;
}

}  // namespace

TEST_F(MapMetric, CountsTwoMapsMadeByHand) {
  // Of four true surface cells one is found, one is found a cell off, one is free, one unknown and far.
  const std::string truth = write("true.bt", {{0, 0, 0}, {10, 0, 0}, {20, 0, 0}, {30, 0, 0}},
                                  {{0, 0, 1}, {11, 1, 1}, {40, 0, 0}, {41, 0, 0}});
  const std::string estimate =
      write("estimate.bt", {{0, 0, 0}, {11, 1, 1}, {40, 0, 0}, {99, 0, 0}}, {{20, 0, 0}, {0, 0, 1}});
  const json found = compare(truth, estimate);
  EXPECT_EQ(found["resolution_m"], 0.1);
  EXPECT_EQ(found["true_unknown_is"], "ignored");
  EXPECT_EQ(found["true_known_voxels"], 8);
  EXPECT_EQ(found["true_occupied_voxels"], 4);
  EXPECT_EQ(found["estimate_occupied_voxels"], 3);  // the one at 99 is where the truth knows nothing
  EXPECT_EQ(found["precision"], 1 / 3.);
  EXPECT_EQ(found["recall"], 0.25);
  EXPECT_EQ(found["iou"], 1 / 6.);
  EXPECT_EQ(found["unknown_share"], 3 / 8.);  // 10, 30 and 41
  EXPECT_EQ(found["completeness"], 0.5);      // 0 and, over the corner, 10
  MapOptions closed;
  closed.unknown_is_free = true;
  EXPECT_EQ(compare(truth, estimate, closed)["precision"], 0.25);
  EXPECT_EQ(compare(truth, estimate, closed)["iou"], 1 / 7.);
}

TEST_F(MapMetric, WhatATrueMapOfSurfacesAloneDoesNotListIsFree) {
  const std::string truth = write("true.bt", {{0, 0, 0}, {1, 0, 0}}, {});
  const std::string estimate = write("estimate.bt", {{0, 0, 0}, {50, 0, 0}, {51, 0, 0}}, {});
  const json found = compare(truth, estimate);
  EXPECT_EQ(found["true_unknown_is"], "free");
  EXPECT_EQ(found["precision"], 1 / 3.);
  EXPECT_EQ(found["unknown_share"], 0.5);
  MapOptions open;
  open.unknown_is_free = false;
  EXPECT_EQ(compare(truth, estimate, open)["precision"], 1);
}

TEST_F(MapMetric, IdentityIsPerfectAndExchangeSwapsPrecisionAndRecall) {
  // The same known space on both sides, occupied at random, pruned where eight are alike.
  RandomStream random(7, "map", 0, 0);
  const auto make = [&](const char* name, double share) {
    std::vector<Index> occupied = block({-4, -4, -4}, {0, 0, 0}), free;
    for (const Index& cell : block({0, -4, -4}, {8, 4, 4}))
      (random.uniform() < share ? occupied : free).push_back(cell);
    return write(name, occupied, free);
  };
  const std::string a = make("a.bt", 0.3), b = make("b.bt", 0.5);
  for (const char* key : {"precision", "recall", "iou", "completeness"})
    EXPECT_EQ(compare(a, a)[key], 1) << key;
  EXPECT_EQ(compare(a, a)["unknown_share"], 0);
  EXPECT_EQ(compare(a, a)["true_known_voxels"], 64 + 512);
  const json there = compare(a, b), back = compare(b, a);
  EXPECT_EQ(there["precision"], back["recall"]);
  EXPECT_EQ(there["recall"], back["precision"]);
  EXPECT_EQ(there["iou"], back["iou"]);
  EXPECT_LT(there["iou"], 0.6);
  EXPECT_NE(there["precision"], there["recall"]);
}

TEST_F(MapMetric, ComparesAtTheCoarserResolutionOrTheOneAskedFor) {
  // Cells of 0.05 m on both sides of the origin: 2 x 2 x 2 of them are one of 0.1 m.
  const std::string fine =
      write("fine.bt", {{0, 0, 0}, {1, 1, 1}, {-1, -1, -1}, {6, 0, 0}}, {{4, 0, 0}}, 0.05);
  const std::string coarse = write("coarse.bt", {{0, 0, 0}, {-1, -1, -1}}, {{2, 0, 0}, {3, 0, 0}}, 0.1);
  const json found = compare(fine, coarse);
  EXPECT_EQ(found["resolution_m"], 0.1);
  EXPECT_EQ(found["true_occupied_voxels"], 3);
  EXPECT_EQ(found["true_known_voxels"], 4);
  EXPECT_EQ(found["recall"], 2 / 3.);
  EXPECT_EQ(found["precision"], 1);
  EXPECT_EQ(compare(coarse, fine)["precision"], 2 / 3.);
  MapOptions coarser;
  coarser.resolution_m = 0.4;
  EXPECT_EQ(compare(fine, coarse, coarser)["true_occupied_voxels"], 2);
  EXPECT_EQ(compare(fine, coarse, coarser)["iou"], 1);
  for (const double none : {0., -0.1, 0.3, 1e9}) {
    MapOptions bad;
    bad.resolution_m = none;
    EXPECT_NE(refusal(fine, coarse, bad).find("fine.bt: its cells of 0.05 m"), std::string::npos) << none;
  }
  MapOptions finer;
  finer.resolution_m = 0.05;
  EXPECT_NE(refusal(fine, coarse, finer).find("coarse.bt: its cells of 0.1 m"), std::string::npos);
  EXPECT_NE(refusal(fine, write("odd.bt", {{0, 0, 0}}, {}, 0.15)).find("no voxels of 0.15 m"),
            std::string::npos);
}

// A map as sets of voxels, `ratio` cells an edge.
struct Sets {
  std::set<Index> occupied, known;

  Sets(const std::vector<Index>& occupied_cells, const std::vector<Index>& free_cells, int ratio) {
    const auto voxel = [&](const Index& cell) {
      Index index;
      for (std::size_t k = 0; k < 3; ++k) index[k] = static_cast<int>(std::floor(cell[k] / double(ratio)));
      return index;
    };
    for (const Index& cell : occupied_cells) occupied.insert(voxel(cell)), known.insert(voxel(cell));
    for (const Index& cell : free_cells) known.insert(voxel(cell));
  }
};

TEST_F(MapMetric, AgreesWithSetsOfVoxels) {
  RandomStream random(11, "map", 0, 0);
  const auto fill = [&](int reach, std::vector<Index>& occupied, std::vector<Index>& free) {
    for (const Index& cell : block({-reach, -reach, -reach}, {reach, reach, reach}))
      if (const double u = random.uniform(); u < 0.4) (u < 0.04 ? occupied : free).push_back(cell);
    for (const Index& cell : block({-reach, 0, 0}, {0, reach / 2, reach / 2})) occupied.push_back(cell);
  };
  std::vector<Index> true_occupied, true_free, occupied, free;
  fill(12, true_occupied, true_free);
  fill(7, occupied, free);
  const json found =
      compare(write("true.bt", true_occupied, true_free, 0.05), write("est.bt", occupied, free, 0.1));
  const Sets truth(true_occupied, true_free, 2), estimate(occupied, free, 1);
  double both = 0, wrong = 0, unknown = 0, complete = 0;
  for (const Index& v : estimate.occupied) {
    both += truth.occupied.contains(v);
    wrong += truth.known.contains(v) && !truth.occupied.contains(v);
  }
  for (const Index& v : truth.known) unknown += !estimate.known.contains(v);
  for (const Index& v : truth.occupied)
    complete += std::any_of(estimate.occupied.begin(), estimate.occupied.end(), [&](const Index& e) {
      return std::abs(e[0] - v[0]) <= 1 && std::abs(e[1] - v[1]) <= 1 && std::abs(e[2] - v[2]) <= 1;
    });
  const auto true_size = static_cast<double>(truth.occupied.size());
  EXPECT_EQ(found["true_known_voxels"], truth.known.size());
  EXPECT_EQ(found["true_occupied_voxels"], true_size);
  EXPECT_EQ(found["precision"], both / (both + wrong));
  EXPECT_EQ(found["recall"], both / true_size);
  EXPECT_EQ(found["iou"], both / (true_size + wrong));
  EXPECT_EQ(found["unknown_share"], unknown / static_cast<double>(truth.known.size()));
  EXPECT_EQ(found["completeness"], complete / true_size);
  EXPECT_LT(both, complete);
  EXPECT_LT(complete, true_size);
}

TEST_F(MapMetric, WideOpenSpaceIsCountedWithoutBeingWalkedThrough) {
  // By its bits: far off an occupied cell, below the origin's octant 0; at the origin a free block of 2^12
  // cells an edge, four levels down octant 7. 3: goes on, 2: occupied, 1: free.
  std::string nodes = "\3\xc0";
  for (int level = 1; level < 15; ++level) nodes += std::string("\3\0", 2);
  nodes += std::string("\2\0\3\0\3\0\1\0", 8);
  const std::string wide =
      write_bytes("wide.bt", "# Octomap OcTree binary file\nid OcTree\nsize 21\nres 0.1\ndata\n" + nodes);
  const std::string small = write("small.bt", {{0, 0, 0}}, {{1, 0, 0}});
  const json found = compare(wide, small);
  EXPECT_EQ(found["true_known_voxels"], (1ull << 36) + 1);
  EXPECT_EQ(found["precision"], 0);
  EXPECT_EQ(found["unknown_share"], ((1ull << 36) - 1) / static_cast<double>((1ull << 36) + 1));
}

TEST_F(MapMetric, RefusesWhatIsNoMap) {
  const std::string good = write("good.bt", {{0, 0, 0}}, {{1, 0, 0}}), bytes = read_text(good);
  const auto refused = [&](const std::string& content, const std::string& what) {
    const std::string message = refusal(good, write_bytes("bad.bt", content));
    EXPECT_NE(message.find("bad.bt"), std::string::npos) << message;
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  const std::string head = "# Octomap OcTree binary file\n";
  refused("", ":1: expected '# Octomap");
  refused("ply\n", ":1: expected '# Octomap");
  refused(head + "id ColorOcTree\n", ":2: id: 'ColorOcTree' is not OcTree");
  refused(head + "id OcTree\nsize 1\nres nan\n", ":4: res: expected a number");
  refused(head + "res 0.1\nsize -1\n", ":3: size: expected a count");
  refused(head + "size 1\nrest 0.1\n", ":3: 'rest' is none of");
  refused(head + "id OcTree\nsize 1\nres 0.1\n", "the header has no data");
  refused(head + "id OcTree\nsize 1\ndata\nxx", "the header has no res");
  refused(head + "id OcTree\nsize 0\nres 0.1\ndata\n", "has no voxels");
  refused(bytes.substr(0, bytes.size() - 1), "is cut short");
  refused(bytes + "x", "1 bytes after the tree");
  refused(head + "size 9\nres 0.1\ndata\n" + std::string(2, '\0'),
          "byte 0 of the data: a node without children");
  refused(head + "size 9\nres 0.1\ndata\n" + std::string(1'000'000, '\3'), "has more than 16 levels");
  EXPECT_NE(refusal(write("free.bt", {}, {{0, 0, 0}}), good).find("free.bt: has no occupied voxel"),
            std::string::npos);
}

// Against the same cells as a tree; in voxels of 0.25 m at least.
TEST_F(MapMetric, PointsCountAsTheVoxelsThatTheyAreIn) {
  const std::string truth = write("true.bt", block({0, 0, 0}, {16, 16, 1}), {});
  std::vector<Index> cells;
  std::vector<Eigen::Vector3d> points;
  for (int x = 0; x < 8; ++x)
    for (int y = -4; y < 16; ++y) {
      cells.push_back({x, y, 0});
      for (const double at : {0.2, 0.7}) points.emplace_back(0.1 * (x + at), 0.1 * (y + at), 0.03);
    }
  const std::string estimate = write("estimate.bt", cells, {});
  for (const double resolution_m : {0.1, 0.2, 0.8})
    EXPECT_EQ(figures_json(figures(compare_map_points(truth, "map.ply", points, {resolution_m, {}}))),
              figures_json(figures(compare_maps(truth, estimate, {resolution_m, {}}))));
  SurfaceFile file;
  for (const Eigen::Vector3d& p : points) file.points.push_back(p.cast<float>());
  write_surface_ply(temp_.path() / "map.ply", file, "");
  EXPECT_EQ(compare(truth, temp_.path() / "map.ply", {0.2, {}}), compare(truth, estimate, {0.2, {}}));
  const MapComparison usual = compare_map_points(truth, "map.ply", points, {});
  EXPECT_DOUBLE_EQ(usual.resolution_m, 0.4);
  EXPECT_EQ(usual.at(Occupancy::occupied, Occupancy::occupied), 8u);  // 2 x 4 of 4 x 4, and 2 beside them
  EXPECT_EQ(usual.at(Occupancy::unknown, Occupancy::occupied), 2u);
  EXPECT_TRUE(usual.unknown_is_free);
  const auto refused = [&](const std::vector<Eigen::Vector3d>& far, const MapOptions& options) {
    return input_error([&] { compare_map_points(truth, "map.ply", far, options); });
  };
  EXPECT_NE(refused({{0, 0, 20'000}}, {}).find("map.ply: a point lies beyond 13107.2 m"), std::string::npos);
  EXPECT_NE(refused(points, {0.15, {}}).find("true.bt: its cells of 0.1 m"), std::string::npos);
}

}  // namespace uniquadric
