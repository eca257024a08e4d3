#include "estimator/upright/upright_sight.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr double kLastShare = 0.05;  // of the points, that tell where an end is
constexpr int kLeastLast = 4;
constexpr double kOutliers = 0.002;   // of the points, that may lie beyond an end
constexpr double kLeastSigma = 0.02;  // of an end, share of the body's size in view
constexpr double kRim = 0.1;          // of the width, beyond which a point is on another side
constexpr double kGrazing = 0.1;      // slope of the line of sight to a side, under which that is hardly seen
constexpr double kSideSteps = 2;      // distances of points on a side, that it may go on by
constexpr double kYawStep = std::numbers::pi / 180;
constexpr int kMostFree = 30;  // points of a scan that err each in its own way
constexpr double kAlike = 2;   // that a yaw's sigma is larger than if scans erred by themselves
constexpr double kRims = 0.9;  // share of the points, nearest to the sides, that tell the yaw

Eigen::Vector2d direction_of(double yaw_rad) {
  return {std::cos(yaw_rad), std::sin(yaw_rad)};
}

Eigen::Vector2d left_of(const Eigen::Vector2d& direction) {
  return {-direction.y(), direction.x()};
}

// Numbers of the points from the furthest along a direction on.
std::vector<int> furthest_first(const Eigen::VectorXd& along) {
  std::vector<int> order(static_cast<std::size_t>(along.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return along[a] > along[b]; });
  return order;
}

struct Extent {
  double low, high, sensor;
  bool faces_low() const { return sensor < low; }
  bool faces_high() const { return sensor > high; }
  bool is_beside() const { return !faces_low() && !faces_high(); }
};

Extent extent_along(const UprightSight& sight, const Eigen::Vector2d& direction) {
  const Eigen::VectorXd along = sight.points.transpose() * direction;
  std::vector<double> values(along.data(), along.data() + along.size());
  return {quantile(values, kOutliers), quantile(values, 1 - kOutliers), direction.dot(sight.sensor)};
}

// From beam to beam along a side that leads to an end in this direction; 0 of one that faces the sensor,
// which ends where its points are.
double beam_gap_along(const UprightSight& sight, const Eigen::Vector2d& direction, double end_m) {
  if (direction.dot(sight.sensor) > end_m) return 0;
  const Eigen::Vector2d beam = (sight.points.rowwise().mean() - sight.sensor).normalized();
  const double slope = std::abs(beam.x() * direction.y() - beam.y() * direction.x());
  return sight.beam_gap_m / std::max(slope, kGrazing);
}

BoxEnd end_towards(const UprightSight& sight, const Eigen::Vector2d& direction, double size_m) {
  const Eigen::VectorXd along = sight.points.transpose() * direction;
  const std::vector<int> order = furthest_first(along);
  const auto count = std::ssize(order);
  const auto first = static_cast<std::ptrdiff_t>(kOutliers * static_cast<double>(count));
  const auto last = std::min<std::ptrdiff_t>(
      count,
      first + std::max<std::ptrdiff_t>(kLeastLast, std::lround(kLastShare * static_cast<double>(count))));
  BoxEnd end;
  end.direction = direction;
  end.position_m = along[order[first]];
  end.sigma_m = std::hypot(end.position_m - along[order[last - 1]], kLeastSigma * size_m);
  std::ptrdiff_t cut = 0;
  for (std::ptrdiff_t k = first; k < last; ++k)
    cut += !sight.cut.empty() && sight.cut[static_cast<std::size_t>(order[k])];
  end.is_bound = 2 * cut > last - first;
  end.beyond_m = beam_gap_along(sight, direction, end.position_m);
  return end;
}

// The end that faces away is where the side that leads up to it ends, if that is in view, and more than a rim
// of it was met.
void bound_far_ends(const UprightSight& sight, const Eigen::Vector2d& direction, const Extent& along,
                    const Extent& across, BoxEnd& back, BoxEnd& front) {
  if (along.is_beside()) return;
  BoxEnd& far = along.faces_low() ? front : back;
  const double beyond_m = std::max(across.low - across.sensor, across.sensor - across.high),
               away_m = std::max(along.low - along.sensor, along.sensor - along.high);
  const double rim_m = kRim * (across.high - across.low);
  std::ptrdiff_t on_side = 0;
  for (Eigen::Index i = 0; i < sight.points.cols(); ++i) {
    const double u = direction.dot(sight.points.col(i));
    on_side += along.faces_low() ? u > along.low + rim_m : u < along.high - rim_m;
  }
  far.is_bound |= beyond_m < kGrazing * away_m || on_side < kLeastLast;
  if (on_side > 0)
    far.sigma_m =
        std::hypot(far.sigma_m, kSideSteps * (along.high - along.low) / static_cast<double>(on_side));
}

}  // namespace

UprightSight upright_sight(const FrameInfo& frame, const BodyObservation& body) {
  UprightSight sight;
  sight.frame = frame.frame;
  sight.stamp_ns = frame.stamp_ns;
  const Pose& world_from_camera = *frame.world_from_camera;
  Eigen::Matrix3Xd world = world_from_camera.rotation.toRotationMatrix() * body.points;
  world.colwise() += world_from_camera.translation;
  sight.points = world.topRows<2>();
  sight.cut = body.cut;
  sight.sensor = world_from_camera.translation.head<2>();
  std::vector<double> heights(world.cols());
  for (Eigen::Index i = 0; i < world.cols(); ++i) heights[i] = world(2, i);
  std::sort(heights.begin(), heights.end());
  sight.bottom_m = heights.front();
  if (body.contact) {
    const Eigen::Vector3d normal = world_from_camera.rotation * body.contact->normal;
    const double offset_m = body.contact->offset_m - normal.dot(world_from_camera.translation);
    const Eigen::Vector2d middle = sight.points.rowwise().mean();
    sight.bottom_m = -(offset_m + normal.head<2>().dot(middle)) / normal.z();
  }
  const auto last =
      static_cast<std::size_t>(std::max(0.0, static_cast<double>(heights.size()) * (1 - kLastShare) - 1));
  // the next row would have met what is higher by `row_gap_m`
  sight.height_m = heights.back() - sight.bottom_m;
  sight.height_sigma_m = heights.back() - heights[last] + kLeastSigma * sight.height_m;
  sight.row_gap_m = body.row_gap_m;
  sight.beam_gap_m = body.beam_gap_m;
  return sight;
}

UprightSight without_gaps(UprightSight sight) {
  sight.height_m += sight.row_gap_m / 2;
  sight.height_sigma_m += sight.row_gap_m / std::sqrt(12);
  sight.beam_gap_m = sight.row_gap_m = 0;
  return sight;
}

std::array<BoxEnd, 4> box_ends(const UprightSight& sight, double yaw_rad) {
  const Eigen::Vector2d ahead = direction_of(yaw_rad), left = left_of(ahead);
  const Extent along = extent_along(sight, ahead), across = extent_along(sight, left);
  const double length_m = along.high - along.low, width_m = across.high - across.low;
  std::array<BoxEnd, 4> ends = {end_towards(sight, -ahead, length_m), end_towards(sight, ahead, length_m),
                                end_towards(sight, -left, width_m), end_towards(sight, left, width_m)};
  bound_far_ends(sight, ahead, along, across, ends[0], ends[1]);
  bound_far_ends(sight, left, across, along, ends[2], ends[3]);
  return ends;
}

std::optional<SeenYaw> seen_yaw(const UprightSight& sight, double expected_rad, double reach_rad) {
  const auto off_sides = [&](double yaw_rad, double& longest_m) {
    const Eigen::Vector2d ahead = direction_of(yaw_rad), left = left_of(ahead);
    const Extent u = extent_along(sight, ahead), v = extent_along(sight, left);
    longest_m = std::max(u.high - u.low, v.high - v.low);
    std::vector<double> off(static_cast<std::size_t>(sight.points.cols()), 1e9);
    for (Eigen::Index i = 0; i < sight.points.cols(); ++i) {
      const double pu = ahead.dot(sight.points.col(i)), pv = left.dot(sight.points.col(i));
      double& least = off[static_cast<std::size_t>(i)];
      if (u.faces_low()) least = std::min(least, std::abs(pu - u.low));
      if (u.faces_high()) least = std::min(least, std::abs(u.high - pu));
      if (v.faces_low()) least = std::min(least, std::abs(pv - v.low));
      if (v.faces_high()) least = std::min(least, std::abs(v.high - pv));
    }
    std::sort(off.begin(), off.end());
    const auto kept = static_cast<std::size_t>(kRims * static_cast<double>(off.size()));
    double sum = 0;
    for (std::size_t i = 0; i < kept; ++i) sum += off[i];
    return sum / static_cast<double>(std::max<std::size_t>(1, kept));
  };
  double best_rad = expected_rad, best_m = 1e9, best_length_m = 0;
  const int steps = static_cast<int>(reach_rad / kYawStep);
  for (int step = -steps; step <= steps; ++step) {
    double length_m = 0;
    const double yaw_rad = expected_rad + step * kYawStep, off_m = off_sides(yaw_rad, length_m);
    if (off_m < best_m) best_rad = yaw_rad, best_m = off_m, best_length_m = length_m;
  }
  if (!(best_m < 1e8) || std::abs(best_rad - expected_rad) > reach_rad - kYawStep / 2) return std::nullopt;
  const double free = std::min<double>(kMostFree, static_cast<double>(sight.points.cols()));
  // scan after scan errs alike, by the same corners of the body
  const double sigma_rad = kAlike * (kYawStep + 3 * best_m * std::sqrt(12 / free) / best_length_m);
  if (sigma_rad > reach_rad / 2) return std::nullopt;
  return SeenYaw{best_rad, sigma_rad};
}

}  // namespace uniquadric
