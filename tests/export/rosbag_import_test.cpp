#include <cstring>
#include <limits>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/sequence/calibration.h"
#include "core/sequence/image_file.h"
#include "harness/rosbag/bag_images.h"
#include "harness/rosbag/bag_reader.h"
#include "harness/rosbag/bag_writer.h"
#include "harness/rosbag/import_rosbag.h"
#include "harness/rosbag/static_tree.h"
#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kShiftNs = 1'000'000'000;     // the scene begins at 0 s, which ROS takes for no time
constexpr double kDepthTolerance_m = 0.5e-3 + 1e-6;  // half a millimetre, in single precision
constexpr double kPoseTolerance = 1e-9;

class RosbagImport : public Export {
 protected:
  RosbagImport() { options.quiet = true; }
  void import(const fs::path& bag) { import_rosbag(bag, options, folder() / "imported"); }
  std::string refusal(const fs::path& bag) {
    const std::string message = input_error([&] { import(bag); });
    EXPECT_FALSE(fs::exists(folder() / "imported"));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  Sequence imported() const { return open_sequence(folder() / "imported/sequence"); }
  // What stderr says meanwhile.
  std::string said(const fs::path& bag) {
    testing::internal::CaptureStderr();
    import(bag);
    return testing::internal::GetCapturedStderr();
  }
  void expect_scans(const Sequence& sequence) const {
    ASSERT_EQ(sequence.scans.size(), sequence_.scans.size());
    for (std::size_t i = 0; i < sequence.scans.size(); ++i) {
      EXPECT_EQ(sequence.scans[i].stamp_ns, sequence_.scans[i].stamp_ns + kShiftNs);
      const auto points = read_lidar_points(sequence.folder / sequence.scans[i].file);
      ASSERT_EQ(points.size(), scans_[i].size());
      for (std::size_t k = 0; k < points.size(); ++k) {
        EXPECT_EQ(points[k].x, scans_[i][k].x);
        EXPECT_EQ(points[k].y, scans_[i][k].y);
        EXPECT_EQ(points[k].z, scans_[i][k].z);
        EXPECT_EQ(points[k].intensity, scans_[i][k].intensity);
        EXPECT_EQ(points[k].offset_ns, scans_[i][k].offset_ns);
        EXPECT_EQ(points[k].ring, scans_[i][k].ring);
        EXPECT_EQ(points[k].tag, scans_[i][k].tag);
      }
    }
  }

  ImportRosbagOptions options;
  fs::path exported = run("rosbag") / "small.bag";
};

TEST_F(RosbagImport, GivesTheExportedImages) {
  const std::string lines = said(exported);
  EXPECT_NE(lines.find("topics not taken: /camera/depth/camera_info (sensor_msgs/CameraInfo), /livox/lidar "),
            std::string::npos)
      << lines;
  EXPECT_EQ(lines.find("identity"), std::string::npos) << lines;
  const Sequence sequence = imported();
  EXPECT_EQ(sequence.name, "small");
  ASSERT_EQ(sequence.frames.size(), sequence_.frames.size());
  EXPECT_EQ(sequence.camera.matrix(), sequence_.camera.matrix());
  EXPECT_EQ(sequence.camera.distortion, sequence_.camera.distortion);
  EXPECT_DOUBLE_EQ(sequence.rate_hz, sequence_.rate_hz);
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const SequenceFrame &got = sequence.frames[i], &expected = sequence_.frames[i];
    EXPECT_EQ(got.stamp_ns, expected.stamp_ns + kShiftNs);
    EXPECT_EQ(cv::norm(read_rgb(sequence, got), read_rgb(sequence_, expected)), 0);
    const cv::Mat a = read_depth(sequence, got), b = read_depth(sequence_, expected);
    EXPECT_GT(cv::countNonZero(a), 1000);
    EXPECT_LT(cv::norm(a, b, cv::NORM_INF), kDepthTolerance_m);
    EXPECT_TRUE(got.masks.empty());
  }
}

TEST_F(RosbagImport, GivesTheExportedImuAndScans) {
  import(exported);
  const Sequence sequence = imported();
  const auto got = read_imu_csv(sequence.folder / "imu.csv"),
             expected = read_imu_csv(sequence_.folder / "imu.csv");
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(got[i].stamp_ns, expected[i].stamp_ns + kShiftNs);
    EXPECT_EQ(got[i].angular_velocity_radps, expected[i].angular_velocity_radps);
    EXPECT_EQ(got[i].specific_force_mps2, expected[i].specific_force_mps2);
  }
  ASSERT_TRUE(sequence.imu && sequence.lidar);
  EXPECT_DOUBLE_EQ(sequence.imu->rate_hz, sequence_.imu->rate_hz);
  EXPECT_NEAR(sequence.imu->gyroscope_noise_radps_rthz, sequence_.imu->gyroscope_noise_radps_rthz, 1e-12);
  EXPECT_NEAR(sequence.imu->accelerometer_noise_mps2_rthz, sequence_.imu->accelerometer_noise_mps2_rthz,
              1e-12);
  EXPECT_LT((sequence.imu->camera_from_imu.matrix() - sequence_.imu->camera_from_imu.matrix()).norm(),
            kPoseTolerance);
  EXPECT_DOUBLE_EQ(sequence.lidar->rate_hz, 10);
  EXPECT_LT((sequence.lidar->camera_from_lidar.matrix() - sequence_.lidar->camera_from_lidar.matrix()).norm(),
            kPoseTolerance);
  expect_scans(sequence);
}

TEST_F(RosbagImport, GivesTheScansOfTheLivoxTopic) {
  options.topics.lidar = "/livox/lidar";
  import(exported);
  expect_scans(imported());
}

TEST_F(RosbagImport, GivesTheExportedTruth) {
  options.objects = data() / "truth/objects.yaml";
  import(exported);
  const Tracks tracks = read_tracks(folder() / "imported/truth");
  ASSERT_EQ(tracks.camera.size(), 4u);
  ASSERT_EQ(tracks.objects.size(), 2u);
  EXPECT_EQ(imported().given_camera->size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(tracks.camera[i].stamp_ns, truth_.camera[i].stamp_ns + kShiftNs);
    EXPECT_LT((tracks.camera[i].pose.matrix() - truth_.camera[i].pose.matrix()).norm(), kPoseTolerance);
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_LT((tracks.objects[k].states.at(i).ellipsoid.world_from_object.matrix() -
                 truth_.objects[k].states[i].ellipsoid.world_from_object.matrix())
                    .norm(),
                kPoseTolerance);
  }
}

TEST_F(RosbagImport, WithoutSizesTheTruthIsTheCamerasAlone) {
  EXPECT_NE(said(exported).find("the poses of /truth/object_1, /truth/object_2 are left out"),
            std::string::npos);
  EXPECT_TRUE(read_objects_yaml(folder() / "imported/truth/objects.yaml").empty());
}

TEST_F(RosbagImport, RgbImagesAreTurned) {
  std::string bytes = bytes_of(exported);
  for (std::size_t at = 0; (at = bytes.find("bgr8", at)) != std::string::npos;) bytes.replace(at, 4, "rgb8");
  write_text(folder() / "rgb.bag", bytes);
  import(folder() / "rgb.bag");
  const Sequence sequence = imported();
  std::vector<cv::Mat> got(3), expected(3);
  cv::split(read_rgb(sequence, sequence.frames[2]), got);
  cv::split(read_rgb(sequence_, sequence_.frames[2]), expected);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(cv::norm(got[k], expected[2 - k]), 0);
}

class HandMadeBag : public RosbagImport {
 protected:
  fs::path path = folder() / "hand.bag";

  // A bag of two seconds with images on these topics, their calibration beside the first, and no tree.
  void write(const std::vector<std::string>& images, const std::vector<std::string>& imus = {}) const {
    BagWriter bag(path);
    for (std::int64_t s = 1; s <= 2; ++s) {
      const BagHeader header{s * 1'000'000'000, "camera"};
      for (const std::string& topic : images)
        bag.image(topic, header, cv::Mat(120, 160, CV_8UC3, cv::Scalar(1, 2, 3)));
      bag.camera_info("/front/camera_info", header, sequence_.camera);
      bag.camera_info("/rear/camera_info", header, sequence_.camera);
      for (const std::string& topic : imus)
        bag.imu(topic, {header.stamp_ns, "body"}, ImuSample{}, ImuCalibration{});
    }
    bag.close();
  }
};

TEST_F(HandMadeBag, SeveralTopicsOfATypeNeedAnOption) {
  write({"/front/image_raw", "/rear/image_raw"});
  EXPECT_NE(refusal(path).find("has 2 topics of colour images, /front/image_raw, /rear/image_raw: name one, "
                               "--rgb-topic"),
            std::string::npos);
  options.topics.rgb = "/rear/image_raw";
  EXPECT_NE(
      said(path).find("topics not taken: /front/camera_info (sensor_msgs/CameraInfo), /front/image_raw"),
      std::string::npos);
  EXPECT_EQ(imported().frames.size(), 2u);
}

TEST_F(HandMadeBag, TopicsThatAreAskedForMustBeThereAndOfTheirType) {
  write({"/front/image_raw"}, {"/imu/a", "/imu/b"});
  EXPECT_NE(refusal(path).find("/imu/a, /imu/b: name one, --imu-topic"), std::string::npos);
  options.topics.imu = "/imu";
  EXPECT_NE(refusal(path).find("has no topic /imu"), std::string::npos);
  options.topics.imu = "/front/image_raw";
  EXPECT_NE(refusal(path).find("topic /front/image_raw is of sensor_msgs/Image, expected sensor_msgs/Imu"),
            std::string::npos);
}

TEST_F(HandMadeBag, WithoutATreeTheIdentityIsTakenAndTold) {
  write({"/front/image_raw"}, {"/imu"});
  EXPECT_NE(
      said(path).find("/tf_static leads from 'body' (/imu) to the camera's 'camera' on no way: taken is "
                      "the identity"),
      std::string::npos);
  EXPECT_EQ(imported().imu->camera_from_imu.matrix(), Pose{}.matrix());
  EXPECT_FALSE(fs::exists(folder() / "imported/truth"));
}

TEST_F(HandMadeBag, ImagesOutOfOrderAreSortedAndDoublesLeftOut) {
  BagWriter bag(path);
  for (const int s : {3, 1, 2, 2}) {
    const BagHeader header{s * 1'000'000'000LL, "camera"};
    bag.image("/image", header, cv::Mat(120, 160, CV_8UC3, cv::Scalar(10 * s, 2, 3)));
    bag.camera_info("/camera_info", header, sequence_.camera);
  }
  bag.close();
  EXPECT_NE(said(path).find("/image: 1 of 4 messages have the stamp of another"), std::string::npos);
  const Sequence sequence = imported();
  ASSERT_EQ(sequence.frames.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(sequence.frames[i].stamp_ns, (i + 1) * 1'000'000'000LL);
    EXPECT_EQ(read_rgb(sequence, sequence.frames[i]).at<cv::Vec3b>(5, 5),
              cv::Vec3b(static_cast<std::uint8_t>(10 * (i + 1)), 2, 3));
  }
}

TEST_F(HandMadeBag, ALidarAloneIsASequenceOfScans) {
  BagWriter bag(path);
  bag.livox("/livox/lidar", {5'000'000'000, "livox"}, 5'100'000'000, scans_[0]);
  bag.livox("/livox/lidar", {5'100'000'000, "livox"}, 5'200'000'000, scans_[1]);
  bag.static_transforms(5'000'000'000,
                        {{"livox", "camera_optical", sequence_.lidar->camera_from_lidar.inverse()}});
  bag.close();
  import(path);
  const Sequence sequence = imported();
  EXPECT_TRUE(sequence.frames.empty());
  ASSERT_EQ(sequence.scans.size(), 2u);
  EXPECT_EQ(sequence.scans[1].stamp_ns, 5'100'000'000);
  EXPECT_LT((sequence.lidar->camera_from_lidar.matrix() - sequence_.lidar->camera_from_lidar.matrix()).norm(),
            kPoseTolerance);
}

TEST_F(HandMadeBag, BadBagsAreRefused) {
  write_text(path, "this is no bag\n");
  EXPECT_NE(refusal(path).find("hand.bag: is no bag of ROS 1 that can be read"), std::string::npos);
  write_text(path, "");
  EXPECT_NE(refusal(path).find("hand.bag: is no bag of ROS 1 that can be read"), std::string::npos);
  const std::string bytes = bytes_of(exported);
  for (const std::size_t size : {bytes.size() / 2, bytes.size() - 10, std::size_t{5000}, std::size_t{20}}) {
    write_text(path, bytes.substr(0, size));
    EXPECT_NE(refusal(path).find("hand.bag: is "), std::string::npos) << size;
  }
  EXPECT_NE(refusal(folder()).find(folder().string()), std::string::npos);
  EXPECT_NE(refusal(folder() / "none.bag").find("none.bag"), std::string::npos);
  BagWriter(path).close();
  EXPECT_NE(refusal(path).find("has neither colour images nor points of a LiDAR"), std::string::npos);
  BagWriter bag(path);
  bag.image("/image", {1, "camera"}, cv::Mat::zeros(120, 160, CV_8UC3));
  bag.close();
  EXPECT_NE(refusal(path).find("has images on /image and no sensor_msgs/CameraInfo"), std::string::npos);
}

TEST_F(HandMadeBag, AnImageOfAnotherSizeThanItsCalibrationIsNamed) {
  BagWriter bag(path);
  bag.image("/image", {7, "camera"}, cv::Mat::zeros(60, 80, CV_8UC3));
  bag.camera_info("/camera_info", {7, "camera"}, sequence_.camera);
  bag.close();
  EXPECT_NE(refusal(path).find("hand.bag: /image, message 0: is 80x60, the camera says 160x120"),
            std::string::npos);
}

TEST(BagImages, ColourOfEveryEncodingIsBlueGreenRed) {
  const cv::Vec3b bgr(10, 20, 30);
  const auto color = [](const char* encoding, const cv::Mat& pixels) {
    return color_of({encoding, pixels, ""}, "image").at<cv::Vec3b>(1, 1);
  };
  EXPECT_EQ(color("bgr8", cv::Mat(2, 3, CV_8UC3, cv::Scalar(10, 20, 30))), bgr);
  EXPECT_EQ(color("rgb8", cv::Mat(2, 3, CV_8UC3, cv::Scalar(30, 20, 10))), bgr);
  EXPECT_EQ(color("bgra8", cv::Mat(2, 3, CV_8UC4, cv::Scalar(10, 20, 30, 255))), bgr);
  EXPECT_EQ(color("rgba8", cv::Mat(2, 3, CV_8UC4, cv::Scalar(30, 20, 10, 255))), bgr);
  EXPECT_EQ(color("mono8", cv::Mat(2, 3, CV_8UC1, cv::Scalar(7))), cv::Vec3b(7, 7, 7));
  const std::string png = encode_image(".png", cv::Mat(2, 3, CV_8UC3, cv::Scalar(10, 20, 30)), {}, "image");
  EXPECT_EQ(color_of({"rgb8; png compressed bgr8", {}, png}, "image").at<cv::Vec3b>(1, 1), bgr);
  EXPECT_NE(input_error([] {
              color_of({"bayer_rggb8", {}, ""}, "image");
            }).find("encoding bayer_rggb8"),
            std::string::npos);
}

TEST(BagImages, DepthIsInMillimetresAndZeroWhereThereIsNone) {
  const float none = std::numeric_limits<float>::quiet_NaN();
  const cv::Mat metres = (cv::Mat_<float>(1, 6) << 1.2344F, 65.5351F, 65.6F, none, -1, 0);
  const cv::Mat expected = (cv::Mat_<std::uint16_t>(1, 6) << 1234, 65535, 0, 0, 0, 0);
  EXPECT_EQ(cv::norm(depth_of({"32FC1", metres, ""}, "image"), expected), 0);
  EXPECT_EQ(cv::norm(depth_of({"16UC1", expected, ""}, "image"), expected), 0);
  EXPECT_THROW(depth_of({"bgr8", cv::Mat::zeros(2, 2, CV_8UC3), ""}, "image"), InputError);
}

TEST(StaticTree, LeadsUpAndDown) {
  const Pose base_from_camera{Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5), {1, 2, 3}},
      base_from_lidar{Eigen::Quaterniond(0, 1, 0, 0), {-1, 0, 2}},
      lidar_from_imu{Eigen::Quaterniond(0, 0, 0.6, 0.8), {0.1, 0.2, 0.3}};
  const std::vector<BagTransform> tree = {{"lidar", "imu", lidar_from_imu},
                                          {"/base", "lidar", base_from_lidar},
                                          {"base", "camera", base_from_camera}};
  const auto camera_from_imu = static_transform(tree, "camera", "imu");
  ASSERT_TRUE(camera_from_imu);
  const Eigen::Matrix4d expected =
      base_from_camera.matrix().inverse() * base_from_lidar.matrix() * lidar_from_imu.matrix();
  EXPECT_LT((camera_from_imu->matrix() - expected).norm(), 1e-12);
  EXPECT_FALSE(static_transform(tree, "camera", "elsewhere"));
  EXPECT_EQ(static_transform({}, "a", "a")->matrix(), Pose{}.matrix());
}

}  // namespace
}  // namespace uniquadric
