#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/base/random.h"
#include "core/sequence/sequence.h"
#include "estimator/shape/oriented_box.h"

namespace uniquadric {

/// What of a box is put into a cloud.
struct BoxCloudOptions {
  double spacing_m = 0.01;    ///< mean distance of neighbours
  double noise_m = 0;         ///< sigma along the face's normal
  double outliers = 0;        ///< share added, uniform within 0.5 m of the centre
  bool visible_only = false;  ///< the faces seen from 1.5 m along +x +y +z of the box
};

/// Random points on the faces of a box (3 x n, metres).
Eigen::Matrix3Xd box_cloud(const OrientedBox& box, const BoxCloudOptions& options, RandomStream& random);

/// A box in a generic pose.
OrientedBox generic_box(const Eigen::Vector3d& half_extents_m);

/// Depth, colour and id of a box that stands on the floor z = 0 before a camera, by ray casting in closed
/// form.
struct BoxImage {
  cv::Mat rgb;    ///< CV_8UC3, a blue box on a grey floor, both with noise
  cv::Mat depth;  ///< CV_16UC1, 5000 a metre
  cv::Mat mask;   ///< CV_16UC1, 1 on the box
};
BoxImage render_box(const Camera& camera, const Pose& world_from_camera, const OrientedBox& box,
                    RandomStream& random);

/// A camera at `eye` that looks at `target`, the image's top up.
Pose look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

/// The box and the view of frame `i` of the sequence below.
OrientedBox scene_box(int i);
Pose scene_camera(int i);

/// Writes a sequence of a box moving over the floor under a moving camera, with masks and given poses. Frame
/// 2 has no depth and frame 3 no masks when `gaps` says so.
Sequence write_box_sequence(const std::filesystem::path& folder, int frames, bool gaps);

}  // namespace uniquadric
