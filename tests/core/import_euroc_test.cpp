#include "core/import/euroc.h"

#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "tests/core/small_world.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kRounding = 1e-12;  // m and of R's elements, of 15 digits and a few products

void import(const fs::path& source, const fs::path& out) {
  ImportEurocOptions options;
  options.quiet = true;
  options.stereo_depth = false;
  import_euroc(source, options, out);
}

class ImportEuroc : public testing::Test {
 protected:
  ImportEuroc() {
    write_euroc_layout(world_, source());
    import(source(), out());
  }
  fs::path source() const { return temp_.path() / "MH_01"; }
  fs::path out() const { return temp_.path() / "out"; }

  TempFolder temp_;
  RecordedWorld world_ = small_world();
};

TEST_F(ImportEuroc, SensorsReadBackAsTheRecordingHasThem) {
  const Sequence sequence = open_sequence(out());
  expect_small_camera(sequence, "MH_01");
  ASSERT_EQ(sequence.frames.size(), std::size_t{kWorldFrames});
  for (int i = 0; i < kWorldFrames; ++i) {
    EXPECT_EQ(sequence.frames[i].stamp_ns, world_.stamps_ns[i]);
    EXPECT_TRUE(sequence.frames[i].depth.empty());
    const cv::Mat color = read_rgb(sequence, sequence.frames[i]);  // the grey value three times
    EXPECT_EQ(color.at<cv::Vec3b>(4, 5), cv::Vec3b::all(static_cast<unsigned char>(20 + i)));
  }
  ASSERT_TRUE(sequence.imu);
  const ImuCalibration& imu = *sequence.imu;
  EXPECT_LT((imu.camera_from_imu.matrix() - world_.camera_from_imu).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_NEAR(imu.rate_hz, 200, 1e-9);
  EXPECT_EQ(imu.gyroscope_noise_radps_rthz, 1.5e-4);
  EXPECT_EQ(imu.gyroscope_walk_radps2_rthz, 2.5e-5);
  EXPECT_EQ(imu.accelerometer_noise_mps2_rthz, 3.5e-3);
  EXPECT_EQ(imu.accelerometer_walk_mps3_rthz, 4.5e-3);
  const auto samples = read_imu_csv(out() / "sequence/imu.csv");
  ASSERT_EQ(samples.size(), world_.imu.size());
  EXPECT_EQ(samples[7].stamp_ns, world_.imu[7].stamp_ns);
  EXPECT_LT((samples[7].angular_velocity_radps - world_.imu[7].gyro).norm(), kRounding);
  EXPECT_LT((samples[7].specific_force_mps2 - world_.imu[7].accel).norm(), kRounding);
}

TEST_F(ImportEuroc, TheBodysStatesPlaceTheCamera) {
  const Tracks truth = read_tracks(out() / "truth");
  expect_poses(truth.camera, small_camera);
  EXPECT_TRUE(truth.objects.empty());
  ASSERT_TRUE(truth.calibration);
  EXPECT_EQ(truth.calibration->distortion[1], -0.002);
  expect_poses(*open_sequence(out()).given_camera, small_camera);
}

TEST_F(ImportEuroc, WhatARecordingLacksIsNotThere) {
  fs::remove_all(source() / "mav0/imu0");
  fs::remove_all(source() / "mav0/state_groundtruth_estimate0");
  import(source() / "mav0", temp_.path() / "other");  // mav0 itself is a recording too
  const Sequence sequence = open_sequence(temp_.path() / "other");
  EXPECT_EQ(sequence.frames.size(), std::size_t{kWorldFrames});
  EXPECT_FALSE(sequence.imu);
  EXPECT_FALSE(sequence.given_camera);
  EXPECT_FALSE(fs::exists(temp_.path() / "other/truth"));
}

TEST_F(ImportEuroc, StatesOfAnotherClockAreRefused) {
  const fs::path states = source() / "mav0/state_groundtruth_estimate0/data.csv";
  std::string text = read_text(states);
  for (std::size_t at = 0; (at = text.find("\n156", at)) != std::string::npos; ++at) text[at + 1] = '2';
  write_text(states, text);
  const std::string refusal = input_error([&] { import(source(), temp_.path() / "other"); });
  EXPECT_NE(refusal.find("data.csv: no image lies within the poses' times: the clocks differ"),
            std::string::npos)
      << refusal;
  EXPECT_FALSE(fs::exists(temp_.path() / "other"));
}

// A textured plane, tilted against the camera, in the world of that camera.
const Eigen::Vector3d kNormal = Eigen::Vector3d(0.25, -0.1, -1).normalized();
constexpr double kOffset_m = -1.8;

Eigen::Vector3d on_plane(const Eigen::Matrix4d& world_from_camera, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d eye = world_from_camera.topRightCorner<3, 1>();
  const Eigen::Vector3d d = world_from_camera.topLeftCorner<3, 3>() * ray;
  return eye + (kOffset_m - kNormal.dot(eye)) / kNormal.dot(d) * d;
}

double grey_at(const Eigen::Vector3d& p) {  // waves of 0.09 to 0.5 m; a pixel is 0.014 m
  return 128 + 30 * std::sin(31 * p.x() + 17 * p.y()) + 30 * std::sin(-23 * p.x() + 52 * p.y() + 1) +
         30 * std::sin(66 * p.x() - 11 * p.y() + 2) + 20 * std::sin(8 * p.x() + 13 * p.y());
}

cv::Mat plane_image(const RecordedWorld& w, const Eigen::Matrix4d& world_from_camera) {
  cv::Mat image(w.height, w.width, CV_8UC3);
  for (int v = 0; v < w.height; ++v)
    for (int u = 0; u < w.width; ++u) {
      const Eigen::Vector3d p = on_plane(world_from_camera, {(u - w.cx) / w.fx, (v - w.cy) / w.fy, 1});
      image.at<cv::Vec3b>(v, u) = cv::Vec3b::all(cv::saturate_cast<unsigned char>(grey_at(p)));
    }
  return image;
}

TEST(ImportEurocStereo, RectifiedImagesDepthAndPosesAgreeOnAPlane) {
  const TempFolder temp;
  RecordedWorld w;
  w.width = 160, w.height = 120, w.fx = w.fy = 130, w.cx = 79.5, w.cy = 59.5;
  w.camera_from_imu = rigid({3, 1, 2}, 0.8, {0.05, -0.06, 0.07});
  w.right_from_left = rigid({0.3, 1, 0.5}, 0.1, {-0.12, 0.003, 0.002});
  for (int i = 0; i < 2; ++i) {
    const Eigen::Matrix4d world_from_camera = rigid({0, 1, 0}, 0.05 * i, {0.1 * i, 0, 0});
    w.stamps_ns.push_back(kStart_ns + i * kFrame_ns);
    w.camera.push_back({w.stamps_ns.back(), world_from_camera});
    w.colors.push_back(plane_image(w, world_from_camera));
    w.right_colors.push_back(plane_image(w, world_from_camera * w.right_from_left.inverse()));
    w.imu.push_back({w.stamps_ns.back(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  }
  write_euroc_layout(w, temp.path() / "recording");
  ImportEurocOptions options;
  options.quiet = true;
  import_euroc(temp.path() / "recording", options, temp.path() / "out");
  const Sequence sequence = open_sequence(temp.path() / "out");
  const Tracks truth = read_tracks(temp.path() / "out/truth");
  ASSERT_EQ(truth.camera.size(), 2u);
  EXPECT_GT((truth.camera[0].pose.matrix() - w.camera[0].matrix).norm(), 0.02);  // rectified is turned
  // the body did not move for it
  EXPECT_LT((truth.camera[1].pose.matrix() * sequence.imu->camera_from_imu.matrix() -
             w.camera[1].matrix * w.camera_from_imu)
                .norm(),
            1e-9);
  for (int i = 0; i < 2; ++i) {
    const cv::Mat color = read_rgb(sequence, sequence.frames[i]),
                  depth = read_depth(sequence, sequence.frames[i]);
    const Eigen::Matrix4d world_from_camera = truth.camera[i].pose.matrix();
    std::vector<double> depth_errors, grey_errors;
    for (int v = 5; v < w.height - 5; ++v)
      for (int u = 25; u < w.width - 5; ++u) {  // left of it the second camera does not see
        const Eigen::Vector3d p = on_plane(world_from_camera, *sequence.camera.unproject({u, v}));
        const double z = (world_from_camera.inverse() * p.homogeneous())[2];
        grey_errors.push_back(std::abs(color.at<cv::Vec3b>(v, u)[1] - grey_at(p)));
        if (depth.at<float>(v, u) > 0) depth_errors.push_back(std::abs(depth.at<float>(v, u) - z));
      }
    const auto quantile = [](std::vector<double>& values) {
      std::nth_element(values.begin(), values.begin() + std::ssize(values) * 9 / 10, values.end());
      return values[values.size() * 9 / 10];
    };
    ASSERT_GT(depth_errors.size(), grey_errors.size() * 8 / 10);
    EXPECT_LT(quantile(depth_errors), 0.06);  // m: of a quarter of a pixel of disparity at 1.8 m
    EXPECT_LT(quantile(grey_errors), 8);      // of 256: what linear interpolation takes off the waves
  }
}

TEST(ImportEurocStereo, NeedsASecondCameraLikeTheFirstToItsRight) {
  RecordedWorld world = small_world();
  world.right_colors = world.colors;
  const auto write = [&](const Eigen::Vector3d& left_in_right) {
    return [&world, left_in_right](const fs::path& folder) {
      world.right_from_left = rigid({1, 0, 0}, 0, left_in_right);
      write_euroc_layout(world, folder);
    };
  };
  const auto import_stereo = [](const fs::path& source, const fs::path& out) {
    ImportEurocOptions options;
    options.quiet = true;
    import_euroc(source, options, out);
  };
  const auto nothing = [](const fs::path&) {};
  expect_refusals({{"cam1/sensor.yaml: T_BS: cam1 does not lie to the right of cam0", nothing}},
                  write({0.11, 0, 0}), import_stereo);
  expect_refusals({{"recording: there is no mav0/cam1/, which depth needs",
                    [](const fs::path& r) { fs::remove_all(r / "mav0/cam1"); }},
                   {"cam1/sensor.yaml: resolution: is not that of cam0",
                    [](const fs::path& r) { edit(r / "mav0/cam1/sensor.yaml", "[8, 6]", "[8, 7]"); }},
                   {"cam1/data/" + std::to_string(kStart_ns) + ".png: is 9x6, the camera says 8x6",
                    [](const fs::path& r) {
                      write_png(r / "mav0/cam1/data" / (std::to_string(kStart_ns) + ".png"),
                                cv::Mat::zeros(6, 9, CV_8UC1));
                    }}},
                  write({-0.11, 0, 0}), import_stereo);
}

TEST(ImportEurocRefusals, NameFileAndLine) {
  const auto cam = [](const fs::path& r) { return r / "mav0/cam0"; };
  const auto states = [](const fs::path& r) { return r / "mav0/state_groundtruth_estimate0/data.csv"; };
  const auto image = [](int frame) { return std::to_string(kStart_ns + frame * kFrame_ns) + ".png"; };
  expect_refusals(
      {
          {"recording: holds no recording: there is no mav0/cam0/", [&](auto r) { fs::remove_all(cam(r)); }},
          {"cam0/sensor.yaml: cannot be read", [&](auto r) { fs::remove(cam(r) / "sensor.yaml"); }},
          {"cam0/sensor.yaml:12: ",
           [&](auto r) { edit(cam(r) / "sensor.yaml", "radial-tangential", "equidistant"); }},
          {"cam0/sensor.yaml:11: intrinsics: expected fx, fy, cx, cy",
           [&](auto r) { edit(cam(r) / "sensor.yaml", "10, 11, 3.5", "10, 11"); }},
          {"cam0/sensor.yaml:7: T_BS.data: the matrix is no rotation",
           [&](auto r) { edit(cam(r) / "sensor.yaml", "data: [0.", "data: [0.1"); }},
          {"cam0/data.csv:4: file data/no.png is missing",
           [&](auto r) { edit(cam(r) / "data.csv", "," + image(2), ",no.png"); }},
          {"cam0/data.csv:3: '../1.png' is no name of an image",
           [&](auto r) { edit(cam(r) / "data.csv", "," + image(1), ",../1.png"); }},
          {"cam0/data.csv:3: timestamp 1.000000000 does not come after",
           [&](auto r) {
             edit(cam(r) / "data.csv", std::to_string(kStart_ns + kFrame_ns) + ",", "1000000000,");
           }},
          {image(3) + ": is 9x6, the camera says 8x6",
           [&](auto r) { write_png(cam(r) / "data" / image(3), cv::Mat::zeros(6, 9, CV_8UC1)); }},
          {image(3) + ": expected an 8-bit colour image",
           [&](auto r) { write_png(cam(r) / "data" / image(3), cv::Mat::zeros(6, 8, CV_16UC1)); }},
          {"imu0/data.csv:2: 'x' is not a finite number",
           [&](auto r) { edit(r / "mav0/imu0/data.csv", ",0.1,", ",x,"); }},
          {"imu0/data.csv:2: expected 7 columns, found 6",
           [&](auto r) { edit(r / "mav0/imu0/data.csv", ",0.1,", ","); }},
          {"imu0/sensor.yaml:1: missing key 'accelerometer_random_walk'",
           [&](auto r) { edit(r / "mav0/imu0/sensor.yaml", "accelerometer_random_walk", "walk"); }},
          {"state_groundtruth_estimate0/data.csv:2: expected 17 columns, found 16",
           [&](auto r) { edit(states(r), ",0,0,0,0,0,0,0,0,0\n", ",0,0,0,0,0,0,0,0\n"); }},
          {"state_groundtruth_estimate0/data.csv:2: quaternion has norm 2, not 1",
           [&](auto r) { edit(states(r), "b_a\n", "b_a\n1,0,0,0,2,0,0,0,0,0,0,0,0,0,0,0,0\n"); }},
      },
      [](const fs::path& folder) { write_euroc_layout(small_world(), folder); }, import);
}

}  // namespace
}  // namespace uniquadric
