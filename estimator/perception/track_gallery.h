#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/perception/rigid_motion.h"
#include "estimator/perception/surface_descriptor.h"
#include "estimator/perception/tracked_body.h"

namespace uniquadric {

/// All numbers are ours.
struct GalleryOptions {
  int body_tracks = 600;         // kept of each body, the last lost first
  int background_tracks = 3000;  // kept of the background
  int min_sightings = 3;         // of a track that is worth keeping
  int max_distance = 70;         // of 256 bits: beyond, chance matches are as many as true ones
  double max_ratio = 0.85;       // of the best match's distance to the second best's
  int min_matches = 8;           // that must agree on one rigid motion
  double min_share = 0.25;       // of the matches
  double pixel_gate = 4;         // of an agreeing match
};

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
