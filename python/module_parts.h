// What the files of the Python module share: conversions between this program's types and NumPy's arrays.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/sequence/trajectory.h"

namespace uniquadric::python {

namespace py = pybind11;

/// The rotation of a 4x4 transform. Throws InputError naming `what` for a rotation that is none or not
/// finite, and a last row other than 0 0 0 1.
Eigen::Quaterniond quaternion_of(const Eigen::Matrix4d& matrix, const std::string& what);

/// The transform of a 4x4 matrix. Throws InputError as quaternion_of(), and for a position that is not finite
/// or beyond kMostCoordinate_m.
Pose pose_of(const Eigen::Matrix4d& matrix, const std::string& what);

/// Throws InputError for a stamp beyond kMostStamp_ns.
void require_stamp(std::int64_t stamp_ns);

/// Adds a pose. Throws InputError as the two above, and for a stamp that does not come after the last.
void append(Trajectory& trajectory, std::int64_t stamp_ns, const Eigen::Matrix4d& matrix,
            const std::string& what);

/// (stamps [ns] of n poses, their matrices n x 4 x 4).
py::tuple arrays_of(const Trajectory& trajectory);
py::array_t<double> matrices_of(const std::vector<Pose>& poses);

/// (width, height, K 3x3, k1 k2 p1 p2 k3).
py::tuple camera_of(const Camera& camera);
/// The same of what may be missing: None.
py::object camera_of(const std::optional<Camera>& camera);

/// A one-dimensional array of a copy of the values.
template <typename T>
py::array_t<T> array_of(const std::vector<T>& values) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

void add_sequence(py::module_& module);
void add_tracks(py::module_& module);
void add_result(py::module_& module);
void add_metrics(py::module_& module);

}  // namespace uniquadric::python
