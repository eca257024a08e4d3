#include "evaluation/align/body_frame.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace uniquadric {
namespace {

constexpr std::array<std::pair<const char*, BodyFrame>, 3> kNames{
    {{"none", BodyFrame::none}, {"first", BodyFrame::first}, {"fit", BodyFrame::fit}}};

// Mean position, and the rotation that is nearest to the mean matrix.
Pose mean_pose(const std::vector<Pose>& poses, const std::vector<double>& weights) {
  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
  Eigen::Vector3d shifts = Eigen::Vector3d::Zero();
  double whole = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    turns += weights[i] * poses[i].rotation.toRotationMatrix();
    shifts += weights[i] * poses[i].translation;
    whole += weights[i];
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(turns, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const Eigen::Matrix3d turn =
      svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  return {Eigen::Quaterniond(turn), shifts / whole};
}

}  // namespace

const char* to_string(BodyFrame kind) {
  for (const auto& [name, value] : kNames)
    if (value == kind) return name;
  return "";
}

std::optional<BodyFrame> parse_body_frame(std::string_view text) {
  for (const auto& [name, value] : kNames)
    if (text == name) return value;
  return std::nullopt;
}

Pose body_frame_offset(BodyFrame kind, const std::vector<Pose>& reference,
                       const std::vector<Pose>& estimate) {
  if (kind == BodyFrame::none || reference.empty()) return {};
  if (kind == BodyFrame::first) return estimate[0].inverse() * reference[0];
  std::vector<Pose> offsets;
  for (std::size_t i = 0; i < reference.size(); ++i) offsets.push_back(estimate[i].inverse() * reference[i]);
  return mean_pose(offsets, std::vector<double>(offsets.size(), 1));
}

Pose usual_body_offset(const std::vector<Pose>& reference, const std::vector<Pose>& estimate,
                       double lever_m) {
  assert(!reference.empty() && reference.size() == estimate.size());
  constexpr int kIterations = 100;
  constexpr double kNear_m = 1e-6;  // pairs that are nearer weigh alike
  std::vector<Pose> offsets;
  for (std::size_t i = 0; i < reference.size(); ++i) offsets.push_back(reference[i].inverse() * estimate[i]);
  std::vector<double> weights(offsets.size(), 1);
  Pose usual = mean_pose(offsets, weights);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    for (std::size_t i = 0; i < offsets.size(); ++i) {
      const double turn_m = lever_m * usual.rotation.angularDistance(offsets[i].rotation);
      weights[i] =
          1 / std::max(kNear_m, std::hypot((usual.translation - offsets[i].translation).norm(), turn_m));
    }
    usual = mean_pose(offsets, weights);
  }
  return usual;
}

}  // namespace uniquadric
