#include "core/import/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "core/base/error.h"
#include "core/base/warning.h"
#include "core/import/bop_result.h"
#include "core/import/kitti_result.h"
#include "core/import/recording.h"
#include "core/import/tum_result.h"
#include "core/sequence/stamps.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// Finds the frame of a stamp, and counts those of none and those that another stamp was nearer to.
class Frames {
 public:
  explicit Frames(std::vector<std::int64_t> stamps_ns)
      : stamps_ns_(std::move(stamps_ns)), reach_ns_(half_frame_ns(stamps_ns_)) {}

  // Index in `list` by frame: the nearest of each, in order of frames.
  template <typename List, typename Stamp>
  std::map<std::size_t, std::size_t> nearest_of(const List& list, const Stamp& stamp_ns_of) {
    std::map<std::size_t, std::size_t> chosen;
    for (std::size_t i = 0; i < list.size(); ++i) {
      ++all_;
      const std::int64_t stamp_ns = stamp_ns_of(list[i]);
      const std::size_t frame = nearest(stamp_ns);
      if (distance_ns(frame, stamp_ns) > reach_ns_) {
        ++of_none_;
        continue;
      }
      const auto [place, is_new] = chosen.emplace(frame, i);
      if (is_new) continue;
      ++doubled_;
      if (distance_ns(frame, stamp_ns) < distance_ns(frame, stamp_ns_of(list[place->second])))
        place->second = i;
    }
    return chosen;
  }

  std::int64_t stamp_ns(std::size_t frame) const { return stamps_ns_[frame]; }

  void judge(const std::string& name) const {
    if (all_ == 0) throw InputError(fmt::format("{}: holds no pose", name));
    if (of_none_ == all_)
      throw InputError(
          fmt::format("{}: none of its {} poses lies within half a frame of the sequence's stamps ({} to {} "
                      "s): of another "
                      "sequence, clock or unit",
                      name, all_, format_stamp(stamps_ns_.front()), format_stamp(stamps_ns_.back())));
    if (of_none_ > 0)
      warn(fmt::format("{}: {} of {} poses lie at no frame and are left out", name, of_none_, all_));
    if (doubled_ > 0)
      warn(fmt::format("{}: {} of {} poses are left out: another is nearer to their frame", name, doubled_,
                       all_));
  }

 private:
  std::size_t nearest(std::int64_t stamp_ns) const {
    const auto after = std::ranges::lower_bound(stamps_ns_, stamp_ns) - stamps_ns_.begin();
    const auto last = std::ssize(stamps_ns_) - 1;
    const auto right = static_cast<std::size_t>(std::min(after, last));
    const auto left = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - 1, 0));
    return distance_ns(left, stamp_ns) <= distance_ns(right, stamp_ns) ? left : right;
  }
  std::int64_t distance_ns(std::size_t frame, std::int64_t stamp_ns) const {
    return std::abs(stamps_ns_[frame] - stamp_ns);
  }

  std::vector<std::int64_t> stamps_ns_;
  std::int64_t reach_ns_;
  std::size_t all_ = 0, of_none_ = 0, doubled_ = 0;
};

}  // namespace

std::vector<std::int64_t> observed_ns(const Sequence& sequence) {
  if (!sequence.frames.empty() || !sequence.lidar) return stamps_of(sequence.frames);
  std::vector<std::int64_t> ends_ns = stamps_of(sequence.scans);
  for (std::int64_t& stamp_ns : ends_ns) stamp_ns += std::llround(1e9 / sequence.lidar->rate_hz);
  return ends_ns;
}

std::int64_t half_frame_ns(const std::vector<std::int64_t>& observed_ns) {
  return static_cast<std::int64_t>(5e8 / nominal_rate_hz(observed_ns, 1));
}

std::vector<std::string> result_layouts() {
  return {"native", "tum", "kitti-tracking", "bop"};
}

Tracks at_frames(const Tracks& tracks, const Sequence& sequence, const std::string& name) {
  Frames frames(observed_ns(sequence));
  Tracks result;
  result.calibration = tracks.calibration;
  const auto stamp_of = [](const auto& item) { return item.stamp_ns; };
  for (const auto& [frame, i] : frames.nearest_of(tracks.camera, stamp_of))
    result.camera.push_back({frames.stamp_ns(frame), tracks.camera[i].pose});
  for (const ObjectTrack& track : tracks.objects) {
    ObjectTrack placed{track.id, track.name, {}};
    for (const auto& [frame, i] : frames.nearest_of(track.states, stamp_of)) {
      placed.states.push_back(track.states[i]);
      placed.states.back().frame = static_cast<std::int64_t>(frame);
      placed.states.back().stamp_ns = frames.stamp_ns(frame);
    }
    if (!placed.states.empty()) result.objects.push_back(std::move(placed));
  }
  frames.judge(name);
  return result;
}

Tracks read_result(const fs::path& source, const std::string& layout, const Sequence& sequence) {
  const std::string name = source.string();
  if (layout == "tum") return at_frames(read_tum_result(source), sequence, name);
  if (layout == "kitti-tracking") return at_frames(read_kitti_result(source, sequence), sequence, name);
  if (layout == "bop") return at_frames(read_bop_result(source, sequence), sequence, name);
  if (layout == "native") return at_frames(read_tracks(source), sequence, name);
  throw InputError(fmt::format("results in the layout {} cannot be read", layout));
}

}  // namespace uniquadric
