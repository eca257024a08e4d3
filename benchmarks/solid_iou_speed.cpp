// Time of inside tests of a closed mesh, of an open one, and of the solid IoU of one frame.
#include <benchmark/benchmark.h>

#include "core/base/random.h"
#include "evaluation/iou/solid_iou.h"
#include "tests/evaluation/solid_meshes.h"

namespace {

using namespace uniquadric;

constexpr int kPoints = 100'000;
constexpr std::uint32_t kRings = 51;  // 5,100 triangles
constexpr int kCandidates = 32768;    // as evaluate takes them

std::vector<Eigen::Vector3d> points_in_box() {
  RandomStream random(1, "solid_iou_speed");
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kPoints; ++i) {
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), z = random.uniform(-1, 1);
    points.emplace_back(x, y, z);
  }
  return points;
}

void over_points(benchmark::State& state, const TestMesh& mesh) {
  const MeshSolid solid(mesh.corners, mesh.triangles);
  const std::vector<Eigen::Vector3d> points = points_in_box();
  for (auto _ : state) benchmark::DoNotOptimize(solid.contains(points));
}

void closed_mesh(benchmark::State& state) {
  over_points(state, ball_mesh(kRings));
}
BENCHMARK(closed_mesh)->Unit(benchmark::kMillisecond)->UseRealTime();

void open_mesh(benchmark::State& state) {
  TestMesh mesh = ball_mesh(kRings);
  mesh.triangles.pop_back();
  over_points(state, mesh);
}
BENCHMARK(open_mesh)->Unit(benchmark::kMillisecond)->UseRealTime();

void iou_of_frame(benchmark::State& state) {
  const SolidSamples samples(solid_of(box_mesh({0, 0, 0}, {1, 1, 1})), kCandidates, 1);
  const Superellipsoid other{{1, 1.1, 0.9}, {1.1, 1.2, 1.3}, 2};
  for (auto _ : state) benchmark::DoNotOptimize(solid_iou(samples, other, {{}, {0.1, 0, 0}}));
}
BENCHMARK(iou_of_frame)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
