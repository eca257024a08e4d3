// Frames per second of `simulate`, files written, against a bare loop that only draws the same pass (colour,
// ids, depth) and reads it back into images it reuses.
//   simulation_speed SCENE.yaml [FRAMES [ROUNDS]]
// Measured for the scene as it is and with its triangles split until there are 200 000: the same images of
// heavier geometry. Every measurement is a process of its own, so that the bare loop has OSMesa as it comes
// (its own threads, one a core) and simulate has it as simulate sets it. The two take turns; the ratio is
// that of the medians. The time of all cores for a frame tells what other programs on the machine hide.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "simulator/render/renderer.h"
#include "simulator/simulate.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t kHeavyTriangles = 200'000;

double seconds(const std::function<void()>& action) {
  const auto start = std::chrono::steady_clock::now();
  action();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Speed {
  double fps = 0, cpu_ms = 0;  // cpu_ms: of all cores, for a frame
};

// Of this process and of those it has waited for.
double cpu_seconds() {
  double total_s = 0;
  for (const int whose : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(whose, &usage);
    for (const timeval& t : {usage.ru_utime, usage.ru_stime})
      total_s += static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  }
  return total_s;
}

Speed measure(std::int64_t frames, const std::function<void()>& action) {
  const double cpu_s = cpu_seconds(), count = static_cast<double>(frames);
  const double time_s = seconds(action);
  return {count / time_s, 1e3 * (cpu_seconds() - cpu_s) / count};
}

// What `run` returns, from a child process.
Speed in_own_process(const std::function<Speed()>& run) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child == 0) {
    const Speed speed = run();
    const bool written = write(ends[1], &speed, sizeof speed) == sizeof speed;
    _exit(written ? 0 : 1);
  }
  close(ends[1]);
  Speed speed;
  const bool complete = read(ends[0], &speed, sizeof speed) == sizeof speed;
  close(ends[0]);
  waitpid(child, nullptr, 0);
  if (!complete) throw std::runtime_error("a measurement failed");
  return speed;
}

Speed bare_speed(const Scene& scene, std::int64_t frames) {
  setenv("LP_NUM_THREADS", std::to_string(std::thread::hardware_concurrency()).c_str(), 0);
  Renderer renderer(scene);
  cv::Mat rgba, ids, depth_m;
  const auto draw = [&](std::int64_t frame) {
    renderer.draw(poses_at(scene, static_cast<double>(frame) / scene.rate_hz));
    renderer.read_back(rgba, ids, depth_m);
  };
  draw(0);  // compiles the shaders
  return measure(frames, [&] {
    for (std::int64_t frame = 0; frame < frames; ++frame) draw(frame);
  });
}

// Everything counts here: the renderers' preparation too.
Speed simulate_speed(const Scene& scene, std::int64_t frames) {
  const fs::path out = fs::temp_directory_path() / fmt::format("simulation_speed.{}", getpid());
  SimulateOptions options;
  options.frames = frames;
  options.quiet = true;
  const Speed speed = measure(frames, [&] { simulate(scene, options, out); });
  fs::remove_all(out);
  return speed;
}

// Halves every edge: four triangles for one, in the same plane.
void split_triangles(Mesh& mesh) {
  const auto split = std::exchange(mesh.triangles, {});
  for (const auto& [a, b, c] : split) {
    const auto middle = [&](unsigned i, unsigned j) {
      mesh.positions.push_back((mesh.positions[i] + mesh.positions[j]) / 2);
      mesh.normals.push_back((mesh.normals[i] + mesh.normals[j]).normalized());
      mesh.uvs.push_back((mesh.uvs[i] + mesh.uvs[j]) / 2);
      return static_cast<unsigned>(mesh.positions.size() - 1);
    };
    const unsigned ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const auto& triangle : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}})
      mesh.triangles.push_back(triangle);
  }
}

std::vector<Mesh*> all_meshes(Scene& scene) {
  std::vector<Mesh*> meshes;
  for (auto* bodies : {&scene.world, &scene.objects})
    for (Body& body : *bodies)
      for (Mesh& mesh : body.meshes) meshes.push_back(&mesh);
  return meshes;
}

std::size_t count_triangles(Scene& scene) {
  std::size_t count = 0;
  for (const Mesh* mesh : all_meshes(scene)) count += mesh->triangles.size();
  return count;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
  return values[values.size() / 2];
}

std::int64_t argument(int argc, char** argv, int place, std::int64_t fallback) {
  if (argc <= place) return fallback;
  const auto value = parse_integer(argv[place]);
  if (!value || *value < 1)
    throw std::runtime_error(fmt::format("'{}' is no number of frames or rounds", argv[place]));
  return *value;
}

void compare(Scene& scene, std::int64_t frames, std::int64_t rounds) {
  std::vector<double> bare_fps, bare_ms, simulate_fps, simulate_ms;
  for (std::int64_t round = 0; round < rounds; ++round) {
    const Speed bare = in_own_process([&] { return bare_speed(scene, frames); });
    const Speed simulated = in_own_process([&] { return simulate_speed(scene, frames); });
    bare_fps.push_back(bare.fps), bare_ms.push_back(bare.cpu_ms);
    simulate_fps.push_back(simulated.fps), simulate_ms.push_back(simulated.cpu_ms);
  }
  fmt::print("scene {}, {} triangles: {} frames, {} rounds, {} cores\n", scene.name, count_triangles(scene),
             frames, rounds, std::thread::hardware_concurrency());
  fmt::print("  bare draw and read-back  {:7.1f} fps  {:7.1f} ms of all cores for a frame\n",
             median(bare_fps), median(bare_ms));
  fmt::print("  simulate, files written  {:7.1f} fps  {:7.1f} ms of all cores for a frame\n",
             median(simulate_fps), median(simulate_ms));
  fmt::print("  ratio                    {:7.2f}      {:7.2f}\n", median(simulate_fps) / median(bare_fps),
             median(bare_ms) / median(simulate_ms));
}

void run(int argc, char** argv) {
  if (argc < 2) throw std::runtime_error("usage: simulation_speed SCENE.yaml [FRAMES [ROUNDS]]");
  Scene scene = load_scene(argv[1]);
  const std::int64_t frames = argument(argc, argv, 2, 300), rounds = argument(argc, argv, 3, 3);
  compare(scene, frames, rounds);
  while (count_triangles(scene) < kHeavyTriangles)
    for (Mesh* mesh : all_meshes(scene)) split_triangles(*mesh);
  compare(scene, frames, rounds);
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  try {
    uniquadric::run(argc, argv);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 2;
  }
}
