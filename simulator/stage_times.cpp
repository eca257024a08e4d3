#include "simulator/stage_times.h"

#include <fmt/format.h>

#include <algorithm>

namespace uniquadric {

void StageTimes::add(const std::string& stage, double seconds, std::int64_t count) {
  auto found = std::find_if(stages_.begin(), stages_.end(), [&](const Stage& s) { return s.name == stage; });
  if (found == stages_.end()) found = stages_.insert(found, {stage});
  found->seconds += seconds;
  found->count += count;
}

std::string StageTimes::csv() const {
  std::string text = "stage,count,ms_each\n";
  for (const Stage& stage : stages_)
    if (stage.count > 0)
      text += fmt::format("{},{},{:.6g}\n", stage.name, stage.count,
                          1e3 * stage.seconds / static_cast<double>(stage.count));
  return text;
}

}  // namespace uniquadric
