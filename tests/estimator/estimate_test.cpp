#include "estimator/estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <numbers>

#include "box_scene.h"
#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/geometry/box_symmetry.h"
#include "core/sequence/tracks.h"
#include "estimator/lidar/lidar_stream.h"
#include "estimator/observation/outline.h"
#include "estimator/segmentation/check_sequence.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

EstimateOptions quiet(int threads = 0) {
  EstimateOptions options;
  options.quiet = options.force = true;
  options.threads = threads;
  return options;
}

std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != "timing.csv" &&
        entry.path().filename() != "usage.csv")
      files[fs::relative(entry.path(), folder).string()] = read_text(entry.path());
  return files;
}

// Upright boxes around the true masks, one file for all frames.
fs::path write_prompts(const Sequence& sequence) {
  std::string text;
  for (const auto& frame : sequence.frames) {
    const cv::Rect box = id_boxes(read_masks(sequence, frame)).at(1);
    text += format_stamp(frame.stamp_ns) + " " + std::to_string(box.x - 2) + " " + std::to_string(box.y - 2) +
            " " + std::to_string(box.width + 4) + " " + std::to_string(box.height + 4) + "\n";
  }
  const fs::path file = sequence.folder / "prompts.txt";
  write_text(file, text);
  return file;
}

TEST(Estimate, FollowsAMovingBoxFromItsMasks) {
  const TempFolder temp;
  const fs::path folder = temp.path() / "sequence", out = temp.path() / "out";
  write_box_sequence(folder, 6, false);
  estimate(folder, Variant{}, quiet(), out);
  const Tracks tracks = read_tracks(out);
  ASSERT_EQ(tracks.camera.size(), 6u);
  ASSERT_TRUE(tracks.calibration.has_value());
  ASSERT_EQ(tracks.objects.size(), 1u);
  ASSERT_EQ(tracks.objects[0].states.size(), 6u);
  // The mask's rim of 1 px is eroded, 5 mm at this range and focal length and twice that on a face seen at 30
  // degrees; outlier removal takes about as much, the samples' own extents fall short by some millimetres.
  // The baseline's bias.
  const double kSize = 0.025, kAngle = 0.05;
  for (int i = 0; i < 6; ++i) {
    const ObjectState& state = tracks.objects[0].states[i];
    const OrientedBox truth = scene_box(i);
    const Pose& pose = state.ellipsoid.world_from_object;
    EXPECT_EQ(state.frame, i);
    EXPECT_LT((pose.translation - truth.center).norm(), kSize) << i;
    EXPECT_LT((state.ellipsoid.semi_axes_m - truth.half_extents_m).cwiseAbs().maxCoeff(), kSize) << i;
    EXPECT_LT(rotation_angle(truth.axes.transpose() * pose.rotation.toRotationMatrix()), kAngle) << i;
    EXPECT_GT(state.covariance_diagonal.head<3>().minCoeff(), 0);
    EXPECT_LT(state.covariance_diagonal.head<3>().cwiseSqrt().maxCoeff(),
              0.05);  // m: the box has 0.12 to 0.2
    EXPECT_TRUE(state.covariance_diagonal.tail<6>().array().isNaN().all());
  }
}

TEST(Estimate, FramesWithoutDepthMasksOrPoseHaveNoStateAndAreCounted) {
  const TempFolder temp;
  const fs::path folder = temp.path() / "sequence", out = temp.path() / "out";
  Sequence sequence = write_box_sequence(folder, 6, true);
  sequence.given_camera->erase(sequence.given_camera->begin() + 4);
  write_sequence_index(folder, sequence);
  for (const bool carries : {false, true}) {  // with the tracker the frame without masks gets the last one's
    Variant variant;
    variant.perception.aot.enabled = carries;
    estimate(folder, variant, quiet(), out);
    std::vector<std::int64_t> frames;
    const Tracks tracks = read_tracks(out);
    for (const auto& state : tracks.objects.at(0).states) frames.push_back(state.frame);
    EXPECT_EQ(frames,
              carries ? (std::vector<std::int64_t>{0, 1, 3, 5}) : (std::vector<std::int64_t>{0, 1, 5}));
    const ConfigNode run = ConfigNode::load(out / "run.yaml");
    EXPECT_EQ(run.get<int>("frames"), 6);
    EXPECT_EQ(run.get<int>("frames_with_states"), carries ? 4 : 3);
    EXPECT_EQ(run.get<int>("frames_without_depth"), 1);
    EXPECT_EQ(run.get<int>("frames_without_masks"), carries ? 0 : 1);
    EXPECT_EQ(run.get<int>("frames_without_pose"), 1);
  }
}

TEST(Estimate, TheSameBytesForAnyNumberOfThreads) {
  const TempFolder temp;
  const fs::path folder = temp.path() / "sequence", out = temp.path() / "out";
  Sequence sequence = write_box_sequence(folder, 6, false);
  EstimateOptions prompted = quiet();
  prompted.prompts = write_prompts(sequence);
  Variant grabcut;
  grabcut.perception.segmentation.source = "grabcut_depth";
  int compared = 0;
  for (const auto& [variant, prompts] :
       {std::pair{Variant{}, fs::path()}, {grabcut, prompted.prompts.path}}) {
    std::map<std::string, std::string> first;
    for (const int threads : {1, 2, 4}) {
      EstimateOptions options = quiet(threads);
      options.prompts = prompts;
      estimate(folder, variant, options, out);
      if (first.empty()) first = files_of(out);
      EXPECT_EQ(files_of(out), first) << threads << " threads";
      ++compared;
    }
    EXPECT_EQ(first.contains("masks/000000.png"), !prompts.empty());
    EXPECT_TRUE(first.contains("objects/1.tum"));
  }
  EXPECT_EQ(compared, 6);
  EstimateOptions other = quiet();
  other.seed = 1;
  const fs::path out_other = temp.path() / "out_other";
  estimate(folder, Variant{}, quiet(), out);
  estimate(folder, Variant{}, other, out_other);
  EXPECT_NE(read_text(out / "objects.csv"), read_text(out_other / "objects.csv"));
}

TEST(Estimate, TheTruthBesideTheSequenceIsNeverRead) {
  const TempFolder temp;
  const fs::path folder = temp.path() / "sequence", out = temp.path() / "out";
  write_box_sequence(folder / "sequence", 2, false);
  fs::create_directories(folder / "truth");
  write_text(folder / "truth/objects.yaml", "not: [yaml");
  write_text(folder / "truth/camera.tum", "nonsense");
  estimate(folder, Variant{}, quiet(), out);
  const auto with_truth = files_of(out);
  fs::remove_all(folder / "truth");
  estimate(folder / "sequence", Variant{}, quiet(), out);
  EXPECT_EQ(files_of(out), with_truth);
}

TEST(Estimate, NamesThatFollowTheBodyAndNamesOfTheWorld) {
  // A box that turns from 35 to 55 degrees: the world's names change hands at 45, those that follow do not.
  const TempFolder temp;
  const fs::path folder = temp.path() / "sequence", out = temp.path() / "out";
  Sequence sequence = write_box_sequence(folder, 3, false);
  for (int i = 0; i < 3; ++i) {
    OrientedBox box = scene_box(0);
    box.axes = exp_so3({0, 0, (i == 1 ? 47 : 35 + 10 * i) * std::numbers::pi / 180}).toRotationMatrix();
    RandomStream random(7, "turn", i);
    const BoxImage image = render_box(sequence.camera, scene_camera(i), box, random);
    write_png(folder / sequence.frames[i].depth, image.depth);
    write_png(folder / sequence.frames[i].masks, image.mask);
  }
  const auto longest = [&](AxisNaming naming) {
    Variant variant;
    variant.axis_naming = naming;
    estimate(folder, variant, quiet(), out);
    std::vector<int> axes;
    const Tracks tracks = read_tracks(out);
    for (const auto& state : tracks.objects.at(0).states) {
      int axis = 0;
      state.ellipsoid.semi_axes_m.maxCoeff(&axis);
      axes.push_back(axis);
    }
    return axes;
  };
  EXPECT_EQ(longest(AxisNaming::world), (std::vector<int>{0, 1, 1}));
  EXPECT_EQ(longest(AxisNaming::previous), (std::vector<int>{0, 0, 0}));
}

TEST(Estimate, BadInputsAreRefusedAndLeaveNothing) {
  const TempFolder temp;
  const fs::path folder = temp.path() / "sequence", out = temp.path() / "out";
  Sequence sequence = write_box_sequence(folder, 2, false);
  const auto refuses = [&](const std::string& what) {
    try {
      estimate(folder, Variant{}, quiet(), out);
      ADD_FAILURE() << "accepted: " << what;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(what), std::string::npos) << e.what();
    }
    EXPECT_FALSE(fs::exists(out));
    EXPECT_FALSE(fs::exists(out.string() + ".partial"));
  };
  fs::resize_file(folder / sequence.frames[1].depth, 500);
  refuses("000001.png: is a truncated image");
  fs::remove(folder / "camera_given.tum");
  refuses("camera_given.tum: holds no camera poses");
  fs::remove_all(folder);
  refuses("is not a folder");
}

// Nothing at all in common with what the variant needs is a mistake of the caller, not a bad result.
TEST(Estimate, ASequenceWithoutAnythingToEstimateIsRefused) {
  struct Case {
    std::string what;
    std::function<void(Sequence&)> damage;
    Variant variant = {};
    bool prompted = false;
  };
  Variant grabcut;
  grabcut.perception.segmentation.source = "grabcut_depth";
  const auto shift_poses = [](Sequence& s) {
    for (auto& pose : *s.given_camera) pose.stamp_ns += 500'000'000'000;
  };
  const std::vector<Case> cases = {
      {"sequence: no frame has depth", [](Sequence& s) { fs::remove(s.folder / "depth.txt"); }},
      {"sequence: no frame has depth",
       [](Sequence& s) { write_text(s.folder / "depth.txt", "900.0 depth/000000.png\n"); }},
      {"no frame has a camera pose: camera_given.tum spans 501.000000000..501.066666666 s, the frames "
       "1.000000000..1.066666666 s",
       [&](Sequence& s) { shift_poses(s), write_sequence_index(s.folder, s); }},
      {"no frame has masks: the prompts hold no box", [](Sequence&) {}, grabcut, true},
      {"no frame has depth, masks and a camera pose at once",
       [](Sequence& s) {
         for (int i = 0; i < 3; ++i) (i == 0 ? s.frames[i].masks : s.frames[i].depth).clear();
         write_sequence_index(s.folder, s);
       }},
  };
  int refused = 0;
  for (const auto& [what, damage, variant, prompted] : cases) {
    const TempFolder temp;
    const fs::path out = temp.path() / "out";
    Sequence sequence = write_box_sequence(temp.path() / "sequence", 3, false);
    damage(sequence);
    EstimateOptions options = quiet();
    if (prompted) {
      options.prompts = temp.path() / "boxes";
      fs::create_directories(options.prompts.path);
      write_text(options.prompts.path / (format_stamp(sequence.frames[0].stamp_ns) + ".txt"), "\n");
    }
    const std::string message = input_error([&] { estimate(sequence.folder, variant, options, out); });
    EXPECT_NE(message.find(what), std::string::npos) << message;
    EXPECT_FALSE(fs::exists(out));
    ++refused;
  }
  EXPECT_EQ(refused, 5);
}

// A LiDAR and an IMU beside the camera, with scans of one point from `first_ns` on and readings at their
// time; no depth images.
void add_lidar(Sequence& sequence, int scans, std::int64_t first_ns, int readings,
               std::int64_t first_reading_ns) {
  sequence.lidar = LidarCalibration{.pattern = "test", .rate_hz = 10, .camera_from_lidar = {}};
  sequence.imu = ImuCalibration{};
  for (int i = 0; i < scans; ++i) {
    sequence.scans.push_back({first_ns + i * 100'000'000, std::to_string(i) + ".pcd"});
    write_lidar_points(sequence.folder / sequence.scans.back().file, {LidarPoint{.x = 5}});
  }
  std::vector<ImuSample> samples(static_cast<std::size_t>(readings));
  for (int i = 0; i < readings; ++i)
    samples[static_cast<std::size_t>(i)].stamp_ns = first_reading_ns + i * 5'000'000;
  write_imu_csv(sequence.folder / "imu.csv", samples);
  for (SequenceFrame& frame : sequence.frames) frame.depth.clear();
  fs::remove(sequence.folder / "depth.txt");
  write_sequence_index(sequence.folder, sequence);
}

TEST(Estimate, ALidarOrAnImuThatIsEmptyOrOfAnotherTimeIsRefused) {
  constexpr std::int64_t kThen = 1'000'000'000, kLater = 501'000'000'000;  // the frames are from 1 s on
  struct Case {
    std::string what;
    EgoSource ego;
    int scans;
    std::int64_t first_ns;
    int readings;
    std::int64_t first_reading_ns;
  };
  const std::vector<Case> cases = {
      {"lidar.txt: names no scan", EgoSource::given, 0, kThen, 40, kThen},
      {"lidar.txt: names no scan", EgoSource::lidar, 0, kThen, 40, kThen},
      {"lidar.txt: no scan meets a frame: the scans span 501.000000000..501.300000000 s, the frames "
       "1.000000000..1.066666666 s",
       EgoSource::given, 3, kLater, 40, kLater},
      {"lidar.txt: no scan meets a frame", EgoSource::lidar, 3, kLater, 40, kLater},
      {"lidar.txt: no scan meets a frame", EgoSource::lidar, 3, 0, 40, 0},  // over before the first
      {"imu.csv: holds no reading", EgoSource::lidar, 3, kThen, 0, kThen},
      {"imu.csv: no reading meets a scan: the readings span 501.000000000..501.195000000 s, the scans "
       "1.000000000..1.300000000 s",
       EgoSource::lidar, 3, kThen, 40, kLater},
  };
  int refused = 0;
  for (const Case& c : cases) {
    const TempFolder temp;
    const fs::path out = temp.path() / "out";
    Sequence sequence = write_box_sequence(temp.path() / "sequence", 3, false);
    add_lidar(sequence, c.scans, c.first_ns, c.readings, c.first_reading_ns);
    Variant variant;
    variant.perception.ego = c.ego;
    const std::string message = input_error([&] { estimate(sequence.folder, variant, quiet(), out); });
    EXPECT_NE(message.find(c.what), std::string::npos) << message;
    EXPECT_FALSE(fs::exists(out));
    ++refused;
  }
  EXPECT_EQ(refused, 7);
}

TEST(CheckSequence, DepthImagesThatAreAskedForMustBeThereThoughThereIsALidar) {
  const TempFolder temp;
  Sequence sequence = write_box_sequence(temp.path(), 3, false);
  const PromptedSegmenter segmenter;
  const std::map<std::int64_t, Pose> poses = {{sequence.frames[0].stamp_ns, Pose()}};
  check_sequence(sequence, segmenter, poses, false, true);
  for (int i = 1; i < 3; ++i) sequence.frames[i].depth.clear();
  check_sequence(sequence, segmenter, poses, false, true);  // one image is enough
  add_lidar(sequence, 3, sequence.frames[0].stamp_ns, 0, 0);
  check_sequence(sequence, segmenter, poses, false, false);
  for (const bool by_lidar : {false, true}) {
    const std::string message =
        input_error([&] { check_sequence(sequence, segmenter, poses, by_lidar, true); });
    EXPECT_NE(message.find("depth.txt: no frame has a depth image"), std::string::npos) << message;
  }
}

TEST(Estimate, DepthImagesThatAreAskedForMustBeThereThoughThereIsALidar) {
  const TempFolder temp;
  Sequence sequence = write_box_sequence(temp.path() / "sequence", 3, false);
  add_lidar(sequence, 3, sequence.frames[0].stamp_ns, 0, 0);
  Variant variant;
  variant.perception.depth = DepthSource::images;
  EXPECT_NE(input_error([&] {
              estimate(sequence.folder, variant, quiet(), temp.path() / "out");
            }).find("depth.txt"),
            std::string::npos);
}

TEST(CheckSequence, ScansMeetTheFramesByTheClockThatTheOptionsTell) {
  const TempFolder temp;
  Sequence sequence = write_box_sequence(temp.path(), 3, false);
  add_lidar(sequence, 3, 501'000'000'000, 0, 0);
  EXPECT_THROW(require_scans(sequence), InputError);
  EXPECT_NO_THROW(require_scans(on_camera_clock(sequence, 500'000'000'000)));
  EXPECT_THROW(require_scans(on_camera_clock(sequence, 501'000'000'000)), InputError);
  sequence.frames.clear();  // a LiDAR alone
  EXPECT_NO_THROW(require_scans(sequence));
}

}  // namespace
}  // namespace uniquadric
