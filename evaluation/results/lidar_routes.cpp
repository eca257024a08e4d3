#include "evaluation/results/lidar_routes.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "evaluation/results/summary.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

using Fields = std::vector<std::string_view>;

constexpr const char* kComparison = "scan,beams,matched,lost,extra,mean_m,median_abs_m,p95_abs_m,rms_m";
constexpr const char* kErrors = "from_m,to_m,beams";
constexpr const char* kTiming = "stage,count,ms_each";

// The rows below the header, each with as many fields as it has.
void for_each_row(const fs::path& file, const char* header,
                  const std::function<void(int, const Fields&)>& row) {
  const std::size_t columns = split(header, ',').size();
  bool first = true;
  for_each_line(
      file,
      [&](int line, const Fields& fields) {
        if (std::exchange(first, false)) {
          if (fields != split(header, ','))
            throw InputError(file, line, fmt::format("expected the header {}", header));
        } else if (fields.size() != columns) {
          throw InputError(file, line, fmt::format("expected {} columns, found {}", columns, fields.size()));
        } else {
          row(line, fields);
        }
      },
      ',');
  if (first) throw InputError(file, "is empty, expected a header");
}

double number(const fs::path& file, int line, std::string_view text) {
  if (const auto value = parse_double(text)) return *value;
  throw InputError(file, line, fmt::format("'{}' is not a finite number", text));
}

std::int64_t count(const fs::path& file, int line, std::string_view text) {
  const auto value = parse_integer(text);
  if (value && *value >= 0) return *value;
  throw InputError(file, line, fmt::format("'{}' is no whole number", text));
}

void read_comparison(const fs::path& file, LidarRoutes& routes) {
  std::vector<double> medians, p95s;
  double sum_m = 0, squares_m2 = 0;
  for_each_row(file, kComparison, [&](int line, const Fields& fields) {
    ++routes.scans;
    routes.beams += count(file, line, fields[1]);
    const std::int64_t matched = count(file, line, fields[2]);
    routes.matched += matched;
    routes.lost += count(file, line, fields[3]);
    routes.extra += count(file, line, fields[4]);
    sum_m += static_cast<double>(matched) * number(file, line, fields[5]);
    squares_m2 += static_cast<double>(matched) * std::pow(number(file, line, fields[8]), 2);
    medians.push_back(number(file, line, fields[6]));
    p95s.push_back(number(file, line, fields[7]));
  });
  if (routes.matched > 0) {
    routes.mean_m = sum_m / static_cast<double>(routes.matched);
    routes.rms_m = std::sqrt(squares_m2 / static_cast<double>(routes.matched));
  }
  if (!medians.empty()) {
    routes.median_abs_m = median(medians);
    routes.p95_abs_m = median(p95s);
  }
}

// The outer cells' open ends are empty.
void read_errors(const fs::path& file, LidarRoutes& routes) {
  const auto edge = [&](int line, std::string_view text, double open) {
    return text.empty() ? open : number(file, line, text);
  };
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for_each_row(file, kErrors, [&](int line, const Fields& fields) {
    const ErrorCell cell{edge(line, fields[0], -kInfinity), edge(line, fields[1], kInfinity),
                         count(file, line, fields[2])};
    if (!(cell.from_m < cell.to_m) || (!routes.errors.empty() && cell.from_m != routes.errors.back().to_m))
      throw InputError(file, line, "a cell begins where the one before it ends");
    routes.errors.push_back(cell);
  });
}

void read_timing(const fs::path& file, LidarRoutes& routes) {
  for_each_row(file, kTiming, [&](int line, const Fields& fields) {
    if (fields[0] == "lidar_octree") routes.octree_ms = number(file, line, fields[2]);
    if (fields[0] == "lidar_embree") routes.embree_ms = number(file, line, fields[2]);
  });
}

}  // namespace

double LidarRoutes::completeness() const {
  return matched + lost == 0 ? 1 : static_cast<double>(matched) / static_cast<double>(matched + lost);
}

std::optional<double> LidarRoutes::speed_ratio() const {
  if (!octree_ms || !embree_ms || !(*embree_ms > 0)) return std::nullopt;
  return *octree_ms / *embree_ms;
}

std::int64_t LidarRoutes::beyond() const {
  std::int64_t beams_beyond = 0;
  for (const ErrorCell& cell : errors)
    if (!std::isfinite(cell.from_m) || !std::isfinite(cell.to_m)) beams_beyond += cell.beams;
  return beams_beyond;
}

std::optional<LidarRoutes> read_lidar_routes(const fs::path& folder, const std::string& scene,
                                             std::uint64_t seed) {
  if (!fs::exists(folder / "comparison.csv")) return std::nullopt;
  LidarRoutes routes;
  routes.scene = scene;
  routes.seed = seed;
  read_comparison(folder / "comparison.csv", routes);
  read_errors(folder / "errors.csv", routes);
  if (fs::exists(folder / "timing.csv")) read_timing(folder / "timing.csv", routes);
  return routes;
}

std::string lidar_markdown(const std::vector<LidarRoutes>& routes) {
  if (routes.empty()) return "";
  std::string text =
      "\n## LiDAR: depth image and octree against Embree\n"
      "The same beams without noise; error is the octree's range minus Embree's, completeness the share of "
      "Embree's "
      "points that the octree has too, extra what it alone has; times are of one thread, as measured.\n\n"
      "| scene | seed | scans | completeness | extra | mean [m] | rms [m] | median \\|error\\| [m] | 95 % "
      "[m] | "
      "octree [ms/scan] | Embree [ms/scan] | Embree is faster by |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n";
  const auto optional = [](const std::optional<double>& value) {
    return value ? format_figure(*value) : "-";
  };
  for (const LidarRoutes& r : routes)
    text += fmt::format("| {} | {} | {} | {:.4f} | {} | {} | {} | {} | {} | {} | {} | {} |\n", r.scene,
                        r.seed, r.scans, r.completeness(), r.extra, format_figure(r.mean_m),
                        format_figure(r.rms_m), format_figure(r.median_abs_m), format_figure(r.p95_abs_m),
                        optional(r.octree_ms), optional(r.embree_ms), optional(r.speed_ratio()));
  return text;
}

}  // namespace uniquadric
