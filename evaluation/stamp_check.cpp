#include "evaluation/stamp_check.h"

#include <fmt/format.h>

#include <cstdlib>
#include <utility>

#include "core/base/quantile.h"
#include "core/sequence/stamps.h"
#include "core/sequence/trajectory.h"
#include "evaluation/association/stamps.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Stamps = std::vector<std::int64_t>;

// ours: ten times what stamps are off by that another program rounded to 0.1 ms
constexpr std::int64_t kBeside_ns = 1'000'000;

double milliseconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-6;
}

void check_file(const fs::path& file, const Stamps& frames, const Stamps& stamps, std::int64_t limit_ns,
                std::vector<std::string>& faults) {
  Stamps near;  // distances
  for (const std::int64_t stamp_ns : stamps) {
    const std::int64_t distance_ns = std::abs(stamp_ns - frames[nearest_index(frames, stamp_ns)]);
    if (distance_ns <= limit_ns) near.push_back(distance_ns);
  }
  if (near.size() < stamps.size())
    faults.push_back(
        fmt::format("{}: {} of {} stamps lie more than {:g} ms from every frame of the truth, and are "
                    "compared with none",
                    file.string(), stamps.size() - near.size(), stamps.size(), milliseconds(limit_ns)));
  const std::size_t compared = associate(frames, stamps, {StampRule::one_to_one, limit_ns}).size();
  if (compared < near.size())
    faults.push_back(
        fmt::format("{}: {} of {} stamps lie beside another that is nearer to the truth's frame, and are "
                    "compared with none",
                    file.string(), near.size() - compared, stamps.size()));
  if (near.empty()) return;
  const std::int64_t usual_ns = upper_median(std::move(near));
  if (usual_ns > kBeside_ns)
    faults.push_back(
        fmt::format("{}: stamps lie {:.3g} ms from the truth's frames (median), and are compared with "
                    "the nearest; a shifted clock moves every error",
                    file.string(), milliseconds(usual_ns)));
}

void check_frame_numbers(const fs::path& file, const Stamps& frames, const Tracks& estimate,
                         std::int64_t limit_ns, std::vector<std::string>& faults) {
  std::size_t rows = 0, wrong = 0;
  std::string example;
  for (const ObjectTrack& track : estimate.objects)
    for (const ObjectState& state : track.states) {
      const std::size_t frame = nearest_index(frames, state.stamp_ns);
      if (std::abs(state.stamp_ns - frames[frame]) > limit_ns) continue;
      ++rows;
      if (state.frame == static_cast<std::int64_t>(frame)) continue;
      if (wrong++ == 0)
        example = fmt::format("object {} at {} s: frame {}, which is the truth's {}", track.id,
                              format_stamp(state.stamp_ns), state.frame, frame);
    }
  if (wrong > 0)
    faults.push_back(
        fmt::format("{}: the frame of {} of {} rows is not the truth's at their stamp ({}); rows are "
                    "compared by their stamps",
                    file.string(), wrong, rows, example));
}

}  // namespace

std::vector<std::string> stamp_faults(const fs::path& estimate_folder, const Tracks& truth,
                                      const Tracks& estimate, std::int64_t max_difference_ns,
                                      bool same_frames) {
  std::vector<std::string> faults;
  const Stamps frames = stamps_of(truth.camera);
  if (frames.empty()) return faults;
  if (estimate.camera.size() < kMinPairs)
    faults.push_back(
        fmt::format("{}: holds {} of the {} poses that the camera's errors and an alignment need at least; "
                    "objects are compared where they stand in the estimate's world",
                    (estimate_folder / "camera.tum").string(), estimate.camera.size(), kMinPairs));
  check_file(estimate_folder / "camera.tum", frames, stamps_of(estimate.camera), max_difference_ns, faults);
  for (const ObjectTrack& track : estimate.objects)
    check_file(estimate_folder / fmt::format("objects/{}.tum", track.id), frames, stamps_of(track.states),
               max_difference_ns, faults);
  if (same_frames)
    check_frame_numbers(estimate_folder / "objects.csv", frames, estimate, max_difference_ns, faults);
  return faults;
}

}  // namespace uniquadric
