#pragma once

#include <cstdint>
#include <filesystem>

#include "estimator/variant.h"

namespace uniquadric {

struct EstimateOptions {
  std::uint64_t seed = 0;
  int threads = 0;  ///< 0: as many as the machine has
  bool quiet = false;
  bool force = false;          ///< replace an existing output folder
  std::filesystem::path prompts;  ///< file or folder of prompts; empty: everything
};

/// Runs a variant of the estimator on a sequence folder and writes Tracks, timing.csv and run.yaml to `out`. The same
/// sequence, variant and seed give the same bytes (timing.csv excepted) for any number of threads.
void estimate(const std::filesystem::path& sequence, const Variant& variant, const EstimateOptions& options,
              const std::filesystem::path& out);

}  // namespace uniquadric
