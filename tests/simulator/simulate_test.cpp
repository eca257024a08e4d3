#include "simulator/simulate.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <map>
#include <opencv2/core.hpp>
#include <thread>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/folder_hashes.h"
#include "core/base/text.h"
#include "core/sequence/lidar.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "simulator/lidar_files.h"
#include "simulator/noise/segmenter.h"
#include "tests/simulator/simple_scene.h"
#include "tests/simulator/simulate_quietly.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

using Files = std::map<std::string, std::string>;  // relative path -> content

Files read_folder(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = read_text(entry.path());
  return files;
}

// 4 images a frame; rgb.txt, depth.txt, masks.txt, sequence.yaml, camera_given.tum; camera.tum, camera.yaml,
// objects.yaml, visibility.csv, map.bt, trajectory and mesh of 2 objects; two lists of hashes
constexpr std::size_t kFiles = 4 * 12 + 5 + 9 + 2 + 1;

TEST(Simulate, WritesASequenceAndItsTruth) {
  const TempFolder temp;
  const Scene scene = two_boxes();
  simulate(scene, quiet(), temp.path() / "out");
  EXPECT_EQ(std::distance(fs::directory_iterator(temp.path()), {}), 1);  // nothing beside it
  EXPECT_EQ(read_folder(temp.path() / "out").size(), kFiles);

  const Sequence sequence = open_sequence(temp.path() / "out/sequence");
  ASSERT_EQ(sequence.frames.size(), 12u);
  EXPECT_EQ(sequence.scene_hash, scene.hash);
  EXPECT_EQ(sequence.frames[3].masks_arrival_ns - sequence.frames[3].stamp_ns, 100'000'000);
  ASSERT_TRUE(sequence.given_camera);
  const Tracks truth = read_tracks(temp.path() / "out/truth");
  ASSERT_EQ(truth.objects.size(), 2u);
  EXPECT_EQ(truth.objects[1].id, 300);
  EXPECT_EQ(ConfigNode::load(temp.path() / "out/truth/objects.yaml").get<std::string>("scene_hash"),
            scene.hash);
  EXPECT_EQ(truth.objects[1].states[7].ellipsoid.semi_axes_m, scene.objects[1].semi_axes_m);
  EXPECT_EQ(truth.objects[1].states[7].ellipsoid.world_from_object.translation,
            scene.objects[1].motion.at(0.7).translation);
}

// Slow ones hold up those behind; the others keep the time that the segmenter takes for them.
TEST(Simulate, MasksArriveInTheOrderOfTheirFrames) {
  const TempFolder temp;
  Scene scene = two_boxes();
  scene.rate_hz = 30;
  scene.segmenter.latency_s = scene.segmenter.latency_sigma_s = 0.1;
  scene.segmenter.outage_every_s = 4;
  scene.frames = 150;
  scene.camera = {32, 24, 28, 28, 15.5, 11.5, {}};
  simulate(scene, quiet(2, 3), temp.path() / "out");
  std::int64_t last_ns = 0;
  int waiting = 0, masks = 0;
  for (const SequenceFrame& frame : open_sequence(temp.path() / "out/sequence").frames) {
    if (frame.masks.empty()) continue;
    ++masks;
    const std::int64_t alone_ns =
        frame.stamp_ns + std::llround(latency_s(scene.segmenter, 3, frame.frame) * 1e9);
    EXPECT_EQ(frame.masks_arrival_ns, std::max(last_ns, alone_ns)) << frame.frame;
    EXPECT_GT(frame.masks_arrival_ns, frame.stamp_ns);
    waiting += alone_ns < last_ns;
    last_ns = frame.masks_arrival_ns;
  }
  EXPECT_GT(waiting, masks / 5);
  EXPECT_LT(waiting, masks);
}

TEST(Simulate, DepthImagesHoldTheRenderedDepthWithinTheirNoise) {
  const TempFolder temp;
  Scene scene = two_boxes();
  scene.depth_noise.model = DepthNoise::Model::none;
  simulate(scene, quiet(), temp.path() / "out");
  const Sequence sequence = open_sequence(temp.path() / "out/sequence");
  EXPECT_EQ(sequence.depth_units_per_m, 1000);  // 20 m do not fit into 5000 units a metre
  const cv::Mat written_m = read_depth(sequence, sequence.frames[5]);
  const cv::Mat exact_m = Renderer(scene).render(poses_at(scene, 0.5)).depth_m;
  const double half_a_unit_m = 0.5 / sequence.depth_units_per_m;
  EXPECT_LT(cv::norm(written_m, exact_m, cv::NORM_INF), half_a_unit_m * 1.001);  // float rounding
  EXPECT_EQ(cv::norm(read_image(temp.path() / "out/truth/instances/000005.png"),
                     Renderer(scene).render(poses_at(scene, 0.5)).ids, cv::NORM_INF),
            0);
}

TEST(Simulate, ThreadsDoNotChangeAByte) {
  const TempFolder temp;
  const Scene scene = two_boxes();
  simulate(scene, quiet(1), temp.path() / "one");
  simulate(scene, quiet(2), temp.path() / "two");
  simulate(scene, quiet(5), temp.path() / "five");
  const Files one = read_folder(temp.path() / "one");
  EXPECT_EQ(one.size(), kFiles);
  EXPECT_TRUE(one == read_folder(temp.path() / "two"));
  EXPECT_TRUE(one == read_folder(temp.path() / "five"));
}

TEST(Simulate, SeedChangesTheNoiseAndNothingOfTheTruth) {
  const TempFolder temp;
  const Scene scene = two_boxes();
  simulate(scene, quiet(2, 1), temp.path() / "a");
  simulate(scene, quiet(2, 2), temp.path() / "b");
  EXPECT_TRUE(read_folder(temp.path() / "a/truth") == read_folder(temp.path() / "b/truth"));
  const Files a = read_folder(temp.path() / "a/sequence"), b = read_folder(temp.path() / "b/sequence");
  int compared = 0;
  for (const auto& [name, content] : a)
    if (name.ends_with(".png")) {
      EXPECT_NE(content, b.at(name)) << name;
      ++compared;
    }
  EXPECT_EQ(compared, 36);
}

TEST(Simulate, KilledAndResumedGivesTheSameBytes) {
  const TempFolder temp;
  Scene scene = two_boxes();
  scene.frames = 60;
  const fs::path out = temp.path() / "out", partial = temp.path() / "out.partial";
  const pid_t child = fork();
  if (child == 0) {
    simulate(scene, quiet(2), out);
    _exit(0);
  }
  const auto frames_done = [&] {
    if (!fs::exists(partial / "frames.log")) return std::ptrdiff_t{0};
    const std::string log = read_text(partial / "frames.log");
    return std::count(log.begin(), log.end(), '\n') / 3;  // a line, and one for each of two objects
  };
  for (int i = 0; i < 10000 && frames_done() < 10; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  ASSERT_FALSE(fs::exists(out)) << "the child was done before it was killed";
  const auto done = frames_done();
  ASSERT_GE(done, 10);

  const std::string log = read_text(partial / "frames.log");
  const auto first = parse_integer(std::string_view(log).substr(0, log.find(' ')));
  const fs::path kept = fmt::format("sequence/rgb/{:06}.png", first.value());
  const auto written = fs::last_write_time(partial / kept);
  for (int i = 0; i < 1000 && !fs::exists(out); ++i) try {
      simulate(scene, quiet(2), out);
    } catch (const InputError&) {  // the child's workers, which die with it, still hold the folder
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  EXPECT_EQ(fs::last_write_time(out / kept), written);  // not made again
  simulate(scene, quiet(2), temp.path() / "undisturbed");
  EXPECT_TRUE(read_folder(out) == read_folder(temp.path() / "undisturbed"));
}

Scene two_boxes_with_lidar(std::int64_t frames) {
  Scene scene = two_boxes();
  scene.frames = frames;
  scene.lidar = ConfigNode::parse("pattern: livox_avia", "scene.yaml");
  return scene;
}

TEST(Simulate, SeedChangesTheNoiseOfTheLidarAndNothingOfItsTruth) {
  const TempFolder temp;
  const Scene scene = two_boxes_with_lidar(5);
  simulate(scene, quiet(1, 1), temp.path() / "a");
  simulate(scene, quiet(2, 1), temp.path() / "same");
  simulate(scene, quiet(2, 2), temp.path() / "b");
  EXPECT_TRUE(read_folder(temp.path() / "a") == read_folder(temp.path() / "same"));
  // Which beams return is noise too: the points' truth is compared where both have the beam.
  Files a = read_folder(temp.path() / "a/truth"), b = read_folder(temp.path() / "b/truth");
  int scans = 0;
  for (Files* files : {&a, &b}) files->erase(kHashesFile);
  std::erase_if(a, [](const auto& file) { return file.first.starts_with("lidar/"); });
  scans +=
      static_cast<int>(std::erase_if(b, [](const auto& file) { return file.first.starts_with("lidar/"); }));
  EXPECT_EQ(scans, 4);
  EXPECT_TRUE(a == b);
  for (int k = 0; k < scans; ++k) {
    const fs::path scan = fmt::format("sequence/lidar/{:06}.pcd", k);
    EXPECT_NE(read_text(temp.path() / "a" / scan), read_text(temp.path() / "b" / scan));
  }
}

// Two scenes of a bench with one seed do not miss their masks in the same frames.
TEST(Simulate, TheScenesNoiseSeedChangesItsNoiseAsAnotherSeedDoes) {
  const TempFolder temp;
  Scene scene = two_boxes_with_lidar(5);
  EXPECT_EQ(scene.stream_seed(1), 1u);
  simulate(scene, quiet(2, 1), temp.path() / "a");
  scene.noise_seed = 7;
  EXPECT_NE(scene.stream_seed(1), scene.stream_seed(2));
  simulate(scene, quiet(2, 1), temp.path() / "b");
  const Files a = read_folder(temp.path() / "a/sequence"), b = read_folder(temp.path() / "b/sequence");
  EXPECT_EQ(a.at("sequence.yaml"), b.at("sequence.yaml"));  // names the seed that was given
  int compared = 0;
  for (const auto& [name, content] : a)
    if (name.ends_with(".png") || name.ends_with(".pcd")) {
      EXPECT_NE(content, b.at(name)) << name;
      ++compared;
    }
  EXPECT_EQ(compared, 3 * 5 + 4);
  EXPECT_EQ(read_text(temp.path() / "a/truth/objects.yaml"), read_text(temp.path() / "b/truth/objects.yaml"));
}

TEST(Simulate, KilledAmongTheScansAndResumedGivesTheSameBytes) {
  const TempFolder temp;
  const Scene scene = two_boxes_with_lidar(60);
  const fs::path out = temp.path() / "out", partial = temp.path() / "out.partial";
  const pid_t child = fork();
  if (child == 0) {
    simulate(scene, quiet(1), out);
    _exit(0);
  }
  const fs::path kept = "sequence/lidar/000000.pcd";
  for (int i = 0; i < 60000 && !fs::exists(partial / kept) && !fs::exists(out); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  ASSERT_FALSE(fs::exists(out)) << "the child was done before it was killed";
  const auto written = fs::last_write_time(partial / kept);
  simulate(scene, quiet(2), out);
  EXPECT_EQ(fs::last_write_time(out / kept), written);  // not made again
  simulate(scene, quiet(2), temp.path() / "undisturbed");
  EXPECT_TRUE(read_folder(out) == read_folder(temp.path() / "undisturbed"));
}

TEST(Simulate, TimingSaysWhatEachStageTookAndStandsApart) {
  const TempFolder temp;
  SimulateOptions options = quiet(1);
  options.timing = temp.path() / "timing.csv";
  simulate(two_boxes_with_lidar(5), options, temp.path() / "out");
  std::vector<std::string> stages;
  for_each_line(
      options.timing,
      [&](int, const std::vector<std::string_view>& fields) {
        ASSERT_EQ(fields.size(), 3u);
        stages.push_back(fmt::format("{} {}", fields[0], fields[1]));
      },
      ',');
  EXPECT_EQ(stages, (std::vector<std::string>{"stage count", "frames 5", "first_frame 1", "frame_draw 4",
                                              "frame_color 4", "frame_depth 4", "frame_masks 4",
                                              "frame_write 4", "truth_and_imu 1", "lidar 4", "hashes 1"}));
  options.timing = temp.path() / "none/timing.csv";
  EXPECT_NE(input_error([&] { simulate(two_boxes(), options, temp.path() / "late"); }).find("does not exist"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(temp.path() / "late"));
}

TEST(Simulate, PartialWorkOfAnotherSeedIsNotUsed) {
  const TempFolder temp;
  const Scene scene = two_boxes();
  const fs::path partial = temp.path() / "out.partial";
  simulate(scene, quiet(), temp.path() / "expected");
  for (const char* key : {"another key", ""}) {
    { const PendingFolder left_behind(temp.path() / "out", "simulation", false, true); }
    write_text(partial / "key", key);
    write_text(partial / "frames.log", "0 1\nwrong\n");
    write_text(partial / "stray", "stray");
    simulate(scene, quiet(), temp.path() / "out");
    EXPECT_TRUE(read_folder(temp.path() / "out") == read_folder(temp.path() / "expected"));
    fs::remove_all(temp.path() / "out");
  }
}

TEST(Simulate, VisibilityCountsTheExactMasks) {
  const TempFolder temp;
  const Scene scene = two_boxes();
  simulate(scene, quiet(), temp.path() / "out");
  int rows = 0;
  double least = 1;
  for_each_line(
      temp.path() / "out/truth/instances/visibility.csv",
      [&](int line, const std::vector<std::string_view>& fields) {
        if (line == 1) {
          EXPECT_EQ(fields.at(5), "visible_fraction");
          return;
        }
        ASSERT_EQ(fields.size(), 7u);
        const auto frame = parse_integer(fields[0]).value();
        EXPECT_EQ(frame, rows / 2);
        EXPECT_EQ(parse_integer(fields[1]), scene.stamp_ns(frame));
        const cv::Mat ids = read_image(temp.path() / "out/truth/instances" / fmt::format("{:06}.png", frame));
        const double id = static_cast<double>(parse_integer(fields[2]).value());
        const double visible = parse_double(fields[3]).value(), silhouette = parse_double(fields[4]).value();
        EXPECT_EQ(visible, cv::countNonZero(ids == id));
        EXPECT_EQ(parse_double(fields[5]), silhouette > 0 ? visible / silhouette : 0);
        least = std::min(least, visible / silhouette);
        ++rows;
      },
      ',');
  EXPECT_EQ(rows, 24);
  EXPECT_LT(least, 0.8);  // the second box passes behind the first
}

TEST(Simulate, SegmentsEveryNthFrameAndGivesNoPosesUnlessAsked) {
  const TempFolder temp;
  Scene scene = two_boxes();
  scene.segmenter.every_n_frames = 5;
  scene.given_camera = false;
  SimulateOptions options = quiet();
  options.frames = 7;
  simulate(scene, options, temp.path() / "out");
  const Sequence sequence = open_sequence(temp.path() / "out");
  ASSERT_EQ(sequence.frames.size(), 7u);
  EXPECT_FALSE(sequence.given_camera);
  for (const auto& frame : sequence.frames)
    EXPECT_EQ(frame.masks.empty(), frame.frame % 5 != 0) << frame.frame;
}

TEST(Simulate, TellsCalibrationsAndTimesWithTheirErrors) {
  const TempFolder folder;
  Scene scene = two_boxes_with_lidar(5);
  scene.calibration_error = {0.01, {2, -1}};
  scene.lidar = ConfigNode::parse(
      "{pattern: vlp16, rate_hz: 10, time_offset_s: 0.004, point_times: false, mounting_error: {position_m: "
      "[0.1, 0, 0]}}",
      "lidar.yaml");
  simulate(scene, quiet(), folder.path() / "out");
  const Sequence sequence = open_sequence(folder.path() / "out/sequence");
  EXPECT_NEAR(sequence.camera.fx, 1.01 * scene.camera.fx, 1e-9);
  EXPECT_NEAR(sequence.camera.cy, scene.camera.cy - 1, 1e-9);
  ASSERT_FALSE(sequence.scans.empty());
  EXPECT_EQ(sequence.scans.front().stamp_ns, 4'000'000);
  const LidarRig rig = *lidar_of(scene);
  const Pose error = rig.camera_from_lidar.inverse() * sequence.lidar->camera_from_lidar;
  EXPECT_LT((error.translation - Eigen::Vector3d(0.1, 0, 0)).norm(), 1e-9);
  for (const LidarPoint& point :
       read_lidar_points(folder.path() / "out/sequence" / sequence.scans.front().file))
    ASSERT_EQ(point.offset_ns, 0u);
}

// A stamp that is late by a frame's time shows the frame before; late depth, too.
TEST(Simulate, LateStampsAndLateDepthShowWhatWasThereBefore) {
  const TempFolder folder;
  Scene exact = two_boxes();
  exact.image_noise.sigma = 0;
  exact.depth_noise.model = DepthNoise::Model::none;
  Scene late = exact, late_depth = exact;
  late.imaging.stamp_offset_s = 1 / exact.rate_hz;
  late_depth.depth_noise.delay_s = 1 / exact.rate_hz;
  simulate(exact, quiet(), folder.path() / "exact");
  simulate(late, quiet(), folder.path() / "late");
  simulate(late_depth, quiet(), folder.path() / "late_depth");
  const auto file = [&](const std::string& run, const std::string& name) {
    return read_text(folder.path() / run / "sequence" / name);
  };
  EXPECT_NE(file("exact", "rgb/000002.png"), file("exact", "rgb/000003.png"));
  EXPECT_EQ(file("late", "rgb/000003.png"), file("exact", "rgb/000002.png"));
  EXPECT_EQ(file("late", "depth/000003.png"), file("exact", "depth/000002.png"));
  EXPECT_EQ(file("late_depth", "depth/000003.png"), file("exact", "depth/000002.png"));
  EXPECT_EQ(file("late_depth", "rgb/000003.png"), file("exact", "rgb/000003.png"));
}

}  // namespace
}  // namespace uniquadric
