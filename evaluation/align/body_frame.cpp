#include "evaluation/align/body_frame.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <array>
#include <utility>

namespace uniquadric {
namespace {

constexpr std::array<std::pair<const char*, BodyFrame>, 3> kNames{
    {{"none", BodyFrame::none}, {"first", BodyFrame::first}, {"fit", BodyFrame::fit}}};

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
  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
  Eigen::Vector3d shifts = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const Pose offset = estimate[i].inverse() * reference[i];
    turns += offset.rotation.toRotationMatrix();
    shifts += offset.translation;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(turns, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const Eigen::Matrix3d turn =
      svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  return {Eigen::Quaterniond(turn), shifts / static_cast<double>(reference.size())};
}

}  // namespace uniquadric
