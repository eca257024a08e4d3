// Recordings of real scenes, where they are beside the project (they are not part of it).
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/import/tum.h"
#include "core/sequence/tracks.h"
#include "estimator/ego/rgbd_odometry.h"
#include "estimator/estimate.h"
#include "estimator/features/features.h"
#include "estimator/perception/depth_bias.h"
#include "evaluation/align/alignment.h"
#include "evaluation/trajectory/trajectory_error.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

fs::path recording(const char* name) {
  return fs::path(UNIQUADRIC_SOURCE_DIR) / "../shared/data" / name;
}

#define SKIP_WITHOUT(name) \
  if (!fs::exists(recording(name))) GTEST_SKIP() << "no recording at ../shared/data/" << name

EstimateOptions quiet_options() {
  EstimateOptions options;
  options.quiet = options.force = true;
  return options;
}

void import_quietly(const fs::path& from, const fs::path& to) {
  ImportTumOptions options;
  options.quiet = options.force = true;
  import_tum(from, options, to);
}

Variant variant_of(const char* file) {
  return load_variant(fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants" / file);
}

// The cabinet's 2D detections, all or every third.
void copy_boxes(const fs::path& boxes, const fs::path& folder, std::size_t step) {
  fs::create_directories(folder);
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(boxes)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i < files.size(); i += step) fs::copy_file(files[i], folder / files[i].filename());
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// From a point to the surface of the box that an ellipsoid fills [m].
double distance_to_box(const Ellipsoid& filling, const Eigen::Vector3d& world) {
  const Eigen::Vector3d p = (filling.world_from_object.inverse() * world).cwiseAbs() - filling.semi_axes_m;
  return std::abs(p.cwiseMax(0).norm() + std::min(0.0, p.maxCoeff()));
}

// Depth that is made worse by a known bias is found to have that much more of it.
TEST(Recordings, ABiasThatIsAddedToDepthIsFound) {
  SKIP_WITHOUT("visp_cube");
  const TempFolder temp;
  import_quietly(recording("visp_cube"), temp.path() / "sequence");
  Sequence sequence = open_sequence(temp.path() / "sequence");
  PerceiveOptions run;
  run.quiet = true;
  const auto bias = [&] {
    return depth_bias(sequence, variant_of("superquadric.yaml").perception, false, run).value_or(DepthBias{});
  };
  const DepthBias as_it_is = bias();
  constexpr double kAdded = 0.01;
  sequence.inverse_depth_bias_per_m = -kAdded;
  const DepthBias worse = bias();
  const double sigma = std::hypot(as_it_is.sigma_per_m, worse.sigma_per_m);
  EXPECT_LT(sigma, 0.01);  // of the prior for both: 0.014
  EXPECT_NEAR(worse.per_m - as_it_is.per_m, kAdded, 3 * sigma);
}

// Per-frame boxes from box prompts agree with each other.
TEST(Recordings, SingleFramesOfACabinetHaveStableAxes) {
  SKIP_WITHOUT("tum_fr3_cabinet");
  const TempFolder temp;
  const fs::path folder = temp.path() / "sequence", out = temp.path() / "out";
  import_quietly(recording("tum_fr3_cabinet"), folder);
  EstimateOptions options = quiet_options();
  options.prompts = temp.path() / "boxes";
  copy_boxes(recording("tum_fr3_cabinet") / "boxes", options.prompts.path, 3);
  estimate(folder, Variant{}, options, out);
  const Tracks tracks = read_tracks(out);
  ASSERT_EQ(tracks.objects.size(), 1u);
  const auto& states = tracks.objects[0].states;
  EXPECT_EQ(states.size(), 18u);  // of the 20 frames asked for, two have no box
  Eigen::Vector3d usual;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> axis;
    for (const auto& state : states) axis.push_back(state.ellipsoid.semi_axes_m[k]);
    usual[k] = median(axis);
  }
  EXPECT_LT((usual - Eigen::Vector3d(0.37, 0.20, 0.25)).cwiseAbs().maxCoeff(),
            0.02);  // m: its size in the depth images
  const auto stable = std::count_if(states.begin(), states.end(), [&](const ObjectState& state) {
    return (state.ellipsoid.semi_axes_m - usual).cwiseAbs().maxCoeff() < 0.03;
  });
  EXPECT_GE(stable, 11);  // of 18; the others see one face or a cut mask, as a single frame may
}

// A cabinet that stands still, seen from camera poses that are given: its size does not change any more at
// the end, and its box lies on the depth points.
TEST(Recordings, ACabinetKeepsItsSizeAndLiesOnItsPoints) {
  SKIP_WITHOUT("tum_fr3_cabinet");
  const TempFolder temp;
  const fs::path folder = temp.path() / "sequence", out = temp.path() / "out";
  import_quietly(recording("tum_fr3_cabinet"), folder);
  EstimateOptions options = quiet_options();
  options.prompts = recording("tum_fr3_cabinet") / "boxes";
  options.perception = temp.path() / "perception";
  Variant variant = variant_of("superquadric.yaml");
  variant.perception.ego = EgoSource::given;
  estimate(folder, variant, options, out);
  const Tracks tracks = read_tracks(out);
  ASSERT_EQ(tracks.objects.size(), 1u);
  const auto& states = tracks.objects[0].states;
  ASSERT_GE(states.size(), 40u);
  Eigen::Array3d sum = Eigen::Array3d::Zero(), squares = sum;
  for (auto state = states.end() - 20; state != states.end(); ++state) {
    sum += state->ellipsoid.semi_axes_m.array();
    squares += state->ellipsoid.semi_axes_m.array().square();
  }
  const Eigen::Array3d mean = sum / 20, deviation = (squares / 20 - mean.square()).max(0).sqrt();
  EXPECT_LT((deviation / mean).maxCoeff(), 0.03);
  const Perception perception(options.perception);
  std::vector<double> distances;
  for (const ObjectState& state : states) {
    const PerceivedFrame frame = perception.read(static_cast<std::size_t>(state.frame));
    for (const BodyObservation& body : frame.bodies)
      for (const auto& point : body.points.colwise())
        distances.push_back(
            distance_to_box(state.ellipsoid, *frame.world_from_camera * Eigen::Vector3d(point)));
  }
  ASSERT_GT(distances.size(), 10'000u);
  RecordProperty("median_distance_mm", std::to_string(1e3 * median(distances)));
  EXPECT_LT(median(distances), 0.02);
}

// The camera by itself, without any object, against the poses that came with the recording.
TEST(Recordings, ARoomIsFollowedWithinTwoCentimetres) {
  SKIP_WITHOUT("seven_scenes_50");
  const TempFolder temp;
  import_quietly(recording("seven_scenes_50"), temp.path() / "sequence");
  const Sequence sequence = open_sequence(temp.path() / "sequence");
  FeatureTracker tracker(sequence.camera, {}, 0);
  RgbdOdometry odometry(sequence.camera, {}, 0);
  for (const SequenceFrame& frame : sequence.frames) {
    const cv::Mat depth = read_depth(sequence, frame);
    odometry.track(frame, tracker.track(frame, read_rgb(sequence, frame), depth, {}), depth, {});
  }
  const Trajectory estimated = odometry.trajectory(), &reference = sequence.given_camera.value();
  ASSERT_EQ(estimated.size(), 50u);
  PosePairs pairs;
  for (std::size_t i = 0; i < 50; ++i) {
    pairs.stamps_ns.push_back(estimated[i].stamp_ns);
    pairs.estimate.push_back(estimated[i].pose);
    pairs.reference.push_back(reference.at(i).pose);
    ASSERT_EQ(estimated[i].stamp_ns, reference[i].stamp_ns);
  }
  const double turn_deg = 180 / std::numbers::pi * maximum_drift(pairs).value().max_angle_rad;
  RecordProperty("drift_deg", std::to_string(turn_deg));
  // 5.2 of the 31.6 degrees that it turns, nearly all of it too little. The recording's 585 px are its depth
  // camera's focal length; the colour camera, where features are followed, has about 527 px and stands 25 mm
  // beside it. Registering the depth leaves 3.6 degrees by these two numbers, 1.3 by ten fitted to the
  // reference. As recorded no odometry can be right: the limit is the present error with a little room, so
  // that a worse one is seen.
  EXPECT_LT(turn_deg, 5.5);
  const Alignment alignment = align(AlignmentKind::se3, pairs.reference, pairs.estimate);
  for (Pose& pose : pairs.estimate) pose = alignment * pose;
  double squares = 0;
  for (std::size_t i = 0; i < 50; ++i)
    squares += (pairs.estimate[i].translation - pairs.reference[i].translation).squaredNorm();
  RecordProperty("ate_mm", std::to_string(1e3 * std::sqrt(squares / 50)));
  EXPECT_LT(std::sqrt(squares / 50), 0.02);
}

}  // namespace
}  // namespace uniquadric
