#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/base/random.h"

namespace uniquadric {

/// A row of scores.csv; no value where it failed.
struct FabricatedScore {
  std::string sequence, object, variant;
  std::uint64_t seed = 1;
  std::string metric;
  double value = 0;
  bool failed = false;
};

inline bool is_lower_better(const std::string& metric) {
  return metric.find("iou") == std::string::npos && metric != "coverage";
}

inline std::string fabricated_csv(const std::vector<FabricatedScore>& scores) {
  std::string text = "sequence,object,variant,seed,metric,value,better,status\n";
  for (const FabricatedScore& s : scores)
    text += fmt::format("{},{},{},{},{},{},{},{}\n", s.sequence, s.object, s.variant, s.seed, s.metric,
                        s.failed ? "" : fmt::format("{}", s.value),
                        is_lower_better(s.metric) ? "lower" : "higher", s.failed ? "failed" : "ok");
  return text;
}

inline std::vector<std::string> fabricated_metrics() {
  return {"ape_translation_rmse_m",
          "ape_rotation_rmse_rad",
          "rpe_translation_rmse_m",
          "d_shape_mean_m",
          "iou3d_ellipsoid_mean",
          "iou2d_mean",
          "coverage",
          "id_switches"};
}

/// Six sequences x 8 seeds of one object. What the seeds share is drawn by `common` (a scene is harder with
/// one seed than with another), what the two sides do not by `own`: errors spread by a factor e^noise, IoU by
/// noise / 5, coverage and id switches not at all.
inline std::vector<FabricatedScore> fabricated_scores(double noise, std::uint64_t own,
                                                      std::uint64_t common = 1) {
  constexpr double kSeedSpread = 0.3;
  std::vector<FabricatedScore> scores;
  std::uint32_t cell = 0;
  for (int sequence = 1; sequence <= 6; ++sequence)
    for (std::uint64_t seed = 1; seed <= 8; ++seed)
      for (const std::string& metric : fabricated_metrics()) {
        const double shared = RandomStream(common, "shared", ++cell).normal();
        const double draw = RandomStream(own, "own", cell).normal();
        FabricatedScore score{fmt::format("s{}", sequence), "cube", "v", seed, metric};
        if (metric == "coverage")
          score.value = 0.98;
        else if (metric == "id_switches")
          score.value = shared > 1 ? 1 : 0;
        else if (is_lower_better(metric))
          score.value = 0.02 * sequence * std::exp(kSeedSpread * shared + noise * draw);
        else
          score.value = 0.8 + 0.02 * shared + noise / 5 * draw;
        scores.push_back(score);
      }
  return scores;
}

/// Those of a metric, of all sequences or of one, times `factor`.
inline void scale(std::vector<FabricatedScore>& scores, const std::string& metric, double factor,
                  const std::string& sequence = "") {
  for (FabricatedScore& score : scores)
    if (score.metric == metric && (sequence.empty() || score.sequence == sequence)) score.value *= factor;
}

}  // namespace uniquadric
