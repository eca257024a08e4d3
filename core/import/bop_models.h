#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>

namespace uniquadric {

/// BOP gives lengths in millimetres.
inline constexpr double kBopMmPerM = 1000;

/// The box of a model: half its extents, and its centre in the model's frame [m].
struct BopModel {
  Eigen::Vector3d semi_axes_m = Eigen::Vector3d::Ones();
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
};

/// models_info.json: models by obj_id. Throws InputError with file and line.
std::map<int, BopModel> read_bop_models(const std::filesystem::path& file);

}  // namespace uniquadric
