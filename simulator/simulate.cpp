#include "simulator/simulate.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <thread>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/progress.h"
#include "core/base/version.h"
#include "simulator/frame_files.h"
#include "simulator/imu/imu_files.h"
#include "simulator/render/renderer.h"
#include "simulator/scene_files.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// What a partial folder must have been made of to be gone on with.
std::string resume_key(const Scene& scene, std::uint64_t seed, std::int64_t frames) {
  return Hash().add(scene.hash).add(seed).add(static_cast<std::uint64_t>(frames)).add(kProgram).hex();
}

// Empties a partial folder of another scene, seed, length or program; a scene without a hash cannot be told
// from another.
void discard_other_work(const Scene& scene, const std::string& key, const fs::path& folder) {
  const fs::path key_file = folder / "key";
  if (!scene.hash.empty() && fs::exists(key_file) && read_text(key_file) == key) return;
  for (const auto& entry : fs::directory_iterator(folder)) fs::remove_all(entry.path());
  create_frame_folders(folder);
  write_text(key_file, key);
}

// Takes frames off a shared counter until none is left. A thread renders and encodes its own frames with a
// renderer of its own: that keeps every core busy whichever of the two is slower, and holds one frame a
// thread in memory.
class FrameQueue {
 public:
  FrameQueue(const Scene& scene, const SimulateOptions& options, std::int64_t frames, fs::path folder)
      : scene_(scene),
        seed_(options.seed),
        frames_(frames),
        folder_(std::move(folder)),
        progress_(fmt::format("simulate {}", scene.name), frames, options.quiet) {}

  void work() {
    try {
      std::unique_ptr<Renderer> renderer;
      for (std::int64_t frame = next_++; frame < frames_; frame = next_++) {
        if (!is_frame_complete(folder_, frame)) {
          if (!renderer) renderer = std::make_unique<Renderer>(scene_);
          write_frame(scene_, seed_, folder_, frame,
                      renderer->render(poses_at(scene_, frame_time_s(scene_, frame))));
        }
        progress_.advance();
      }
    } catch (...) {
      next_ = frames_;  // the other threads finish their frame and stop
      throw;
    }
  }

 private:
  const Scene& scene_;
  std::uint64_t seed_;
  std::int64_t frames_;
  fs::path folder_;
  Progress progress_;
  std::atomic<std::int64_t> next_ = 0;
};

void write_frames(const Scene& scene, const SimulateOptions& options, std::int64_t frames,
                  const fs::path& folder) {
  const int machine = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const std::int64_t threads =
      std::min<std::int64_t>(options.threads > 0 ? options.threads : machine, frames);
  FrameQueue queue(scene, options, frames, folder);
  std::vector<std::future<void>> workers;
  for (std::int64_t i = 1; i < threads; ++i)
    workers.push_back(std::async(std::launch::async, [&] { queue.work(); }));
  queue.work();
  for (auto& worker : workers) worker.get();
}

}  // namespace

void simulate(const Scene& scene, const SimulateOptions& options, const fs::path& out) {
  check_can_render(scene);
  const std::int64_t frames = options.frames.value_or(scene.frames);
  if (frames < 1)
    throw InputError(fmt::format("scene {}: {} frames asked for, expected at least 1", scene.name, frames));
  PendingFolder pending(out, options.force, true);
  const fs::path& folder = pending.path();
  discard_other_work(scene, resume_key(scene, options.seed, frames), folder);
  write_frames(scene, options, frames, folder);
  join_visibility(folder, frames);
  write_sequence_files(scene, options.seed, frames, folder / "sequence");
  write_truth_files(scene, frames, folder / "truth");
  write_imu_files(scene, options.seed, frames, folder / "sequence", folder / "truth");
  fs::remove_all(folder / "frames");
  fs::remove(folder / "key");
  pending.commit();
}

}  // namespace uniquadric
