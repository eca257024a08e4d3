#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "evaluation/report/overview.h"
#include "evaluation/results/results.h"
#include "evaluation/results/summary.h"

namespace uniquadric {

struct PageOptions {
  std::size_t series_runs = 600;       ///< ours: of more runs the first seeds alone have plots; 0.2 MB each
  std::size_t judged_runs = 20'000;    ///< ours: the gate takes 35 kB of memory for each
  std::size_t spread_values = 60;      ///< ours: dots of a figure's runs; of more these are evenly spaced
  std::size_t summary_rows = 700;      ///< ours: of all scenes shown, 1.5 kB each
  std::size_t image_bytes = 800'000;   ///< ours: of all frames with overlays; a third more in base64
  std::size_t film_bytes = 1'000'000;  ///< ours: of all films together: with all else 8 MB a page
  std::size_t mesh_bytes = 800'000;    ///< ours: of all true meshes together, in JSON
  std::size_t motion_frames =
      150;  ///< ours: of a run in the 3D view; 10 kB an object, and no path looks angular
  std::size_t motion_poses = 20'000;    ///< ours: of all runs in the 3D view, 90 bytes each
  std::size_t series_values = 400'000;  ///< ours: of all plots over time, 6 bytes each
  int series_digits = 4;                ///< ours: finer than a pixel of a plot, half the page of full doubles
};

/// The page as one file that needs nothing else (page/ and Chart.js inlined).
std::string page_html(const Results& results, const std::vector<SummaryRow>& summary,
                      const Overview& overview, const PageOptions& options = {});

/// The page's data: everything but the pictures. JSON text, keys sorted. A figure of a single run is a
/// number, that of several an object. A column of a series is one value where it is constant. With more than
/// `options.series_values` in all, plots have every second frame, every third and so on; beyond every eighth
/// the first seeds alone have plots, and of these the first runs.
std::string page_data(const Results& results, const std::vector<SummaryRow>& summary,
                      const Overview& overview, const PageOptions& options);

/// The frames with overlays as JSON text: [{"scene", "variant", "seed", "available", "frames": [{"frame",
/// "jpeg" (base64)}]}], for each scene and variant those of its first good seed. When they exceed
/// `options.image_bytes`, every run keeps the same smaller number of evenly spaced frames; where
/// not each can keep one, as many evenly spaced runs as fit keep one.
std::string page_images(const Results& results, const PageOptions& options);

/// What scenery.json (scenery.h) of each scene has, with its frames, as JSON text: {SCENE: {..., "frames":
/// [{"frame", "stamp_ns", "jpeg" (base64)}]}}. When all frames exceed `options.film_bytes`, every scene keeps
/// the same smaller number of evenly spaced ones. Scenes beyond the first 40 are left out, clouds beyond the
/// first 4, and meshes of scenes that come after `options.mesh_bytes` of them. Throws InputError for a
/// scenery.json that is none.
std::string page_scenery(const Results& results, const PageOptions& options);

/// Trajectories and ellipsoids for the 3D view as JSON text, all in the truth's world, for each scene and
/// variant those of its first good seed that has poses.csv, `options.motion_frames` evenly spaced times each:
/// fewer where all would have more than `options.motion_poses` poses; beyond a thinning to kFewMotionFrames
/// the first runs alone are in the view:
/// {"truths": [{"stamps_ns", TRACKS}], "runs": [{"scene", "variant", "seed", "truth" (index), TRACKS,
/// "unmatched": [TRACK]}]}; TRACKS: "camera": [POSE], "objects": [TRACK]; TRACK: "object", "poses",
/// "semi_axes_m" (one where constant); POSE: [x, y, z, qx, qy, qz, qw] or null.
std::string page_motion(const Results& results, const PageOptions& options);

/// The report as Markdown: the summary, the failures, how it was made.
std::string page_markdown(const Results& results, const std::vector<SummaryRow>& summary,
                          const Overview& overview);

/// `total` evenly spaced down to `count` (first and last kept), as indices. Asserts 0 <= count <= total.
std::vector<std::size_t> evenly_spaced(std::size_t total, std::size_t count);

/// How the worlds of each variant's estimates were aligned with the truth's, "VARIANT: KIND", each distinct
/// and in order; nothing of evaluations that do not say.
std::vector<std::string> alignments_of(const Results& results);

/// The programs (name and version) that made the evaluations, and the seeds, each distinct and in order.
std::vector<std::string> programs_of(const Results& results);
std::vector<std::uint64_t> seeds_of(const Results& results);

}  // namespace uniquadric
