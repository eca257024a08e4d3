#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace uniquadric {

/// Runs of neighbours in a recording that are the same: a sensor that froze, or files that were copied.
class Repeats {
 public:
  /// The next one, and whether it is the same as the one before it. Numbers in increasing order.
  void add(std::int64_t number, bool is_same);

  /// "4 to 13", or "4 to 13 (and 2 more such runs)"; nothing where no two neighbours are the same.
  std::optional<std::string> text() const;

 private:
  std::int64_t last_ = 0, first_of_run_ = 0, last_of_run_ = 0;  // the run is the first one
  int runs_ = 0;
  bool is_in_run_ = false;
};

}  // namespace uniquadric
