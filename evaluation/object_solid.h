#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/sequence/calibration.h"
#include "core/sequence/tracks.h"
#include "evaluation/iou/solid.h"
#include "evaluation/iou/solid_iou.h"
#include "evaluation/metrics/body_surface.h"
#include "evaluation/object_evaluation.h"

namespace uniquadric {

/// The body that an object really is, and how its inside is known.
struct TrueSolid {
  std::string kind;  ///< box, ellipsoid, or of a mesh: closed, closed_unoriented, open
  SolidSamples samples;
  ReferenceSurface surface;  ///< of the mesh, or the tessellated body
  double surface_tolerance_m = 0;
};

/// In the object's frame: what truth/objects/ID.ply encloses, else the box or the ellipsoid that the truth
/// says it is; null for other shapes. `seed`: of its samples. Keep one for all estimates. Throws InputError
/// as true_surface().
std::unique_ptr<const TrueSolid> true_solid(const std::filesystem::path& truth,
                                            const ObjectDescription& object, std::uint64_t seed);

/// The mesh that an estimate gives of a body, in the frame of its states, scaled.
struct EstimatedMesh {
  MeshSolid solid;
  double volume_m3 = 0;
  ReferenceSurface surface;
};

/// ESTIMATE/solids/ID.ply; null without that file. Throws InputError for a file that cannot be read or has no
/// faces.
std::unique_ptr<const EstimatedMesh> estimated_mesh(const std::filesystem::path& estimate, int id,
                                                    double scale, std::uint64_t seed);

/// Throws InputError for a file in ESTIMATE/solids that belongs to no track: nobody would look at it.
void require_tracks_of_solids(const std::filesystem::path& estimate, const Tracks& tracks);

/// Fills `iou3d_solid` of the matched frames and `solid` of an object, where its true body encloses a volume:
/// the estimate as it came, in the true world, against it. `truth` and `estimate` are the tracks that were
/// matched; `mesh` not null: the estimated body, whatever the states' shapes. The same for any number of
/// processors.
void compare_solids(const TrueSolid& body, const EstimatedMesh* mesh, const ObjectTrack& truth,
                    const ObjectTrack& estimate, ObjectEvaluation& object);

/// Fills `surface_f1` and `chamfer_m` of the matched frames and `surface_tolerance_m` of an object, where its
/// true surface has an area. Mesh and tracks are those of compare_solids(). The same for any number of
/// processors.
void compare_body_surfaces(const TrueSolid& body, const EstimatedMesh* mesh, const ObjectTrack& truth,
                           const ObjectTrack& estimate, ObjectEvaluation& object);

}  // namespace uniquadric
