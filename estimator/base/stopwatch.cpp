#include "estimator/base/stopwatch.h"

#include <fmt/format.h>

namespace uniquadric {

std::string timing_csv(const std::vector<StageTime>& times, std::string text) {
  for (const StageTime& time : times) text += fmt::format("{},{},{:.3f}\n", time.frame, time.stage, time.ms);
  return text;
}

}  // namespace uniquadric
