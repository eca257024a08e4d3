#include "harness/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <set>

#include "core/base/error.h"
#include "core/base/folder_hashes.h"
#include "core/sequence/depth_scale.h"
#include "core/sequence/imu_faults.h"
#include "core/sequence/stamps.h"
#include "core/sequence/tracks.h"
#include "estimator/plausibility/plausibility.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Problems = std::vector<std::string>;

constexpr double kRateTolerance = 0.01;  // ours: relative; stamps of recordings are rounded to 0.1 ms or so
constexpr double kMostCutOff = 0.01;     // ours: of a depth image's pixels; recordings have up to 0.2 %
constexpr double kGap = 1.5;             // ours: periods; more than that and something is missing

void add(Problems& problems, const fs::path& path, const std::string& what) {
  problems.push_back(path.string() + ": " + what);
}

// Runs what may throw InputError; its message is the problem.
template <typename Action>
void attempt(Problems& problems, const Action& action) {
  try {
    action();
  } catch (const InputError& e) {
    problems.push_back(e.what());
  }
}

// Whether the stamps come at the rate: their median interval, and none much longer.
void check_rate(const fs::path& path, const std::vector<std::int64_t>& stamps_ns, double rate_hz,
                bool may_have_gaps, Problems& problems) {
  if (stamps_ns.size() < 2) return;
  std::vector<double> periods;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i)
    periods.push_back(static_cast<double>(stamps_ns[i] - stamps_ns[i - 1]) * 1e-9 * rate_hz);
  const auto gaps = std::count_if(periods.begin(), periods.end(), [](double p) { return p > kGap; });
  const auto middle = periods.begin() + std::ssize(periods) / 2;
  std::nth_element(periods.begin(), middle, periods.end());
  if (std::abs(*middle - 1) > kRateTolerance)
    add(problems, path,
        fmt::format("comes at {:.4g} Hz, sequence.yaml says {:.4g}", rate_hz / *middle, rate_hz));
  if (gaps > 0 && !may_have_gaps)
    add(problems, path, fmt::format("{} gaps of more than {} periods", gaps, kGap));
}

bool is_recording(const Sequence& sequence) {
  return sequence.scene_hash.empty();  // whose sensors drop frames
}

void check_calibration(const Sequence& sequence, Problems& problems) {
  for (const std::string& fault : calibration_faults(sequence.camera))
    add(problems, sequence.folder / "sequence.yaml", fault);
}

void check_depth(const Sequence& sequence, const SequenceFrame& frame, Problems& problems) {
  read_depth(sequence, frame);  // throws for what cannot be used
  const fs::path path = sequence.folder / frame.depth;
  const cv::Mat units = read_image(path);
  if (cv::countNonZero(units) == 0) add(problems, path, "has no depth at any pixel");
  // a sensor says of some pixels so that it gave up
  if (const int full = cv::countNonZero(units == kDepthCutOff);
      full > kMostCutOff * static_cast<double>(units.total()))
    add(problems, path, fmt::format("is cut off at the 16 bits' end at {} pixels", full));
}

void check_frames(const Sequence& sequence, Problems& problems) {
  for (const SequenceFrame& frame : sequence.frames) {
    attempt(problems, [&] { read_rgb(sequence, frame); });
    if (!frame.depth.empty()) attempt(problems, [&] { check_depth(sequence, frame, problems); });
    if (!frame.masks.empty()) attempt(problems, [&] { read_masks(sequence, frame); });
    if (!frame.masks.empty() && frame.masks_arrival_ns < frame.stamp_ns)
      add(problems, sequence.folder / frame.masks, "arrives before its image is taken");
  }
}

// Files that lie in the folders of the lists but that no list names. Depth images that belong to no colour
// image within the rule's 0.02 s are no problem: recordings have them.
void check_unlisted(const Sequence& sequence, Problems& problems) {
  std::set<fs::path> listed;
  for (const SequenceFrame& frame : sequence.frames) listed.insert({frame.rgb, frame.masks});
  for (const SequenceScan& scan : sequence.scans) listed.insert(scan.file);
  for (const char* name : {"rgb", "masks", "lidar"}) {
    if (!fs::is_directory(sequence.folder / name)) continue;
    std::set<fs::path> files;
    for (const auto& entry : fs::directory_iterator(sequence.folder / name))
      files.insert(fs::path(name) / entry.path().filename());
    for (const fs::path& file : files)
      if (!listed.contains(file)) add(problems, sequence.folder / file, "stands in no list");
  }
}

// `widest_ns`: that the times of a scan's points span, so far.
void check_scan(const Sequence& sequence, const SequenceScan& scan, std::int64_t& widest_ns,
                Problems& problems) {
  const fs::path path = sequence.folder / scan.file;
  const auto period_ns = 1e9 / sequence.lidar->rate_hz;
  std::int64_t late = 0, infinite = 0;
  const std::vector<LidarPoint> points = read_lidar_points(path);
  const auto [first, last] = std::minmax_element(
      points.begin(), points.end(), [](const auto& a, const auto& b) { return a.offset_ns < b.offset_ns; });
  if (!points.empty()) widest_ns = std::max(widest_ns, std::int64_t{last->offset_ns} - first->offset_ns);
  for (const LidarPoint& p : points) {
    late += p.offset_ns > (1 + kRateTolerance) * period_ns;
    infinite += !std::isfinite(p.x + p.y + p.z);
  }
  if (late > 0) add(problems, path, fmt::format("{} points come after the scan's end", late));
  if (infinite > 0) add(problems, path, fmt::format("{} points are not finite", infinite));
}

void check_lidar(const Sequence& sequence, Problems& problems) {
  if (!sequence.lidar) return;
  const fs::path list = sequence.folder / "lidar.txt";
  const auto period_ns = static_cast<std::int64_t>(std::llround(1e9 / sequence.lidar->rate_hz));
  if (sequence.scans.empty()) {  // right for a sequence that is shorter than a scan
    if (sequence.frames.back().stamp_ns - sequence.frames.front().stamp_ns >= period_ns)
      add(problems, list, "names no scan");
    return;
  }
  const bool has_frames = !sequence.frames.empty();  // a LiDAR may be alone
  const std::int64_t first_ns = has_frames ? sequence.frames.front().stamp_ns - period_ns : 0;
  const std::int64_t last_ns = has_frames ? sequence.frames.back().stamp_ns : 0;
  std::int64_t widest_ns = 0;
  for (const SequenceScan& scan : sequence.scans) {
    if (has_frames && (scan.stamp_ns < first_ns || scan.stamp_ns > last_ns))
      add(problems, sequence.folder / scan.file, "was taken before the first frame or after the last");
    attempt(problems, [&] { check_scan(sequence, scan, widest_ns, problems); });
  }
  if (const auto fault = point_times_fault(widest_ns, sequence.lidar->rate_hz)) add(problems, list, *fault);
  check_rate(list, stamps_of(sequence.scans), sequence.lidar->rate_hz, is_recording(sequence), problems);
}

void check_imu(const Sequence& sequence, Problems& problems) {
  if (!sequence.imu) return;
  const fs::path path = sequence.folder / "imu.csv";
  const std::vector<ImuSample> samples = read_imu_csv(path);
  if (samples.empty()) return add(problems, path, "has no sample");
  check_rate(path, stamps_of(samples), sequence.imu->rate_hz, is_recording(sequence), problems);
  // Scans want readings all their time; the sensors of a recording start and end one by one.
  const bool has_scans = !sequence.scans.empty();
  const std::int64_t first_ns = has_scans ? sequence.scans.front().stamp_ns : samples.front().stamp_ns;
  const std::int64_t last_ns =
      has_scans ? sequence.scans.back().stamp_ns + std::llround(1e9 / sequence.lidar->rate_hz)
                : samples.back().stamp_ns;
  for (const std::string& fault : imu_faults(samples, *sequence.imu, first_ns, last_ns))
    add(problems, path, fault);
  if (sequence.frames.empty() || is_recording(sequence)) return;  // which start and end sensor by sensor
  if (samples.front().stamp_ns > sequence.frames.front().stamp_ns ||
      samples.back().stamp_ns < sequence.frames.back().stamp_ns)
    add(problems, path, "does not cover the frames");
}

void check_observations(const Sequence& sequence, Problems& problems) {
  check_rate(sequence.folder / "rgb.txt", stamps_of(sequence.frames), sequence.rate_hz,
             is_recording(sequence), problems);
  check_calibration(sequence, problems);
  check_unlisted(sequence, problems);
  check_frames(sequence, problems);
  if (const auto fault = depth_scale_fault(sequence))
    add(problems, sequence.folder / "sequence.yaml", *fault);
  check_lidar(sequence, problems);
  attempt(problems, [&] { check_imu(sequence, problems); });
}

}  // namespace

std::vector<std::string> check_sequence(const fs::path& folder) {
  const bool is_truth = !fs::exists(folder / "sequence.yaml") && fs::exists(folder / "objects.yaml");
  const fs::path parent = fs::weakly_canonical(folder).parent_path();
  Problems problems;
  if (is_truth && !fs::exists(parent / "sequence/sequence.yaml")) {
    attempt(problems, [&] { read_tracks(folder); });
    for (const std::string& problem : check_hashes(folder)) problems.push_back(problem);
    return problems;
  }
  attempt(problems, [&] {
    const Sequence sequence = open_sequence(is_truth ? parent / "sequence" : folder);
    const fs::path truth = fs::weakly_canonical(sequence.folder).parent_path() / "truth";
    check_observations(sequence, problems);
    if (fs::is_directory(truth)) attempt(problems, [&] { check_truth(sequence, truth, problems); });
    for (const fs::path& hashed : {sequence.folder, truth})
      for (const std::string& problem : check_hashes(hashed)) problems.push_back(problem);
  });
  return problems;
}

std::vector<std::string> check_plausibility(const fs::path& folder) {
  try {
    return suspicions(open_sequence(folder), {});
  } catch (const InputError&) {  // check_sequence tells it
    return {};
  }
}

}  // namespace uniquadric
