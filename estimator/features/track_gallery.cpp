#include "estimator/features/track_gallery.h"

namespace uniquadric {
namespace {

struct Nearest {
  int distance = 257, second = 257;
  std::size_t index = 0;
  void offer(int d, std::size_t i) {
    if (d < distance) {
      second = distance;
      distance = d;
      index = i;
    } else if (d < second) {
      second = d;
    }
  }
};

}  // namespace

std::vector<GalleryMatch> match_descriptors(const std::vector<GalleryQuery>& queries,
                                            const std::vector<PointTrack>& entries, int map,
                                            const GalleryOptions& options) {
  std::vector<Nearest> by_query(queries.size()), by_entry(entries.size());
  for (std::size_t e = 0; e < entries.size(); ++e) {
    if (entries[e].map != map) continue;
    for (std::size_t q = 0; q < queries.size(); ++q) {
      const int distance = descriptor_distance(queries[q].descriptors, entries[e].descriptors);
      by_query[q].offer(distance, e);
      by_entry[e].offer(distance, q);
    }
  }
  std::vector<GalleryMatch> matches;
  for (std::size_t q = 0; q < queries.size(); ++q) {
    const Nearest& best = by_query[q];
    if (best.distance <= options.max_distance && best.distance < options.max_ratio * best.second &&
        by_entry[best.index].index == q)
      matches.push_back({q, best.index});
  }
  return matches;
}

std::optional<Recognition> recognise(const std::vector<GalleryQuery>& queries,
                                     const std::vector<PointTrack>& entries, int map, const Camera& camera,
                                     const GalleryOptions& options, RandomStream& random) {
  const auto matches = match_descriptors(queries, entries, map, options);
  if (std::ssize(matches) < options.min_matches) return std::nullopt;
  std::vector<PointSighting> sightings;
  for (const auto& match : matches) {
    sightings.push_back(queries[match.query].sighting);
    sightings.back().point = entries[match.entry].landmark->point;
  }
  RigidMotionOptions motion;
  motion.pixel_gate = options.pixel_gate;
  motion.pixel_sigma = 1;  // corners are found at whole pixels
  motion.min_inliers = options.min_matches;
  motion.min_share = options.min_share;
  motion.iterations = 500;  // three of a third of good matches are drawn with 1 - 1e-8
  const auto fit = fit_rigid_motion(sightings, camera, std::nullopt, motion, random);
  if (!fit) return std::nullopt;
  Recognition result{fit->camera_from_body, {}};
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (fit->inlier[i]) result.matches.push_back(matches[i]);
  return result;
}

}  // namespace uniquadric
