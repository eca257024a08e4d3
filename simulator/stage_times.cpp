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

void FrameTimes::add_to(StageTimes& times) const {
  times.add("first_frame", 1e-9 * static_cast<double>(sums_->first_ns), sums_->workers);
  for (std::size_t i = 0; i < kFrameStages.size(); ++i)
    times.add(fmt::format("frame_{}", kFrameStages[i]), 1e-9 * static_cast<double>(sums_->stage_ns[i]),
              sums_->frames);
}

}  // namespace uniquadric
