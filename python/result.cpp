// The writer of estimate folders, which refuses a bad state when it is given.
#include <fmt/format.h>

#include <map>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/estimated_objects.h"
#include "python/module_parts.h"

namespace uniquadric::python {
namespace {

constexpr double kLeastExponent = 1, kMostExponent = 2;  // a box, an ellipsoid

SuperExponents exponents_of(const Eigen::Vector3d& exponents) {
  for (const double q : exponents)
    if (!(q >= kLeastExponent && q <= kMostExponent))
      throw InputError(fmt::format("exponents: {} is not from {} (a box) to {} (an ellipsoid)", q,
                                   kLeastExponent, kMostExponent));
  return {exponents[0], exponents[1], exponents[2]};
}

Eigen::Vector3d require_semi_axes(const Eigen::Vector3d& semi_axes_m) {
  if (!semi_axes_m.allFinite()) throw InputError("semi_axes_m: holds a number that is not finite");
  if (const std::string fault = semi_axes_fault(semi_axes_m); !fault.empty())
    throw InputError("semi_axes_m: " + fault);
  return semi_axes_m;
}

class ResultWriter {
 public:
  void camera(std::int64_t stamp_ns, const Eigen::Matrix4d& world_from_camera) {
    append(camera_, stamp_ns, world_from_camera, "world_from_camera");
  }

  void object(int id, std::int64_t stamp_ns, const Eigen::Matrix4d& world_from_object,
              const Eigen::Vector3d& semi_axes_m, const Eigen::Vector3d& exponents) {
    if (id <= 0) throw InputError(fmt::format("id: {} is not an integer greater than 0", id));
    ObjectState state;
    state.frame = -1;
    state.stamp_ns = stamp_ns;
    state.ellipsoid.semi_axes_m = require_semi_axes(semi_axes_m);
    state.exponents = exponents_of(exponents);
    Trajectory last;
    const auto track = objects_.find(id);
    if (track != objects_.end()) last.push_back({track->second.states.back().stamp_ns, {}});
    append(last, stamp_ns, world_from_object, fmt::format("world_from_object of object {}", id));
    state.ellipsoid.world_from_object = last.back().pose;
    ObjectTrack& to = objects_[id];
    to.id = id;
    to.states.push_back(state);
  }

  void write(const std::filesystem::path& folder, bool force) const {
    Tracks tracks{camera_, {}, {}};
    for (const auto& [id, track] : objects_) tracks.objects.push_back(track);
    number_frames(tracks);
    PendingFolder pending(folder, "estimate", force);
    write_estimate(pending.path(), tracks);
    pending.commit();
  }

 private:
  Trajectory camera_;
  std::map<int, ObjectTrack> objects_;
};

}  // namespace

void add_result(py::module_& module) {
  py::class_<ResultWriter>(module, "ResultWriter")
      .def(py::init<>())
      .def("camera", &ResultWriter::camera)
      .def("object", &ResultWriter::object)
      .def("write", &ResultWriter::write);
}

}  // namespace uniquadric::python
