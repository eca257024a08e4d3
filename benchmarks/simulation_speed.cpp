// Frames per second of `simulate`, files written, against a bare loop that only draws the same pass (colour,
// ids, depth) and reads it back into images it reuses.
//   simulation_speed SCENE.yaml [FRAMES [ROUNDS]]
// Every measurement is a process of its own, so that the bare loop has OSMesa as it comes (its own threads,
// one a core) and simulate has it as simulate sets it. The two take turns; the ratio is that of the medians.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/base/text.h"
#include "simulator/render/renderer.h"
#include "simulator/simulate.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

double seconds(const std::function<void()>& action) {
  const auto start = std::chrono::steady_clock::now();
  action();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// What `measure` returns, from a child process.
double in_own_process(const std::function<double()>& measure) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child == 0) {
    const double value = measure();
    const bool written = write(ends[1], &value, sizeof value) == sizeof value;
    _exit(written ? 0 : 1);
  }
  close(ends[1]);
  double value = 0;
  const bool complete = read(ends[0], &value, sizeof value) == sizeof value;
  close(ends[0]);
  waitpid(child, nullptr, 0);
  if (!complete) throw std::runtime_error("a measurement failed");
  return value;
}

double bare_fps(const Scene& scene, std::int64_t frames) {
  setenv("LP_NUM_THREADS", std::to_string(std::thread::hardware_concurrency()).c_str(), 0);
  Renderer renderer(scene);
  cv::Mat bgra, ids, depth_m;
  const auto draw = [&](std::int64_t frame) {
    renderer.draw(poses_at(scene, static_cast<double>(frame) / scene.rate_hz));
    renderer.read_back(bgra, ids, depth_m);
  };
  draw(0);  // compiles the shaders
  return static_cast<double>(frames) / seconds([&] {
           for (std::int64_t frame = 0; frame < frames; ++frame) draw(frame);
         });
}

double simulate_fps(const Scene& scene, std::int64_t frames) {
  const fs::path out = fs::temp_directory_path() / fmt::format("simulation_speed.{}", getpid());
  SimulateOptions options;
  options.frames = frames;
  options.quiet = true;
  const double time_s = seconds([&] { simulate(scene, options, out); });
  fs::remove_all(out);
  return static_cast<double>(frames) / time_s;
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

void run(int argc, char** argv) {
  if (argc < 2) throw std::runtime_error("usage: simulation_speed SCENE.yaml [FRAMES [ROUNDS]]");
  const Scene scene = load_scene(argv[1]);
  const std::int64_t frames = argument(argc, argv, 2, 150), rounds = argument(argc, argv, 3, 3);
  std::vector<double> bare, simulated;
  for (std::int64_t round = 0; round < rounds; ++round) {
    bare.push_back(in_own_process([&] { return bare_fps(scene, frames); }));
    simulated.push_back(in_own_process([&] { return simulate_fps(scene, frames); }));
    fmt::print(stderr, "round {}: bare {:.1f} fps, simulate {:.1f} fps\n", round + 1, bare.back(),
               simulated.back());
  }
  fmt::print("scene {}: {} frames, {} cores\n", scene.name, frames, std::thread::hardware_concurrency());
  fmt::print("bare draw and read-back  {:7.1f} fps\n", median(bare));
  fmt::print("simulate, files written  {:7.1f} fps\n", median(simulated));
  fmt::print("ratio                    {:7.2f}\n", median(simulated) / median(bare));
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
