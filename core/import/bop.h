#pragma once

#include <filesystem>

#include "core/import/recording.h"

namespace uniquadric {

struct ImportBopOptions : ImportOptions {
  /// Folder of models_info.json and obj_NNNNNN.ply; empty: models/ or models_eval/ two folders above the
  /// scene.
  std::filesystem::path models;
  double rate_hz = 30;  ///< images a second: the layout has no times
};

/// Turns a scene folder of the BOP challenge into `out`/sequence and, where poses of camera or objects are
/// known, `out`/truth. Colour or grey images, depth, visible masks, objects' poses; an object's frame is
/// moved to the centre of its model's box. Meshes become truth/objects/ID.ply. Without world poses of the
/// camera the objects are kept in its frame.
///
/// An object has its model's obj_id. Of several of one model in an image the second and later ones, in the
/// order of scene_gt.json, have ids of their own. Throws InputError, with file and image, for what is missing
/// or malformed; then nothing is left at `out`.
void import_bop(const std::filesystem::path& scene, const ImportBopOptions& options,
                const std::filesystem::path& out);

}  // namespace uniquadric
