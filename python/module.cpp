// The module _uniquadric, which the package uniquadric wraps: core's readers and evaluation's metrics.
#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/version.h"
#include "core/sequence/stamps.h"
#include "python/module_parts.h"

namespace uniquadric::python {
namespace {

constexpr double kRotationTolerance = 1e-3;  // as of a quaternion's norm in a file

// The shortest decimal number that reads back as the double is rounded to whole nanoseconds.
std::int64_t stamp_ns_of(double seconds) {
  try {
    return parse_stamp_ns(fmt::format("{}", seconds));
  } catch (const std::invalid_argument&) {
    throw InputError(fmt::format("stamp_s: {} is not a timestamp in seconds", seconds));
  }
}

}  // namespace

Eigen::Quaterniond quaternion_of(const Eigen::Matrix4d& matrix, const std::string& what) {
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  if (!rotation.allFinite()) throw InputError(what + ": the rotation holds a number that is not finite");
  if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw InputError(what + ": expected 0 0 0 1 as the last row of the matrix");
  const double off = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(off <= kRotationTolerance))
    throw InputError(fmt::format("{}: R^T R is off the identity by {}, so R is no rotation", what, off));
  if (rotation.determinant() < 0)
    throw InputError(what + ": the rotation is a reflection, as its determinant is -1");
  return Eigen::Quaterniond(rotation).normalized();
}

Pose pose_of(const Eigen::Matrix4d& matrix, const std::string& what) {
  const Eigen::Vector3d position_m = matrix.topRightCorner<3, 1>();
  if (!position_m.allFinite()) throw InputError(what + ": the position holds a number that is not finite");
  if (position_m.cwiseAbs().maxCoeff() > kMostCoordinate_m)
    throw InputError(fmt::format("{}: is further than {} m from the origin", what, kMostCoordinate_m));
  return {quaternion_of(matrix, what), position_m};
}

void require_stamp(std::int64_t stamp_ns) {
  if (stamp_ns < -kMostStamp_ns || stamp_ns > kMostStamp_ns)
    throw InputError(fmt::format("stamp_ns: {} is not within {} ns of 1970", stamp_ns, kMostStamp_ns));
}

void append(Trajectory& trajectory, std::int64_t stamp_ns, const Eigen::Matrix4d& matrix,
            const std::string& what) {
  require_stamp(stamp_ns);
  if (!trajectory.empty() && stamp_ns <= trajectory.back().stamp_ns)
    throw InputError(fmt::format("{}: timestamp {} does not come after {}", what, format_stamp(stamp_ns),
                                 format_stamp(trajectory.back().stamp_ns)));
  trajectory.push_back({stamp_ns, pose_of(matrix, what)});
}

py::array_t<double> matrices_of(const std::vector<Pose>& poses) {
  py::array_t<double> matrices({static_cast<py::ssize_t>(poses.size()), py::ssize_t{4}, py::ssize_t{4}});
  auto view = matrices.mutable_unchecked<3>();
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Eigen::Matrix4d matrix = poses[k].matrix();
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column)
        view(static_cast<py::ssize_t>(k), row, column) = matrix(row, column);
  }
  return matrices;
}

py::tuple arrays_of(const Trajectory& trajectory) {
  std::vector<Pose> poses;
  for (const StampedPose& stamped : trajectory) poses.push_back(stamped.pose);
  return py::make_tuple(array_of(stamps_of(trajectory)), matrices_of(poses));
}

py::tuple camera_of(const Camera& camera) {
  const std::vector<double> distortion(camera.distortion.begin(), camera.distortion.end());
  return py::make_tuple(camera.width, camera.height, camera.matrix(), array_of(distortion));
}

py::object camera_of(const std::optional<Camera>& camera) {
  return camera ? py::object(camera_of(*camera)) : py::none();
}

}  // namespace uniquadric::python

PYBIND11_MODULE(_uniquadric, module) {
  using namespace uniquadric;
  auto& error = pybind11::register_exception<InputError>(module, "InputError", PyExc_ValueError);
  error.attr("__module__") = "uniquadric";
  error.doc() = "Bad input: the text is the line that the program ends with.";
  module.attr("__version__") = kVersion;
  module.def("read_text", &read_text);
  module.def("stamp_ns_of", &python::stamp_ns_of);
  module.def("quaternion_of", [](const Eigen::Matrix4d& matrix, const std::string& what) -> Eigen::Vector4d {
    return python::quaternion_of(matrix, what).coeffs();  // x, y, z, w
  });
  python::add_sequence(module);
  python::add_tracks(module);
  python::add_result(module);
  python::add_metrics(module);
}
