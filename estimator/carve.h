#pragma once

#include <map>

#include "core/sequence/sequence.h"
#include "estimator/backend.h"
#include "estimator/perception/perception_files.h"
#include "estimator/variant.h"

namespace uniquadric {

/// The bodies that depth images saw through, by id: closed meshes in the frame of their final states, of one
/// shape each (BodyCarving). None without depth images and final states.
std::map<int, SurfaceFile> carve_bodies(const Sequence& sequence, const Perception& perception,
                                        const BackendResult& result, const Variant& variant);

}  // namespace uniquadric
