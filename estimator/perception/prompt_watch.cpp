#include "estimator/perception/prompt_watch.h"

#include <fmt/format.h>

#include "core/sequence/trajectory.h"

namespace uniquadric {
namespace {

constexpr std::size_t kMostFaults = 5;  // that are named one by one

}  // namespace

void PromptWatch::expect(std::int64_t stamp_ns, int id, const std::string& name) {
  const std::lock_guard lock(mutex_);
  Expected& expected = expected_.try_emplace(key_of(stamp_ns, id), Expected{stamp_ns, name}).first->second;
  ++expected.count;
}

void PromptWatch::found(std::int64_t stamp_ns, int id) {
  const std::lock_guard lock(mutex_);
  if (const auto expected = expected_.find(key_of(stamp_ns, id)); expected != expected_.end())
    expected->second.found = true;
}

std::vector<std::string> PromptWatch::faults() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> lines;
  std::size_t more = 0;
  for (const auto& [key, expected] : expected_) {
    if (expected.found) continue;
    if (lines.size() == kMostFaults) {
      ++more;
      continue;
    }
    std::string line = fmt::format("{}: ", prompts_.string());
    if (ids_last_) line += fmt::format("object {}: ", key.second);
    const std::string first = fmt::format("{} at {} s", expected.name, format_stamp(expected.first_ns));
    line += expected.count == 1 ? fmt::format("the {} gave no mask", first)
                                : fmt::format("none of its {} prompts gave a mask, the first being the {}",
                                              expected.count, first);
    lines.push_back(line);
  }
  if (more > 0) lines.push_back(fmt::format("{}: {} more prompts gave no mask", prompts_.string(), more));
  return lines;
}

}  // namespace uniquadric
