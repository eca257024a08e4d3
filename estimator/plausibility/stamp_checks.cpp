#include "estimator/plausibility/stamp_checks.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "core/sequence/stamps.h"

namespace uniquadric {
namespace {

constexpr double kMostRate_hz = 1000, kLeastRate_hz = 0.1;  // of cameras and LiDARs
constexpr double kLeastShared = 0.5;  // of the frames' time, that another sensor must share

struct Span {
  std::int64_t first_ns = 0, last_ns = 0;
};

std::optional<Span> span_of(const std::vector<std::int64_t>& stamps_ns) {
  if (stamps_ns.empty()) return std::nullopt;
  return Span{stamps_ns.front(), stamps_ns.back()};
}

double usual_step_s(const std::vector<std::int64_t>& stamps_ns) {
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i)
    steps_s.push_back(seconds(stamps_ns[i - 1], stamps_ns[i]));
  return steps_s.empty() ? 0 : upper_median(std::move(steps_s));
}

std::optional<std::string> rate_cause(const std::vector<std::int64_t>& stamps_ns) {
  const double step_s = usual_step_s(stamps_ns);
  if (step_s == 0) return std::nullopt;
  const char* unit = step_s > 1 / kLeastRate_hz  ? "milliseconds in place of seconds"
                     : step_s < 1 / kMostRate_hz ? "seconds in a smaller unit, as if divided by 1000 or more"
                                                 : nullptr;
  if (!unit) return std::nullopt;
  return fmt::format("stamps come every {:.3g} s: they look like {}", step_s, unit);
}

// Share of the span that the other one covers.
double shared(const Span& span, const Span& other) {
  const double length_s = seconds(span.first_ns, span.last_ns);
  const double both_s =
      seconds(std::max(span.first_ns, other.first_ns), std::min(span.last_ns, other.last_ns));
  return length_s > 0 ? std::max(0.0, both_s) / length_s : 1;
}

}  // namespace

std::vector<std::string> stamp_suspicions(const Sequence& sequence) {
  std::vector<std::string> found;
  const auto add = [&](const char* file, const std::string& what) {
    found.push_back((sequence.folder / file).string() + ": " + what);
  };
  const auto frames = stamps_of(sequence.frames), scans = stamps_of(sequence.scans);
  if (const auto cause = rate_cause(frames)) add("rgb.txt", *cause);
  if (const auto cause = rate_cause(scans)) add("lidar.txt", *cause);
  const auto base = span_of(frames.size() > 1 ? frames : scans);
  if (!base) return found;
  const auto compare = [&](const char* file, const std::vector<std::int64_t>& stamps_ns) {
    const auto other = span_of(stamps_ns);
    if (!other || stamps_ns.size() < 2) return;
    const double share = std::max(shared(*base, *other), shared(*other, *base));
    if (share < kLeastShared)
      add(file, fmt::format("spans {}..{} s, the {} {}..{} s: they look like other clocks or units",
                            format_stamp(other->first_ns), format_stamp(other->last_ns),
                            frames.size() > 1 ? "frames" : "scans", format_stamp(base->first_ns),
                            format_stamp(base->last_ns)));
  };
  if (frames.size() > 1) compare("lidar.txt", scans);
  if (sequence.given_camera) compare("camera_given.tum", stamps_of(*sequence.given_camera));
  try {
    if (sequence.imu) compare("imu.csv", stamps_of(read_imu_csv(sequence.folder / "imu.csv")));
  } catch (const InputError&) {  // is told by who checks the file
  }
  return found;
}

}  // namespace uniquadric
