// Frames per second of `simulate`, files written, against a bare loop that only draws the same pass (colour,
// ids, depth) and reads it back into images it reuses.
//   simulation_speed SCENE.yaml [FRAMES [ROUNDS]]
// simulate draws with a process a core, each with an OSMesa context that rasterises in the process's one
// thread; so does the bare loop, which is then what simulate does without everything else. A second bare loop
// draws in one process, in which OSMesa has a thread a core, as it comes. The bare loops' clock starts when
// their contexts are made and warm; of simulate there is the whole call, and its frames with the making of
// the contexts. On a machine that is busy otherwise frames a second say little; processor time a frame, each
// worker's first left out, still tells what simulate does beside drawing.
// Writing stands apart there: a virtual machine may pay far more for memory that it touches for the first
// time than for copying to it (measured 2.7 ms a megabyte against 0.4), and new files lie in such memory.
// All take turns, each in processes of their own; the ratios are those of medians. Measured for the scene as
// it is and with its triangles split until there are 200 000: the same images of heavier geometry.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "simulator/render/renderer.h"
#include "simulator/simulate.h"
#include "simulator/stage_times.h"
#include "simulator/workers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t kHeavyTriangles = 200'000;

int cores() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// When the first worker began and the last one ended, all having waited for each other before.
struct Race {
  std::atomic<int> ready = 0;
  std::atomic<double> begin_s = 0, end_s = 0;
  std::atomic<double> worked_s = 0;  // processor time of all
};

struct Speed {
  double fps = 0;
  double core_ms = 0;  // processor time a frame, where each process has one thread
};

Speed bare_speed(const Scene& scene, std::int64_t frames, int processes, int threads) {
  const SharedCounter counter(frames);
  const std::shared_ptr<Race> race = make_shared_value<Race>();
  const auto work = [&](int) {
    if (threads > 1) setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), 1);
    SharedCounter next = counter;
    Renderer renderer(scene);
    cv::Mat rgba, ids, depth_m;
    const auto draw = [&](std::int64_t frame) {
      renderer.draw(poses_at(scene, static_cast<double>(frame) / scene.rate_hz));
      renderer.read_back(rgba, ids, depth_m);
    };
    draw(0);  // compiles the shaders
    for (++race->ready; race->ready < processes;) std::this_thread::yield();
    double never = 0;
    race->begin_s.compare_exchange_strong(never, now_s());
    const double start_s = thread_seconds();
    for (std::int64_t frame = next.take(); frame < frames; frame = next.take()) draw(frame);
    race->worked_s += thread_seconds() - start_s;
    for (double end_s = race->end_s; end_s < now_s();)
      if (race->end_s.compare_exchange_weak(end_s, now_s())) break;
  };
  run_workers(processes, work, [] {});
  const auto count = static_cast<double>(frames);
  return {count / (race->end_s - race->begin_s), 1e3 * race->worked_s / count};
}

using Stages = std::map<std::string, double>;  // ms of each; frame_...: of one core a frame

Stages read_stages(const fs::path& file) {
  Stages stages;
  for_each_line(
      file,
      [&](int line, const std::vector<std::string_view>& fields) {
        if (line > 1) stages[std::string(fields.at(0))] = parse_double(fields.at(2)).value();
      },
      ',');
  return stages;
}

// With "whole": of the call, also in ms a frame.
Stages simulate_stages(const Scene& scene, std::int64_t frames) {
  const fs::path out = fs::temp_directory_path() / fmt::format("simulation_speed.{}", getpid());
  SimulateOptions options;
  options.frames = frames;
  options.quiet = true;
  options.timing = out.string() + ".csv";
  const double start_s = now_s();
  simulate(scene, options, out);
  const double whole_s = now_s() - start_s;
  Stages stages = read_stages(options.timing);
  stages["whole"] = 1e3 * whole_s / static_cast<double>(frames);
  fs::remove_all(out);
  fs::remove(options.timing);
  return stages;
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

struct Bare {
  double fps = 0, threaded_fps = 0;
};

void print_row(const std::string& what, double fps, const Bare& bare) {
  fmt::print("  {:<46} {:7.1f} fps {:9.2f} {:9.2f}\n", what, fps, fps / bare.fps, fps / bare.threaded_fps);
}

using Times = std::map<std::string, std::vector<double>>;  // of each stage, a round after the other

// In processor time, all that is left of the ratio when nobody waits for a core.
void print_simulate(Times& times, const Bare& bare, double bare_ms) {
  const auto ms = [&](const std::string& stage) { return median(times[stage]); };
  double frame_ms = 0;
  for (const char* stage : kFrameStages) frame_ms += ms(fmt::format("frame_{}", stage));
  print_row(fmt::format("simulate ({} processes), its whole call", cores()), 1e3 / ms("whole"), bare);
  print_row("  its frames, files written", 1e3 / ms("frames"), bare);
  fmt::print("    processor time a frame {:.2f} ms =", frame_ms);
  for (const char* stage : kFrameStages) fmt::print(" {} {:.2f}", stage, ms(fmt::format("frame_{}", stage)));
  fmt::print(
      "; bare loop {:.2f} ms\n    bare over simulate: {:.2f}; without writing {:.2f}; drawing alone {:.2f}\n",
      bare_ms, bare_ms / frame_ms, bare_ms / (frame_ms - ms("frame_write")), bare_ms / ms("frame_draw"));
  fmt::print("    once: a worker's first frame {:.0f} ms, truth and IMU {:.0f} ms, hashes {:.0f} ms\n",
             ms("first_frame"), ms("truth_and_imu"), ms("hashes"));
}

void compare(Scene& scene, std::int64_t frames, std::int64_t rounds) {
  std::vector<double> fps, core_ms, threaded_fps;
  Times times;
  for (std::int64_t round = 0; round < rounds; ++round) {
    const Speed bare = bare_speed(scene, frames, cores(), 1);
    fps.push_back(bare.fps), core_ms.push_back(bare.core_ms);
    threaded_fps.push_back(bare_speed(scene, frames, 1, cores()).fps);
    for (const auto& [stage, ms] : simulate_stages(scene, frames)) times[stage].push_back(ms);
  }
  const Bare bare{median(fps), median(threaded_fps)};
  fmt::print("scene {}, {} triangles, {}x{}: {} frames, {} rounds, {} cores; ratios to either bare loop\n",
             scene.name, count_triangles(scene), scene.camera.width, scene.camera.height, frames, rounds,
             cores());
  print_row(fmt::format("bare draw and read-back, {} processes, 1 thread", cores()), bare.fps, bare);
  print_row(fmt::format("bare draw and read-back, 1 process, {} threads", cores()), bare.threaded_fps, bare);
  print_simulate(times, bare, median(core_ms));
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
