#include <yaml-cpp/yaml.h>

#include <opencv2/imgcodecs.hpp>

#include "simulator/scene/scene.h"
#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Eigen::Matrix4d body_from_sensor(const fs::path& sensor_yaml) {
  const auto values = YAML::LoadFile(sensor_yaml)["T_BS"]["data"].as<std::vector<double>>();
  EXPECT_EQ(values.size(), 16u);
  return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
}

// world_from_body of a row: p then q as w x y z.
Eigen::Matrix4d world_from_body(const std::vector<double>& row) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = Eigen::Quaterniond(row[4], row[5], row[6], row[7]).toRotationMatrix();
  T.topRightCorner<3, 1>() = Eigen::Vector3d(row[1], row[2], row[3]);
  return T;
}

TEST_F(Export, EurocImagesAreGreyAndNamedByStamp) {
  const fs::path cam = run("euroc") / "mav0/cam0";
  const auto rows = table(cam / "data.csv", ',');
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[1], (std::vector<std::string>{"100000000", "100000000.png"}));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const cv::Mat grey = cv::imread((cam / "data" / rows[i][1]).string(), cv::IMREAD_UNCHANGED);
    const cv::Mat color = sequence_image(sequence_.frames[i].rgb);
    ASSERT_EQ(grey.type(), CV_8UC1);
    double worst = 0;
    for (int v = 0; v < grey.rows; ++v)
      for (int u = 0; u < grey.cols; ++u) {
        const auto& c = color.at<cv::Vec3b>(v, u);
        worst = std::max(worst,
                         std::abs(0.114 * c[0] + 0.587 * c[1] + 0.299 * c[2] - grey.at<unsigned char>(v, u)));
      }
    EXPECT_LT(worst, 0.51);  // rounded luma (ITU-R BT.601), with OpenCV's fixed-point weights
  }
}

TEST_F(Export, EurocBodyTimesExtrinsicsIsTheCamera) {
  const fs::path mav = run("euroc") / "mav0";
  const Eigen::Matrix4d body_from_camera = body_from_sensor(mav / "cam0/sensor.yaml");
  EXPECT_TRUE(body_from_sensor(mav / "imu0/sensor.yaml").isIdentity(0));
  const auto rows = table(mav / "state_groundtruth_estimate0/data.csv", ',');
  ASSERT_EQ(rows.size(), 4u);
  const auto K = YAML::LoadFile(mav / "cam0/sensor.yaml")["intrinsics"].as<std::vector<double>>();
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto row = numbers(rows[static_cast<std::size_t>(frame)]);
    ASSERT_EQ(row.size(), 17u);
    EXPECT_EQ(static_cast<std::int64_t>(row[0]), sequence_.frames[static_cast<std::size_t>(frame)].stamp_ns);
    const Eigen::Matrix4d world_from_camera = world_from_body(row) * body_from_camera;
    const Eigen::Matrix4d expected = truth_.camera[static_cast<std::size_t>(frame)].pose.matrix();
    EXPECT_LT((world_from_camera - expected).norm(), 1e-12);  // rounding of a few products
    // the ball's near pole lies on its mask
    const Ellipsoid& ball = truth_of(kBall, frame).ellipsoid;
    const Eigen::Vector3d center = ball.world_from_object.translation;
    const Eigen::Vector3d eye = world_from_camera.topRightCorner<3, 1>();
    const Eigen::Vector3d pole = center + ball.semi_axes_m.x() * (eye - center).normalized();
    const Eigen::Vector4d p = world_from_camera.inverse() * pole.homogeneous();
    EXPECT_EQ(id_at(instances(frame), {K[0] * p.x() / p.z() + K[2], K[1] * p.y() / p.z() + K[3]}), kBall);
  }
}

TEST_F(Export, EurocStateHasVelocitiesAndBiases) {
  const auto rows = table(run("euroc") / "mav0/state_groundtruth_estimate0/data.csv", ',');
  const Scene scene = load_scene(folder() / "scene.yaml");
  const Pose camera_from_imu = sequence_.imu->camera_from_imu;
  const auto position_at = [&](double t) {
    return (scene.camera_motion.at(t) * camera_from_imu).translation;
  };
  const auto biases = table(data() / "truth/imu_bias.csv", ',');  // first row: the header
  for (int frame = 1; frame < 3; ++frame) {
    const auto row = numbers(rows[static_cast<std::size_t>(frame)]);
    const double t = 0.1 * frame;
    const Eigen::Vector3d velocity = (position_at(t + 1e-4) - position_at(t - 1e-4)) / 2e-4;
    // a difference over 0.2 s is off by 0.1^2 / 6 of the jerk, here some m/s^3
    EXPECT_LT((Eigen::Vector3d(row[8], row[9], row[10]) - velocity).norm(), 0.02);
    EXPECT_GT(velocity.norm(), 0.1);
    const auto bias = numbers(biases[static_cast<std::size_t>(1 + 10 * frame)]);  // 100 Hz
    ASSERT_EQ(bias[0], row[0]);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(row[11 + i], bias[1 + i]);
  }
}

TEST_F(Export, EurocImuReadsAsItStands) {
  const fs::path imu = run("euroc") / "mav0/imu0";
  const auto rows = table(imu / "data.csv", ','), original = table(sequence_.folder / "imu.csv", ',');
  ASSERT_EQ(rows.size() + 1, original.size());  // whose header has no #
  ASSERT_GE(rows.size(), 31u);
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(numbers(rows[i]), numbers(original[i + 1]));
  const YAML::Node sensor = YAML::LoadFile(imu / "sensor.yaml");
  EXPECT_EQ(sensor["rate_hz"].as<double>(), 100);
  EXPECT_EQ(sensor["gyroscope_noise_density"].as<double>(), sequence_.imu->gyroscope_noise_radps_rthz);
  EXPECT_EQ(sensor["accelerometer_random_walk"].as<double>(), sequence_.imu->accelerometer_walk_mps3_rthz);
}

TEST_F(Export, EurocRectifiesACameraWithAFifthCoefficient) {
  sequence_.camera.distortion = {0.05, 0, 0, 0, 0.02};
  rewrite_index();
  const fs::path cam = run("euroc") / "mav0/cam0";
  EXPECT_EQ(YAML::LoadFile(cam / "sensor.yaml")["distortion_coefficients"].as<std::vector<double>>(),
            std::vector<double>(4, 0.0));
  // the principal point stays where it is; 65 px off the axis (r = 0.5) a point was 0.9 px further out
  const cv::Mat grey = cv::imread((cam / "data/0.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Mat color = sequence_image(sequence_.frames[0].rgb);
  const auto luma = [&](double u, double v) {
    const int u0 = static_cast<int>(u), v0 = static_cast<int>(v);
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      const auto& c = color.at<cv::Vec3b>(v0 + i / 2, u0 + i % 2);
      const double weight = std::abs(1 - i % 2 - (u - u0)) * std::abs(1 - i / 2 - (v - v0));
      sum += weight * (0.114 * c[0] + 0.587 * c[1] + 0.299 * c[2]);
    }
    return sum;
  };
  double worst = 0;
  for (int u = 20; u < 140; ++u) {
    const double x = (u - 79.5) / 130, y = (60 - 59.5) / 130, r2 = x * x + y * y;
    const double radial = 1 + 0.05 * r2 + 0.02 * r2 * r2 * r2;
    worst = std::max(worst, std::abs(luma(130 * x * radial + 79.5, 130 * y * radial + 59.5) -
                                     grey.at<unsigned char>(60, u)));
  }
  EXPECT_LT(worst, 4);  // grey levels: OpenCV's remap knows positions to 1/32 px
}

}  // namespace
}  // namespace uniquadric
