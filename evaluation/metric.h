#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>

namespace uniquadric {

struct MetricOptions {
  std::string method = "exact";  ///< of iou3d: exact or monte-carlo
  int samples = 100'000;         ///< of monte-carlo, and of shapes whose IoU has no closed form
  std::uint64_t seed = 0;        ///< of the same
};

/// Answers each JSON line of `in` with one JSON line on `out`, as it comes. `kind` is iou3d, iou2d, project
/// or pose. A bad line is answered with its id (where it is told, whatever else is wrong), `error` and
/// `line` (its number, blank ones counted), the others go on. Returns the exit code: 0, or 2 when any line
/// was bad. Throws InputError for an unknown kind, method or number of samples, std::runtime_error where
/// `out` takes no more.
int run_metric(const std::string& kind, const MetricOptions& options, std::istream& in, std::ostream& out);

}  // namespace uniquadric
