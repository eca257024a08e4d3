// How well the camera is followed: ego_accuracy SEQUENCE [REFERENCE.tum [ESTIMATE.tum]]. Without a reference
// the poses that the sequence carries. Times are those of the processor, with OpenCV on one thread.
#include <fmt/format.h>

#include <opencv2/core/utility.hpp>

#include "benchmarks/ego_pairs.h"
#include "core/base/error.h"
#include "core/sequence/sequence.h"
#include "estimator/ego/rgbd_odometry.h"
#include "estimator/features/features.h"
#include "evaluation/align/alignment.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {
namespace {

void run(const std::filesystem::path& folder, const char* reference_file, const char* out) {
  cv::setNumThreads(1);
  const Sequence sequence = open_sequence(folder);
  const Trajectory reference = reference_file ? read_tum(reference_file) : sequence.given_camera.value();
  FeatureTracker tracker(sequence.camera, {}, 0);
  RgbdOdometry odometry(sequence.camera, {}, 0);
  double feature_ms = 0, ego_ms = 0;
  std::vector<StampedPose> online;
  for (const SequenceFrame& frame : sequence.frames) {
    const cv::Mat rgb = read_rgb(sequence, frame);
    const cv::Mat depth = frame.depth.empty() ? cv::Mat() : read_depth(sequence, frame);
    const cv::Mat masks = frame.masks.empty() ? cv::Mat() : read_masks(sequence, frame);
    const double start = now_ms();
    const TrackedFeatures features = tracker.track(frame, rgb, depth, masks);
    const double middle = now_ms();
    odometry.track(frame, features, depth, masks);
    feature_ms += middle - start;
    ego_ms += now_ms() - middle;
    if (const auto pose = odometry.pose()) online.push_back({frame.stamp_ns, *pose});
  }
  const double start = now_ms();
  const Trajectory trajectory = odometry.trajectory();
  const double final_ms = now_ms() - start;
  if (out) write_tum(out, trajectory);
  fmt::print("{}: {} frames, features {:.1f} ms, ego {:.1f} ms a frame, {:.0f} ms at the end\n",
             sequence.name, sequence.frames.size(), feature_ms / double(sequence.frames.size()),
             ego_ms / double(sequence.frames.size()), final_ms);
  for (const auto& [name, estimate] : {std::pair{"online", online}, {"final", trajectory}}) {
    PosePairs pairs = pairs_of(reference, estimate);
    fmt::print("  {:6}: {} poses", name, pairs.size());
    if (pairs.size() < kMinPairs) {
      fmt::print("\n");
      continue;
    }
    const double path = path_m(pairs);
    const auto drift = *maximum_drift(pairs);
    const double tilt =
        std::acos(std::min(1.0, (pairs.reference[0].rotation *
                                 (pairs.estimate[0].rotation.conjugate() * Eigen::Vector3d::UnitZ()))
                                    .z()));
    const Alignment alignment = align(AlignmentKind::se3, pairs.reference, pairs.estimate);
    for (Pose& pose : pairs.estimate) pose = alignment * pose;
    const auto errors = absolute_errors(pairs);
    fmt::print(
        ", path {:.2f} m, ATE {:.2f} mm ({:.3f} %), {:.2f} mrad; drift {:.1f} mm {:.2f} mrad; tilt {:.1f} "
        "mrad\n",
        path, 1e3 * rms(translations_m(errors)), 100 * rms(translations_m(errors)) / path,
        1e3 * rms(rotations_rad(errors)), 1e3 * drift.max_translation_m, 1e3 * drift.max_angle_rad,
        1e3 * tilt);
  }
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: ego_accuracy SEQUENCE [REFERENCE.tum [ESTIMATE.tum]]\n");
    return 2;
  }
  uniquadric::run(argv[1], argc > 2 ? argv[2] : nullptr, argc > 3 ? argv[3] : nullptr);
}
