#include "estimator/images/repeats.h"

#include <fmt/format.h>

#include <utility>

namespace uniquadric {

void Repeats::add(std::int64_t number, bool is_same) {
  if (is_same && !std::exchange(is_in_run_, true) && ++runs_ == 1) first_of_run_ = last_;
  is_in_run_ = is_same;
  if (is_in_run_ && runs_ == 1) last_of_run_ = number;
  last_ = number;
}

std::optional<std::string> Repeats::text() const {
  if (runs_ == 0) return std::nullopt;
  std::string text = fmt::format("{} to {}", first_of_run_, last_of_run_);
  if (runs_ > 1) text += fmt::format(" (and {} more such runs)", runs_ - 1);
  return text;
}

}  // namespace uniquadric
