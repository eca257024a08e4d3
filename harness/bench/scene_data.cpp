#include "harness/bench/scene_data.h"

#include <atomic>
#include <chrono>
#include <exception>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/base/threads.h"
#include "core/sequence/sequence.h"
#include "harness/bench/keys.h"
#include "harness/bench/task_pool.h"
#include "harness/external/external_variant.h"
#include "simulator/families/family.h"
#include "simulator/lidar_files.h"
#include "simulator/scene/noise_scale.h"
#include "simulator/scene/scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// Of the sequence that will be simulated.
std::vector<std::string> sensors_of(const Scene& scene) {
  std::vector<std::string> sensors = {"rgb", "masks"};
  if (scene.depth) sensors.push_back("depth");
  if (scene.lidar) sensors.push_back("lidar");
  if (scene.imu) sensors.push_back("imu");
  if (scene.given_camera) sensors.push_back("given_camera");
  return sensors;
}

bool takes_the_papers_way(const Scene& scene) {
  const auto rig = lidar_of(scene);
  return rig && rig->method == LidarMethod::depth_octree;
}

// Of what a family's scene sets, the messages name the place in the bench; of the rest, here.
std::string draw(const BenchScene& item) {
  try {
    return generate_scene(*item.drawn_from);
  } catch (const InputError& error) {
    throw InputError(item.where, error.what());
  }
}

SceneData data_of_scene(BenchScene& item) {
  if (item.drawn_from) item.generated = draw(item);
  Scene scene = item.drawn_from ? parse_scene(item.generated, item.path, item.set, Textures::plain)
                                : load_scene(item.path, item.set, Textures::plain);
  scale_noise(scene, item.noise_scale);
  return {"scene", scene.hash, sensors_of(scene), takes_the_papers_way(scene)};
}

SceneData data_of_recording(const BenchScene& item) {
  const bool is_sequence_alone = fs::exists(item.path / "sequence.yaml");
  const fs::path sequence = is_sequence_alone ? item.path : item.path / "sequence";
  const bool has_truth = !is_sequence_alone && fs::is_directory(item.path / "truth");
  const fs::path truth = has_truth ? item.path / "truth" : fs::path();
  return {"recording", recording_key(sequence, truth), sensors_of(open_sequence(sequence)), false, sequence,
          truth};
}

// The fault of the first item that has one, whichever is found first.
class FirstFault {
 public:
  explicit FirstFault(std::size_t count) : faults_(count), first_(count) {}
  // Items behind a known fault need not be looked at.
  bool is_before(std::size_t i) const { return i < first_; }
  void keep(std::size_t i, std::exception_ptr fault) {
    faults_[i] = std::move(fault);
    for (std::size_t known = first_; i < known && !first_.compare_exchange_weak(known, i);) continue;
  }
  void throw_it() const {
    if (first_ < faults_.size()) std::rethrow_exception(faults_[first_]);
  }

 private:
  std::vector<std::exception_ptr> faults_;
  std::atomic<std::size_t> first_;
};

}  // namespace

std::vector<SceneData> look_at_scenes(std::vector<BenchScene>& scenes, bool quiet) {
  constexpr int kMostThreads = 8;  // ours: each may hold meshes of 2 GiB
  constexpr std::chrono::seconds kSilent{3};
  std::vector<SceneData> data(scenes.size());
  FirstFault fault(scenes.size());
  Progress progress("plan", std::ssize(scenes), quiet, kSilent);
  const auto look_at = [&](std::size_t i) {
    if (!fault.is_before(i)) return;
    try {
      data[i] = scenes[i].is_recording ? data_of_recording(scenes[i]) : data_of_scene(scenes[i]);
    } catch (const std::exception&) {
      fault.keep(i, std::current_exception());
    }
    progress.advance();
  };
  TaskPool pool(threads_to_use(kMostThreads));
  for (std::size_t i = scenes.size(); i-- > 0;)  // it starts with the last
    pool.add([&look_at, i] { look_at(i); });
  pool.wait();
  fault.throw_it();
  return data;
}

}  // namespace uniquadric
