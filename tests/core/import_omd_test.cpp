#include "core/import/omd.h"

#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "tests/core/small_world.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kRounding = 1e-12;  // m and of R's elements, of 15 digits and a few products

ImportOmdOptions quiet() {
  ImportOmdOptions options;
  options.quiet = options.force = true;
  return options;
}

void import(const fs::path& source, const fs::path& out) {
  import_omd(source, quiet(), out);
}

class ImportOmd : public testing::Test {
 protected:
  ImportOmd() { write_objects_yaml(sizes(), {{1, "box1", {0.1, 0.2, 0.3}, "box", ""}}); }
  // Imports and says what stands on stderr.
  std::string import(ImportOmdOptions options) const {
    testing::internal::CaptureStderr();
    import_omd(source(), options, out());
    return testing::internal::GetCapturedStderr();
  }
  fs::path source() const { return temp_.path() / "swinging_4"; }
  fs::path out() const { return temp_.path() / "out"; }
  fs::path sizes() const { return temp_.path() / "sizes.yaml"; }
  TempFolder temp_;
  RecordedWorld world_ = small_world();
};

TEST_F(ImportOmd, RawSensorsReadBackAsTheRecordingHasThem) {
  write_omd_raw(world_, source());
  import(quiet());
  const Sequence sequence = open_sequence(out());
  expect_small_camera(sequence, "swinging_4");
  EXPECT_EQ(sequence.depth_units_per_m, 1000);
  ASSERT_EQ(sequence.frames.size(), std::size_t{kWorldFrames});
  for (int i = 0; i < kWorldFrames; ++i) {
    const SequenceFrame& frame = sequence.frames[i];
    EXPECT_EQ(frame.stamp_ns, world_.stamps_ns[i]);
    const std::string index = std::to_string(100 + i);
    EXPECT_EQ(read_text(sequence.folder / frame.rgb),
              read_text(source() / ("rgbd/000" + index + "_color.png")));
    const cv::Mat depth = read_depth(sequence, frame);
    EXPECT_FLOAT_EQ(depth.at<float>(3, 3), 7.25f + 0.5f * static_cast<float>(i));
    EXPECT_EQ(depth.at<float>(2, 3), 0);
  }
  ASSERT_TRUE(sequence.imu);
  EXPECT_LT((sequence.imu->camera_from_imu.matrix() - world_.camera_from_imu).cwiseAbs().maxCoeff(),
            kRounding);
  EXPECT_NEAR(sequence.imu->rate_hz, 200, 1e-9);
  const auto samples = read_imu_csv(sequence.folder / "imu.csv");
  ASSERT_EQ(samples.size(), world_.imu.size());
  EXPECT_EQ(samples[7].stamp_ns, world_.imu[7].stamp_ns);
  EXPECT_LT((samples[7].angular_velocity_radps - world_.imu[7].gyro).norm(), kRounding);
  EXPECT_LT((samples[7].specific_force_mps2 - world_.imu[7].accel).norm(), kRounding);
}

// The trap of vicon.csv: whichever way quaternion and translation go, the matrix is object_from_world.
TEST_F(ImportOmd, ViconPlacesCameraAndBodiesInTheWorld) {
  ImportOmdOptions options = quiet();
  options.objects = sizes();
  for (const auto direction : {ViconDirection::world_from_object, ViconDirection::object_from_world}) {
    write_omd_raw(world_, source(), direction);
    EXPECT_NE(import(options).find("the poses of box3 are left out, for nothing says their sizes"),
              std::string::npos);
    const Tracks truth = read_tracks(out() / "truth");
    expect_poses(truth.camera, small_camera);
    expect_poses(*open_sequence(out()).given_camera, small_camera);
    ASSERT_EQ(truth.objects.size(), 1u);
    EXPECT_EQ(truth.objects[0].name, "box1");
    Trajectory box;
    for (const ObjectState& state : truth.objects[0].states) {
      EXPECT_EQ(state.ellipsoid.semi_axes_m, Eigen::Vector3d(0.1, 0.2, 0.3));
      box.push_back({state.stamp_ns, state.ellipsoid.world_from_object});
    }
    expect_poses(box, [](std::int64_t t) { return small_object(1, t); });
    EXPECT_EQ(truth.calibration->fy, 11);
  }
}

TEST_F(ImportOmd, ViconsClockIsSetByItsOffset) {
  write_omd_raw(world_, source(), ViconDirection::world_from_object, 2'500'000'000);
  EXPECT_NE(input_error([&] {
              import_omd(source(), quiet(), out());
            }).find("vicon.csv: no image lies within the poses' times"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(out()));
  ImportOmdOptions options = quiet();
  options.vicon_offset_s = -2.5;
  import(options);
  expect_poses(read_tracks(out() / "truth").camera, small_camera);
}

TEST_F(ImportOmd, SkipsIndicesWithOneImageAndRowsWithoutAPose) {
  write_omd_raw(world_, source());
  fs::remove(source() / "rgbd/000102_aligned_depth.png");
  fs::remove(source() / "rgbd/000103_color.png");
  std::ofstream(source() / "vicon.csv", std::ios::app)
      << "1560500001,0,,0,0,0,1,0,0,0,1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1\n"
         "1560500001,0,box1,nan,NaN,0,1,0,0,0,1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1\n";
  const std::string said = import(quiet());
  EXPECT_NE(said.find("rgbd.csv: 2 indices without both images"), std::string::npos) << said;
  EXPECT_NE(said.find("vicon.csv: 2 rows without a name or with NaN"), std::string::npos) << said;
  const Sequence sequence = open_sequence(out());
  ASSERT_EQ(sequence.frames.size(), 3u);
  EXPECT_EQ(sequence.frames[2].stamp_ns, world_.stamps_ns[4]);
  EXPECT_EQ(sequence.frames[2].rgb, "rgb/000104.png");
}

TEST_F(ImportOmd, CalibrationMayLieInTheFolderAbove) {
  write_omd_raw(world_, source());
  for (const char* name : {"kalibr_2019_06_14.yaml", "vicon_2019_06_14.yaml"})
    fs::rename(source() / name, temp_.path() / name);
  import(quiet());
  expect_small_camera(open_sequence(out()), "swinging_4");
}

TEST_F(ImportOmd, WithoutItsPlaceTheImuIsLeftOut) {
  write_omd_raw(world_, source());
  edit(source() / "kalibr_2019_06_14.yaml", "T_cam_imu", "unknown");
  EXPECT_NE(import(quiet()).find("imu.csv: left out, for kalibr's file has no T_cam_imu"), std::string::npos);
  EXPECT_FALSE(open_sequence(out()).imu);
}

TEST_F(ImportOmd, ProcessedLayoutReadsBack) {
  world_.camera.clear();  // has poses of frames
  for (auto& [id, poses] : world_.objects) poses.clear();
  for (int i = 1; i < kWorldFrames; ++i) {
    world_.camera.push_back({world_.stamps_ns[i], small_camera(world_.stamps_ns[i])});
    for (auto& [id, poses] : world_.objects)
      poses.push_back({world_.stamps_ns[i], small_object(id, world_.stamps_ns[i])});
  }
  write_omd_processed(world_, source());
  ImportOmdOptions options = quiet();
  options.objects = sizes();
  EXPECT_NE(import(options).find("the poses of object 3 are left out"), std::string::npos);
  const Sequence sequence = open_sequence(out());
  expect_small_camera(sequence, "swinging_4");
  ASSERT_EQ(sequence.frames.size(), std::size_t{kWorldFrames});
  for (int i = 0; i < kWorldFrames; ++i) {
    const SequenceFrame& frame = sequence.frames[i];
    EXPECT_EQ(frame.stamp_ns, world_.stamps_ns[i]);
    EXPECT_EQ(read_rgb(sequence, frame).at<cv::Vec3b>(0, 0),
              cv::Vec3b(10, static_cast<unsigned char>(20 + i), 30));
    constexpr double kHalfMillimetre = 0.00055;  // and what a thousandth of a pixel of disparity is
    EXPECT_NEAR(read_depth(sequence, frame).at<float>(3, 3), 7.25 + 0.5 * i, kHalfMillimetre);
    EXPECT_EQ(read_depth(sequence, frame).at<float>(2, 3), 0);
    const cv::Mat ids = read_masks(sequence, frame);
    EXPECT_EQ(cv::countNonZero(ids != world_.ids[i]), 0);
    EXPECT_EQ(frame.masks_arrival_ns, frame.stamp_ns);
  }
  const Tracks truth = read_tracks(out() / "truth");
  expect_poses(truth.camera, small_camera);
  ASSERT_EQ(truth.objects.size(), 1u);
  Trajectory box;
  for (const ObjectState& state : truth.objects[0].states)
    box.push_back({state.stamp_ns, state.ellipsoid.world_from_object});
  expect_poses(box, [](std::int64_t t) { return small_object(1, t); });
}

TEST_F(ImportOmd, ProcessedDepthMayBeMetric) {
  write_omd_processed(world_, source(), 5000);
  ImportOmdOptions options = quiet();
  options.metric_depth = true;
  const std::string refusal = input_error([&] { import_omd(source(), options, out()); });
  EXPECT_NE(refusal.find("pose_gt.txt: holds no pose"), std::string::npos) << refusal;
  fs::remove(source() / "pose_gt.txt");
  import(options);
  const Sequence sequence = open_sequence(out());
  EXPECT_EQ(sequence.depth_units_per_m, 5000);
  EXPECT_FLOAT_EQ(read_depth(sequence, sequence.frames[1]).at<float>(0, 0), 7.75f);
}

TEST(ImportOmdRefusals, OfTheRawLayoutNameFileAndLine) {
  const auto kalibr = [](const fs::path& r) { return r / "kalibr_2019_06_14.yaml"; };
  expect_refusals(
      {
          {"recording: holds no recording: neither rgbd/rgbd.csv",
           [](auto r) { fs::remove(r / "rgbd/rgbd.csv"); }},
          {"recording: has no kalibr*.yaml", [&](auto r) { fs::remove(kalibr(r)); }},
          {"recording: has 2 files vicon*.yaml",
           [](auto r) { fs::copy(r / "vicon_2019_06_14.yaml", r / "vicon_2.yaml"); }},
          {"kalibr_2019_06_14.yaml:1: missing key 'cam2'", [&](auto r) { edit(kalibr(r), "cam2", "cam3"); }},
          {"kalibr_2019_06_14.yaml:12: cam1.T_cn_cnm1: the last row of the matrix is not 0 0 0 1",
           [&](auto r) { edit(kalibr(r), "[0, 0, 0, 1]", "[0, 0, 0, 2]"); }},
          {"kalibr_2019_06_14.yaml:35: cam2.intrinsics: expected 0.08 to 8000 px, found 0.01",
           [&](auto r) { edit(kalibr(r), "[10, 11", "[0.01, 11"); }},
          {"kalibr_2019_06_14.yaml:35: cam2.intrinsics: expected -80 to 80 px, found 10000000",
           [&](auto r) { edit(kalibr(r), "[10, 11, 3.5", "[10, 11, 1e7"); }},
          {"vicon_2019_06_14.yaml:2: T_apparatus_left: the last row of the matrix",
           [](auto r) { edit(r / "vicon_2019_06_14.yaml", "[0, 0, 0, 1]", "[0, 0, 0, 0]"); }},
          {"rgbd.csv:3: nanoseconds '1000000000' is no whole number from 0 to 999999999",
           [](auto r) { edit(r / "rgbd/rgbd.csv", ",156790122", ",1000000000"); }},
          {"rgbd.csv:3: timestamp 1560500000.000000000 does not come after 1560500000.123456789",
           [](auto r) { edit(r / "rgbd/rgbd.csv", ",156790122", ",0"); }},
          {"rgbd.csv:2: expected 3 columns, found 2",
           [](auto r) { edit(r / "rgbd/rgbd.csv", "100,1560500000,", "100,"); }},
          {"000101_aligned_depth.png: expected a 16-bit grey image",
           [](auto r) { write_png(r / "rgbd/000101_aligned_depth.png", cv::Mat::zeros(6, 8, CV_8UC1)); }},
          {"000101_color.png: is 9x6, the camera says 8x6",
           [](auto r) { write_png(r / "rgbd/000101_color.png", cv::Mat::zeros(6, 9, CV_8UC3)); }},
          {"imu.csv:2: expected 12 columns, found 11",
           [](auto r) { edit(r / "imu.csv", ",0,0,0,1", ",0,0,1"); }},
          {"vicon.csv:2: expected 26 columns, found 27",
           [](auto r) { edit(r / "vicon.csv", "sensor_payload,", "sensor_payload,0,"); }},
          {"vicon.csv:3: 'x-0.15", [](auto r) { edit(r / "vicon.csv", "box1,", "box1,x"); }},
          {"vicon.csv: has no row of sensor_payload",
           [](auto r) {
             std::string text = read_text(r / "vicon.csv");
             for (std::size_t at; (at = text.find("sensor_payload")) != text.npos;)
               text.replace(at, 14, "rig");
             write_text(r / "vicon.csv", text);
           }},
      },
      [](const fs::path& folder) { write_omd_raw(small_world(), folder); }, import);
}

// Poses whose direction nothing tells would be wrong without a sign of it.
TEST(ImportOmdRefusals, OfPosesThatContradictThemselves) {
  const TempFolder temp;
  const fs::path source = temp.path() / "recording";
  const auto refusal = [&] { return input_error([&] { import(source, temp.path() / "out"); }); };
  RecordedWorld world = small_world();
  write_omd_raw(world, source);
  // rows 2, 3, 4: payload, box1, box3; the third takes the first's quaternion and translation
  std::istringstream before(read_text(source / "vicon.csv"));
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(before, line);) {
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(field);
  }
  const auto write_rows = [&](const auto& changed) {
    std::string text;
    for (const auto& row : changed) {
      for (std::size_t i = 0; i < row.size(); ++i) text += (i ? "," : "") + row[i];
      text += "\n";
    }
    write_text(source / "vicon.csv", text);
  };
  auto mixed = rows;
  std::copy_n(rows[1].begin() + 3, 7, mixed[3].begin() + 3);
  write_rows(mixed);
  EXPECT_NE(
      refusal().find("vicon.csv:4: quaternion and translation are neither the 4x4 matrix nor its inverse"),
      std::string::npos);
  write_omd_raw(world, source, ViconDirection::object_from_world);
  std::istringstream other(read_text(source / "vicon.csv"));
  std::string line;
  for (int i = 0; i < 5; ++i) std::getline(other, line);
  std::string text;
  write_rows(rows);
  std::string whole = read_text(source / "vicon.csv");
  std::size_t begin = 0;
  for (int i = 0; i < 4; ++i) begin = whole.find('\n', begin) + 1;
  whole.replace(begin, whole.find('\n', begin) - begin, line);  // one row of the other way
  write_text(source / "vicon.csv", whole);
  EXPECT_NE(
      refusal().find("vicon.csv:5: quaternion and translation go the other way than in the rows before"),
      std::string::npos);
  EXPECT_FALSE(fs::exists(temp.path() / "out"));
}

TEST(ImportOmdRefusals, OfTheProcessedLayoutNameFileAndLine) {
  expect_refusals(
      {
          {"recording: has 2 files .yaml", [](auto r) { fs::copy(r / "omd.yaml", r / "other.yaml"); }},
          {"omd.yaml:4: missing key 'Camera.cx'",
           [](auto r) { edit(r / "omd.yaml", "Camera.cx", "Camera.c"); }},
          {"omd.yaml:5: ", [](auto r) { edit(r / "omd.yaml", "Camera.fy: 11", "Camera.fy: -11"); }},
          {"times.txt:2: ", [](auto r) { edit(r / "times.txt", "1560500000.156790122", "soon"); }},
          {"image_0/000003.png: is missing", [](auto r) { fs::remove(r / "image_0/000003.png"); }},
          {"depth/000003.png: is missing", [](auto r) { fs::remove(r / "depth/000003.png"); }},
          {"semantic/000003.txt: is missing", [](auto r) { fs::remove(r / "semantic/000003.txt"); }},
          {"semantic/000003.txt:2: id '70000' is no whole number from 0 to 65535",
           [](auto r) { edit(r / "semantic/000003.txt", "0 1 0", "0 70000 0"); }},
          {"semantic/000003.txt:2: expected 8 ids, found 7",
           [](auto r) { edit(r / "semantic/000003.txt", "0 1 0", "0 1"); }},
          {"semantic/000003.txt: has 5 rows of ids, the camera 6",
           [](auto r) { edit(r / "semantic/000003.txt", "0 0 0 0 0 0 0 0\n", ""); }},
          {"depth/000002.png: is 9x6, the camera says 8x6",
           [](auto r) { write_png(r / "depth/000002.png", cv::Mat::zeros(6, 9, CV_16UC1)); }},
          {"pose_gt.txt:1: expected 17 fields, found 18",
           [](auto r) { edit(r / "pose_gt.txt", "\n", " 1\n"); }},
          {"pose_gt.txt:1: frame '9' is no whole number from 0 to 4",
           [](auto r) { edit(r / "pose_gt.txt", "0 ", "9 "); }},
          {"pose_gt.txt:1: the last row", [](auto r) { edit(r / "pose_gt.txt", " 1\n", " 2\n"); }},
          {"object_pose.txt:1: expected 8 fields, found 9",
           [](auto r) { edit(r / "object_pose.txt", "\n", " 1\n"); }},
      },
      [](const fs::path& folder) {
        RecordedWorld world = small_world();
        for (StampedMatrix& pose : world.camera)
          pose.stamp_ns += world.stamps_ns[0] - world.camera[0].stamp_ns;
        world.camera.resize(1);
        for (auto& [id, poses] : world.objects) {
          poses.resize(1);
          poses[0].stamp_ns = world.stamps_ns[0];
        }
        write_omd_processed(world, folder);
      },
      import);
}

TEST_F(ImportOmd, SizesOfUnknownBodiesAreRefused) {
  write_omd_raw(world_, source());
  write_objects_yaml(sizes(), {{7, "box7", {0.1, 0.2, 0.3}, "box", ""}});
  ImportOmdOptions options = quiet();
  options.objects = sizes();
  EXPECT_NE(input_error([&] {
              import_omd(source(), options, out());
            }).find("sizes.yaml: the recording has no box7"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(out()));
}

}  // namespace
}  // namespace uniquadric
