#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/features/features.h"
#include "estimator/features/surface_descriptor.h"
#include "estimator/features/tracked_body.h"
#include "estimator/images/rigid_motion.h"

namespace uniquadric {

/// A new corner that asks whether it has been seen before.
struct GalleryQuery {
  PointSighting sighting;  ///< the point is not used
  std::vector<SurfaceDescriptor> descriptors;
};

struct GalleryMatch {
  std::size_t query = 0, entry = 0;
};

/// Queries whose nearest entry of a map is clearly nearer than the next and has them as its nearest.
std::vector<GalleryMatch> match_descriptors(const std::vector<GalleryQuery>& queries,
                                            const std::vector<PointTrack>& entries, int map,
                                            const GalleryOptions& options);

/// Where the camera is in a map by the matches of descriptors that agree on one rigid motion.
struct Recognition {
  Pose camera_from_map;
  std::vector<GalleryMatch> matches;  ///< those that agree
};
std::optional<Recognition> recognise(const std::vector<GalleryQuery>& queries,
                                     const std::vector<PointTrack>& entries, int map, const Camera& camera,
                                     const GalleryOptions& options, RandomStream& random);

}  // namespace uniquadric
