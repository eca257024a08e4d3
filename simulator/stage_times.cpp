#include "simulator/stage_times.h"

#include <fmt/format.h>
#include <time.h>

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

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void FrameTimes::add_to(StageTimes& times) const {
  times.add("first_frame", 1e-9 * static_cast<double>(sums_->first_ns), sums_->workers);
  for (std::size_t i = 0; i < kFrameStages.size(); ++i)
    times.add(fmt::format("frame_{}", kFrameStages[i]), 1e-9 * static_cast<double>(sums_->stage_ns[i]),
              sums_->frames);
  times.add("truth_and_imu", 1e-9 * static_cast<double>(sums_->descriptions_ns));
}

}  // namespace uniquadric
