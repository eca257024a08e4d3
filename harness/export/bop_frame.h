#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/export/export_source.h"

namespace uniquadric {

/// A vector or matrix as BOP writes them: millimetres; row by row.
std::vector<double> bop_vector_mm(const Eigen::Vector3d& v_m);
std::vector<double> bop_matrix(const Eigen::Matrix3d& M);
/// [u, v, width, height] px; -1 four times, the format's own word for none.
std::vector<int> bop_box(const std::optional<PixelBox>& box);

/// One frame as BOP tells it: the truth's objects that the image would show if nothing hid them, in order of
/// ids, and what is seen of them. Without truth there are none.
struct BopFrame {
  Camera camera;
  std::vector<ObjectAtFrame> objects;
  cv::Mat ids;        ///< 16UC1, rectified
  cv::Mat has_depth;  ///< 8UC1; empty where the frame has no depth
};
BopFrame bop_frame(const ExportSource& source, const SequenceFrame& frame);

/// The frame's entries of scene_gt.json and scene_gt_info.json: JSON.
std::string bop_poses(const BopFrame& frame);
std::string bop_infos(const BopFrame& frame);

}  // namespace uniquadric
