#include "evaluation/feature_depth.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/sequence/stamps.h"
#include "evaluation/image_overlap.h"
#include "evaluation/metrics/surface_distance.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr const char* kHeader = "frame,timestamp_ns,body,track,u_px,v_px,depth_m,depth_sigma_m";
constexpr double kMostPixel = 1e6, kMostDepth_m = 1e9;

// A number of a row; nothing where it is left empty.
std::optional<double> number_of(const fs::path& file, int line, std::string_view field, double most) {
  if (field.empty()) return std::nullopt;
  const auto value = parse_double(field);
  if (!value || !(std::abs(*value) <= most))
    throw InputError(file, line, fmt::format("'{}' is no number up to {}", field, most));
  return value;
}

}  // namespace

std::map<int, std::vector<SightedDepth>> read_features(const fs::path& estimate) {
  const fs::path file = estimate / "features.csv";
  std::map<int, std::vector<SightedDepth>> features;
  if (!fs::exists(file)) return features;
  bool header = true;
  for_each_line(
      file,
      [&](int line, const std::vector<std::string_view>& fields) {
        if (std::exchange(header, false)) {
          if (fields != split(kHeader, ','))
            throw InputError(file, line, fmt::format("expected the header {}", kHeader));
          return;
        }
        if (fields.size() != 8)
          throw InputError(file, line, fmt::format("expected 8 columns, found {}", fields.size()));
        const auto stamp = parse_stamp_of_ns(fields[1]);
        const auto body = parse_integer(fields[2]);
        const auto u = number_of(file, line, fields[4], kMostPixel),
                   v = number_of(file, line, fields[5], kMostPixel),
                   depth_m = number_of(file, line, fields[6], kMostDepth_m);
        if (!stamp || !body || *body != static_cast<int>(*body) || !u || !v || (depth_m && !(*depth_m > 0)))
          throw InputError(file, line, "expected whole numbers, a pixel and a depth greater than 0 or none");
        features[static_cast<int>(*body)].push_back({*stamp, {*u, *v}, depth_m});
      },
      ',');
  return features;
}

std::optional<FeatureDepthError> feature_depth_error(const std::vector<SightedDepth>& sightings,
                                                     const SurfaceFile& surface, const ObjectTrack& object,
                                                     const Trajectory& world_from_camera,
                                                     const Camera& camera, std::int64_t max_difference_ns) {
  const SurfaceDistance body(surface.points, surface.triangles);
  const Camera ideal = without_distortion(camera);
  Trajectory poses;
  for (const ObjectState& state : object.states)
    poses.push_back({state.stamp_ns, state.ellipsoid.world_from_object});
  FeatureDepthError result;
  std::vector<double> errors_m;
  for (const SightedDepth& seen : sightings) {
    const Pose* world_from_object = nearest_pose(poses, seen.stamp_ns, max_difference_ns);
    const Pose* from_camera = nearest_pose(world_from_camera, seen.stamp_ns, max_difference_ns);
    const auto ray = ideal.unproject(seen.pixel);  // its z is 1: depth counts along it
    if (!world_from_object || !from_camera || !ray) continue;
    ++result.sightings;
    const Pose object_from_camera = world_from_object->inverse() * *from_camera;
    const auto depth_m = body.along(object_from_camera.translation, object_from_camera.rotation * *ray);
    if (!depth_m)
      ++result.off_body;
    else if (seen.depth_m)
      errors_m.push_back(std::abs(*seen.depth_m - *depth_m));
  }
  if (result.sightings == 0) return std::nullopt;
  const std::uint64_t on_body = result.sightings - result.off_body;
  result.coverage = on_body > 0 ? static_cast<double>(errors_m.size()) / static_cast<double>(on_body) : 0;
  result.error_m = statistics(errors_m);
  if (!errors_m.empty()) result.quantile_90_m = interpolated_quantile(std::move(errors_m), 0.9);
  return result;
}

}  // namespace uniquadric
