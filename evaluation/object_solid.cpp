#include "evaluation/object_solid.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/sequence/object_body.h"
#include "evaluation/object_surface.h"

namespace uniquadric {
namespace {

// In the box about the true body; measured: a standard error of 0.002 of a frame at most.
constexpr int kCandidates = 32768;
// Of an estimated mesh that is not closed, or whose parts meet; ours: some 0.002 of its volume.
constexpr int kVolumeCandidates = 1 << 17;
constexpr std::size_t kGrain = 8;  // frames in a row, which often have one shape

std::vector<std::size_t> matched_frames(const ObjectEvaluation& object) {
  std::vector<std::size_t> matched;
  for (std::size_t k = 0; k < object.frames.size(); ++k)
    if (object.frames[k].state) matched.push_back(k);
  return matched;
}

}  // namespace

std::unique_ptr<const TrueSolid> true_solid(const std::filesystem::path& truth,
                                            const ObjectDescription& object, std::uint64_t seed) {
  Solid solid{{object.semi_axes_m}};
  const auto made_of = [&](const std::string& kind, const SurfaceFile& surface) {
    return std::unique_ptr<const TrueSolid>(new TrueSolid{kind, SolidSamples(solid, kCandidates, seed),
                                                          reference_surface(surface),
                                                          surface_tolerance_m(surface)});
  };
  if (const auto surface = true_surface_of_file(truth, object)) {
    solid.mesh = std::make_shared<MeshSolid>(surface->points, surface->triangles);
    return made_of(to_string(solid.mesh->kind()), *surface);
  }
  if (object.shape == "box")
    solid.body.exponents = kBoxExponents;
  else if (object.shape != "ellipsoid" && object.shape != "ball")
    return nullptr;
  return made_of(is_box(solid.body) ? "box" : "ellipsoid", tessellate(solid.body));
}

std::unique_ptr<const EstimatedMesh> estimated_mesh(const std::filesystem::path& estimate, int id,
                                                    double scale, std::uint64_t seed) {
  const std::filesystem::path file = estimate / "solids" / fmt::format("{}.ply", id);
  if (!std::filesystem::exists(file)) return nullptr;
  SurfaceFile mesh = read_surface_ply(file);
  if (mesh.triangles.empty()) throw InputError(file, "has no faces: a body is a mesh");
  for (Eigen::Vector3f& point : mesh.points) point *= static_cast<float>(scale);
  const auto solid = std::make_shared<MeshSolid>(mesh.points, mesh.triangles);
  const double volume_m3 =
      solid->known_volume().value_or(SolidSamples({{}, solid}, kVolumeCandidates, seed).volume());
  if (!(volume_m3 > 0)) throw InputError(file, "encloses no volume");
  return std::make_unique<const EstimatedMesh>(*solid, volume_m3, reference_surface(mesh));
}

void require_tracks_of_solids(const std::filesystem::path& estimate, const Tracks& tracks) {
  if (!std::filesystem::exists(estimate / "solids")) return;
  for (const auto& entry : std::filesystem::directory_iterator(estimate / "solids"))
    if (std::ranges::none_of(tracks.objects, [&](const ObjectTrack& track) {
          return entry.path().filename() == fmt::format("{}.ply", track.id);
        }))
      throw InputError(entry.path(), "is no mesh (ID.ply) of an object of the estimate");
}

void compare_solids(const TrueSolid& body, const EstimatedMesh* mesh, const ObjectTrack& truth,
                    const ObjectTrack& estimate, ObjectEvaluation& object) {
  const std::vector<std::size_t> matched = matched_frames(object);
  if (matched.empty() || !(body.samples.volume() > 0)) return;
  std::vector<SolidIou> pairs(matched.size());
  tbb::parallel_for(std::size_t{0}, matched.size(), [&](std::size_t i) {
    const std::size_t k = matched[i];
    const ObjectState& state = estimate.states[*object.frames[k].state];
    const Pose& world_from_truth = truth.states[k].ellipsoid.world_from_object;
    const Pose truth_from_estimate = relative_pose(world_from_truth, state.ellipsoid.world_from_object);
    pairs[i] = mesh ? solid_iou(body.samples, mesh->solid, mesh->volume_m3, truth_from_estimate)
                    : solid_iou(body.samples, body_of(state), truth_from_estimate);
  });
  for (std::size_t i = 0; i < matched.size(); ++i) object.frames[matched[i]].iou3d_solid = pairs[i].iou;
  object.solid = {body.kind, mesh ? to_string(mesh->solid.kind()) : "states", mean_iou(pairs)};
}

void compare_body_surfaces(const TrueSolid& body, const EstimatedMesh* mesh, const ObjectTrack& truth,
                           const ObjectTrack& estimate, ObjectEvaluation& object) {
  const std::vector<std::size_t> matched = matched_frames(object);
  if (matched.empty() || body.surface.points.empty()) return;
  const auto compare_frames = [&](const tbb::blocked_range<std::size_t>& range) {
    std::optional<Superellipsoid> shape;
    std::optional<ReferenceSurface> surface;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      ObjectFrame& frame = object.frames[matched[i]];
      const ObjectState& state = estimate.states[*frame.state];
      if (!mesh && (!shape || *shape != body_of(state))) {
        shape = body_of(state);
        surface = reference_surface(tessellate(*shape));
      }
      const ReferenceSurface& estimated = mesh ? mesh->surface : *surface;
      if (estimated.points.empty()) continue;  // too small to have an area
      const Pose& world_from_truth = truth.states[matched[i]].ellipsoid.world_from_object;
      const SurfaceScore score = surface_score(
          body.surface, estimated, relative_pose(world_from_truth, state.ellipsoid.world_from_object),
          body.surface_tolerance_m);
      frame.surface_f1 = score.f1;
      frame.chamfer_m = score.chamfer_m;
    }
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, matched.size(), kGrain), compare_frames);
  object.surface_tolerance_m = body.surface_tolerance_m;
}

}  // namespace uniquadric
