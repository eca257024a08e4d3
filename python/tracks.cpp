// Truth and estimate folders as NumPy's arrays.
#include "core/sequence/tracks.h"

#include "python/module_parts.h"

namespace uniquadric::python {
namespace {

constexpr const char* kAxes = "xyz";

// A row a state, as many columns as `values` gives.
template <int N, typename Values>
py::array_t<double> table(const ObjectTrack& track, Values values) {
  py::array_t<double> array({static_cast<py::ssize_t>(track.states.size()), py::ssize_t{N}});
  for (std::size_t k = 0; k < track.states.size(); ++k) {
    const Eigen::Matrix<double, N, 1> row = values(track.states[k]);
    std::copy_n(row.data(), N, array.mutable_data(static_cast<py::ssize_t>(k), 0));
  }
  return array;
}

template <typename Value>
auto column(const ObjectTrack& track, Value value) {
  std::vector<decltype(value(track.states.front()))> values;
  for (const ObjectState& state : track.states) values.push_back(value(state));
  return values;
}

Eigen::Vector3d exponents_of(const ObjectState& state) {
  return {state.exponents.outline, state.exponents.upper, state.exponents.lower};
}

py::dict track_of(const ObjectTrack& track) {
  const auto poses = column(track, [](const ObjectState& s) { return s.ellipsoid.world_from_object; });
  py::dict result;
  result["id"] = track.id;
  result["name"] = track.name;
  result["frame"] = array_of(column(track, [](const ObjectState& s) { return s.frame; }));
  result["stamp_ns"] = array_of(column(track, [](const ObjectState& s) { return s.stamp_ns; }));
  result["world_from_object"] = matrices_of(poses);
  result["semi_axes_m"] = table<3>(track, [](const ObjectState& s) { return s.ellipsoid.semi_axes_m; });
  result["exponents"] = table<3>(track, exponents_of);
  result["profile_axis"] = column(track, [](const ObjectState& s) { return kAxes[s.profile_axis]; });
  result["variances"] = table<9>(track, [](const ObjectState& s) { return s.covariance_diagonal; });
  result["status"] = column(track, [](const ObjectState& s) { return to_string(s.status); });
  result["motion"] = column(track, [](const ObjectState& s) { return to_string(s.motion); });
  return result;
}

py::tuple tracks_of(const std::filesystem::path& folder) {
  const Tracks tracks = read_tracks(folder);
  py::list objects;
  for (const ObjectTrack& track : tracks.objects) objects.append(track_of(track));
  return py::make_tuple(arrays_of(tracks.camera), objects, camera_of(tracks.calibration));
}

}  // namespace

void add_tracks(py::module_& module) {
  module.def("read_tracks", &tracks_of);
}

}  // namespace uniquadric::python
