// How well a camera is followed by LiDAR: lidar_ego_accuracy VARIANT.yaml SEQUENCE REFERENCE.tum
// [ESTIMATE.tum [DROP_FROM_S DROP_TO_S]]. Scans that start in the given time are dropped. Times are those of
// the processor.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "benchmarks/ego_pairs.h"
#include "core/sequence/sequence.h"
#include "estimator/ego/lidar_ego.h"
#include "estimator/lidar/lidar_stream.h"
#include "estimator/variant.h"
#include "evaluation/align/alignment.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {
namespace {

// On a straight path the positions leave the turn about it open, and the first pose tells it.
Alignment closest(const PosePairs& pairs) {
  try {
    return align(AlignmentKind::se3, pairs.reference, pairs.estimate);
  } catch (const OpenAlignment&) {
    return align(AlignmentKind::first, pairs.reference, pairs.estimate);
  }
}

void show(PosePairs pairs) {
  std::vector<IndexStep> steps;
  for (std::size_t i = 1; i < pairs.size(); ++i) steps.push_back({i - 1, i});
  const double path = path_m(pairs);
  const auto relative = relative_errors(pairs, steps);
  const auto drift = *maximum_drift(pairs);
  const Alignment alignment = closest(pairs);
  for (Pose& pose : pairs.estimate) pose = alignment * pose;
  const auto errors = absolute_errors(pairs);
  const double end = (pairs.estimate.back().translation - pairs.reference.back().translation).norm();
  fmt::print(
      "  {} poses, path {:.2f} m, ATE {:.1f} mm {:.2f} mrad, RPE {:.2f} mm {:.3f} mrad, drift {:.1f} mm "
      "({:.2f} % of the "
      "path) {:.2f} mrad, end {:.1f} mm\n",
      pairs.size(), path, 1e3 * rms(translations_m(errors)), 1e3 * rms(rotations_rad(errors)),
      1e3 * rms(translations_m(relative)), 1e3 * rms(rotations_rad(relative)), 1e3 * drift.max_translation_m,
      100 * drift.max_translation_m / path, 1e3 * drift.max_angle_rad, 1e3 * end);
}

void run(int argc, char** argv) {
  const Variant variant = load_variant(argv[1]);
  Sequence sequence = on_camera_clock(open_sequence(argv[2]), variant.perception.lidar_time_offset_ns);
  if (argc > 6)
    std::erase_if(sequence.scans, [&](const SequenceScan& scan) {
      const double time_s = double(scan.stamp_ns) * 1e-9;
      return time_s >= std::atof(argv[5]) && time_s < std::atof(argv[6]);
    });
  LidarEgo ego(sequence, variant.perception.lidar);
  double ms = 0, longest_ms = 0;  // the beginning: the first sweeps, many times
  for (const SequenceFrame& frame : sequence.frames) {
    const cv::Mat masks = frame.masks.empty() ? cv::Mat() : read_masks(sequence, frame);
    const double start = now_ms();
    ego.track(frame, masks);
    const double took = now_ms() - start;
    ms += took;
    longest_ms = std::max(longest_ms, took);
  }
  ego.finish();
  double points = 0, planes = 0, bodies = 0, off = 0;
  const auto& reports = ego.odometry().reports();
  for (const SweepReport& report : reports) {
    points += report.points, planes += report.on_planes, bodies += report.on_bodies;
    off += report.rms_m;
  }
  const double n = double(reports.size());
  if (reports.empty()) return fmt::print("{}: no start\n", sequence.name);
  const double length_s = double(reports.back().end_ns - reports.front().end_ns) * 1e-9;
  fmt::print(
      "{}: {} sweeps of {:.0f} points, {:.0f} on planes within {:.1f} mm, {:.0f} on bodies; {:.1f} s to "
      "begin, "
      "{:.1f} ms a sweep, {:.1f} times real time besides; {} blocks\n",
      sequence.name, n, points / n, planes / n, 1e3 * off / n, bodies / n, 1e-3 * longest_ms,
      (ms - longest_ms) / n, 1e3 * length_s / (ms - longest_ms), ego.odometry().map_blocks());
  const Trajectory trajectory = ego.trajectory();
  if (argc > 4) write_tum(argv[4], trajectory);
  const PosePairs pairs = pairs_of(read_tum(argv[3]), trajectory);
  if (pairs.size() < kMinPairs)
    fmt::print("  {} poses\n", pairs.size());
  else
    show(pairs);
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(
        stderr,
        "usage: lidar_ego_accuracy VARIANT.yaml SEQUENCE REFERENCE.tum [ESTIMATE.tum [FROM_S TO_S]]\n");
    return 2;
  }
  uniquadric::run(argc, argv);
}
