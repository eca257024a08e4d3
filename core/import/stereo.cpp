#include "core/import/stereo.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/import/images.h"

namespace uniquadric {
namespace {

constexpr double kNearest_m = 0.5;     // ours: what a small aerial vehicle keeps away from
constexpr int kMostDisparities = 256;  // px; the search takes as long as there are
constexpr int kBlock = 5;              // px; with kSmall, kLarge as OpenCV's documentation advises for it
constexpr int kSmall = 8 * kBlock * kBlock, kLarge = 32 * kBlock * kBlock;
constexpr int kUnique_percent = 10, kSpeckle_px = 100, kSpeckleRange = 2, kLeftRight_px = 1;
constexpr double kDisparityUnits = 16;  // StereoSGBM's, a pixel

cv::Mat_<double> matrix_of(const Camera& c) {
  return (cv::Mat_<double>(3, 3) << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
}

cv::Mat_<double> distortion_of(const Camera& camera) {
  return cv::Mat_<double>(1, 5, const_cast<double*>(camera.distortion.data())).clone();
}

}  // namespace

struct StereoRig::Maps {
  cv::Mat left[2], right[2];
};

StereoRig::StereoRig(const Camera& left, const Camera& right, const Pose& right_from_left) {
  const cv::Size size(left.width, left.height);
  const Eigen::Matrix3d R = right_from_left.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = right_from_left.translation;
  cv::Mat_<double> rotation(3, 3), translation = (cv::Mat_<double>(3, 1) << t.x(), t.y(), t.z());
  for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = R(i / 3, i % 3);
  cv::Mat_<double> R_left, R_right, P_left, P_right;
  cv::Mat Q;
  cv::stereoRectify(matrix_of(left), distortion_of(left), matrix_of(right), distortion_of(right), size,
                    rotation, translation, R_left, R_right, P_left, P_right, Q, cv::CALIB_ZERO_DISPARITY, 0);
  auto maps = std::make_unique<Maps>();
  cv::initUndistortRectifyMap(matrix_of(left), distortion_of(left), R_left, P_left, size, CV_32FC1,
                              maps->left[0], maps->left[1]);
  cv::initUndistortRectifyMap(matrix_of(right), distortion_of(right), R_right, P_right, size, CV_32FC1,
                              maps->right[0], maps->right[1]);
  maps_ = std::move(maps);
  camera_ = {left.width, left.height, P_left(0, 0), P_left(1, 1), P_left(0, 2), P_left(1, 2), {}};
  Eigen::Matrix3d turn;
  for (int i = 0; i < 9; ++i) turn(i / 3, i % 3) = R_left(i / 3, i % 3);
  rectified_from_left_.rotation = Eigen::Quaterniond(turn).normalized();
  bf_ = -P_right(0, 3);
}

StereoRig::StereoRig(StereoRig&&) noexcept = default;
StereoRig::~StereoRig() = default;

cv::Mat StereoRig::rectify_left(const cv::Mat& image) const {
  cv::Mat rectified;
  cv::remap(image, rectified, maps_->left[0], maps_->left[1], cv::INTER_LINEAR);
  return rectified;
}

cv::Mat StereoRig::depth(const cv::Mat& left, const cv::Mat& right, double units_per_m) const {
  cv::Mat rectified_right, disparity;
  cv::remap(right, rectified_right, maps_->right[0], maps_->right[1], cv::INTER_LINEAR);
  const int disparities =
      std::clamp(16 * static_cast<int>(std::ceil(bf_ / kNearest_m / 16)), 16, kMostDisparities);
  cv::StereoSGBM::create(0, disparities, kBlock, kSmall, kLarge, kLeftRight_px, 0, kUnique_percent,
                         kSpeckle_px, kSpeckleRange)
      ->compute(rectify_left(left), rectified_right, disparity);
  disparity.convertTo(disparity, CV_16U);  // what is negative has none
  return depth_of_disparity(disparity, bf_, kDisparityUnits, units_per_m);
}

}  // namespace uniquadric
