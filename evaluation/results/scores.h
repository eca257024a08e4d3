#pragma once

#include <optional>
#include <string>
#include <vector>

#include "evaluation/results/metrics.h"
#include "evaluation/results/results.h"

namespace uniquadric {

/// A row of scores.csv; no value means that the run failed, or lost the object, where another run had a
/// figure.
struct Score {
  std::string sequence, object, variant;
  std::uint64_t seed = 0;
  const Metric* metric = nullptr;
  std::optional<double> value;
};

/// One row a figure. Every run that was tried has a row for each metric that any run of the same sequence and
/// object has; of a sequence without a single good run one row, `all` / `coverage`, stands for the failure.
std::vector<Score> scores(const Results& results);

/// scores.csv (CLI contract); values read back as the same doubles.
std::string scores_csv(const std::vector<Score>& scores);

}  // namespace uniquadric
