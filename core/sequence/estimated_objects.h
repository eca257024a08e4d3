#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/sequence/tracks.h"

namespace uniquadric {

/// The columns of objects.csv, in the order in which this program writes them.
inline constexpr const char* kStateHeader =
    "frame,timestamp_ns,id,semi_axis_x_m,semi_axis_y_m,semi_axis_z_m,exponent_q,var_semi_axis_x_m2,"
    "var_semi_axis_y_m2,var_semi_axis_z_m2,var_translation_x_m2,var_translation_y_m2,var_translation_z_m2,"
    "var_rotation_x_rad2,var_rotation_y_rad2,var_rotation_z_rad2,state,motion,exponent_upper_q,"
    "exponent_lower_q,profile_axis";
inline constexpr std::string_view kAxisNames = "xyz";

/// objects/ID.tum of a folder of tracks.
std::filesystem::path trajectory_file(const std::filesystem::path& folder, int id);

/// What is wrong with these semi-axes; empty: nothing.
std::string semi_axes_fault(const Eigen::Vector3d& semi_axes_m);

/// What objects.yaml of an estimate says of an object's shape, whatever the time.
struct ObjectShape {
  Eigen::Vector3d semi_axes_m = Eigen::Vector3d::Ones();
  SuperExponents exponents;
  int profile_axis = 2;
};

/// Shapes by id of the short form of objects.yaml; none where there is no such file. Throws InputError.
std::map<int, ObjectShape> read_object_shapes(const std::filesystem::path& objects_yaml);

/// The id that a trajectory's file is named by. Throws InputError for other names.
int id_of_file(const std::filesystem::path& file);

/// The track of a trajectory (TUM text) named by its id, of constant shape; its frames are -1. Throws
/// InputError, also where `shapes` has none for it.
ObjectTrack track_of_shape(const std::filesystem::path& file, const std::map<int, ObjectShape>& shapes);

/// Whether objects.yaml is of the short form `ID: {size_m: [x, y, z]}` of other programs' results, and not a
/// truth's.
bool is_size_list(const std::filesystem::path& objects_yaml);

/// The objects of an estimate: poses of objects/ID.tum with the states of objects.csv, of which
/// `timestamp_ns` and `id` are needed and the other columns may be left out, in any order; sizes that it does
/// not have stand in objects.yaml, `ID: {size_m: [x, y, z]}` (a box) or `semi_axes_m` (an ellipsoid), with
/// `shape` as `metric` takes it. None of the three: no objects. Throws InputError with file and line.
std::vector<ObjectTrack> read_estimated_objects(const std::filesystem::path& folder);

}  // namespace uniquadric
