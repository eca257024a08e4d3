#include "estimator/lidar/body_twist.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/quantile.h"
#include "estimator/lidar/pixel_grid.h"
#include "estimator/observation/ideal_ray.h"
#include "estimator/shape/even_choice.h"

namespace uniquadric {
namespace {

constexpr int kRounds = 2, kPixelRounds = 6;  // the first point update starts far off, but frames follow
constexpr std::size_t kLeastNeighbours = 5;
constexpr std::size_t kLeastRows = 10;
constexpr double kLeastSigma_m = 0.003, kCauchy = 2;  // sigmas

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Of a point now that moved for some seconds, with respect to the rate.
Eigen::Matrix<double, 3, 6> moved_by_rate(const BodyTwist& twist, const Eigen::Vector3d& now,
                                          double seconds) {
  Eigen::Matrix<double, 3, 6> J;
  J << seconds * Eigen::Matrix3d::Identity(), -seconds * cross_matrix(now - twist.middle);
  return J;
}

struct Row {
  Vector6d slope;  // of the residual
  double off, sigma;
};

// What rows say beside what was known before, the rate being somewhere near.
struct Normal {
  Matrix6d matrix;
  Vector6d right;
  Normal(const BodyTwist& before, const Vector6d& rate)
      : matrix(before.covariance.inverse()), right(matrix * (before.rate - rate)) {}
  void add(const Row& row, double share) {
    const double r = row.off / row.sigma;
    const double weight = share / (row.sigma * row.sigma * (1 + r * r / (kCauchy * kCauchy)));
    matrix += weight * row.slope * row.slope.transpose();
    right -= weight * row.off * row.slope;
  }
};

void move_middle(BodyTwist& twist, const Eigen::Vector3d& middle) {
  Matrix6d by = Matrix6d::Identity();
  by.topRightCorner<3, 3>() = -cross_matrix(middle - twist.middle);
  twist.middle = middle;
  twist.rate = by * twist.rate;
  twist.covariance = by * twist.covariance * by.transpose();
}

struct Placed {
  std::vector<Eigen::Vector3d> world;  // now
  std::vector<ImagePoint> image;
  std::vector<double> age_s;
};

Placed place(const BodyTwist& twist, const std::vector<AgedPoint>& points, const Pose& camera_from_world,
             const Camera& camera, int most) {
  Placed placed;
  for (const auto i : even_choice(std::ssize(points), most)) {
    const AgedPoint& point = points[static_cast<std::size_t>(i)];
    const Eigen::Vector3d now = moved_over(twist, point.age_s) * point.world;
    const Eigen::Vector3d in_camera = camera_from_world * now;
    const auto pixel = camera.project(in_camera);
    if (!pixel) continue;
    placed.world.push_back(now);
    placed.image.push_back({*pixel, 1 / in_camera.z()});
    placed.age_s.push_back(point.age_s);
  }
  return placed;
}

// Distance of a point from the plane through its neighbours.
std::optional<Row> row_of(const BodyTwist& twist, const Placed& placed, std::size_t i,
                          const std::vector<std::size_t>& near, const Pose& camera_from_world,
                          const Camera& camera, double max_jump) {
  const ImagePoint& here = placed.image[i];
  const auto row = [&](std::size_t j) {
    const Eigen::Vector2d d = placed.image[j].pixel - here.pixel;
    return Eigen::Vector3d(1, d.x() / camera.fx, d.y() / camera.fy);
  };
  std::vector<std::size_t> kept;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const std::size_t j : near) {
    const double w = placed.image[j].inverse_depth;
    if (j == i || std::abs(w - here.inverse_depth) > max_jump * here.inverse_depth) continue;
    normal += row(j) * row(j).transpose();
    right += w * row(j);
    kept.push_back(j);
  }
  Eigen::Matrix3d inverse;
  bool invertible = false;
  normal.computeInverseWithCheck(inverse, invertible, 1e-15);
  if (kept.size() < kLeastNeighbours || !invertible) return std::nullopt;
  const Eigen::Vector3d plane = inverse * right;
  const Eigen::Vector3d ray = ideal_ray(camera, here.pixel);
  const Eigen::Vector3d across(plane[1], plane[2], plane[0] - plane[1] * ray.x() - plane[2] * ray.y());
  const double z = 1 / here.inverse_depth, scale = 1 / across.norm();
  const Eigen::Vector3d to = camera_from_world.rotation.conjugate() * (across * scale);
  Row result{moved_by_rate(twist, placed.world[i], placed.age_s[i]).transpose() * to,
             scale * z * (plane[0] - here.inverse_depth), 1};
  double squares = 1;
  for (const std::size_t j : kept) {
    const double weight = (inverse * row(j))[0], other = weight * z * placed.image[j].inverse_depth;
    result.slope -= other * moved_by_rate(twist, placed.world[j], placed.age_s[j]).transpose() * to;
    squares += weight * weight;
  }
  result.sigma = std::sqrt(squares);
  if (!(result.sigma < 2)) return std::nullopt;  // on the rim of its neighbours
  return result;
}

}  // namespace

BodyTwist unknown_twist(const Eigen::Vector3d& middle, const BodyTwistOptions& options) {
  BodyTwist twist;
  twist.middle = middle;
  const double v = options.first_velocity_mps, w = options.first_turn_radps;
  twist.covariance.diagonal() << v * v, v * v, v * v, w * w, w * w, w * w;
  return twist;
}

Pose moved_over(const BodyTwist& twist, double seconds) {
  Vector6d xi = twist.rate;
  xi.head<3>() -= twist.rate.tail<3>().cross(twist.middle);
  return exp_se3(xi * seconds);
}

void predict(BodyTwist& twist, double seconds, const BodyTwistOptions& options) {
  const Pose step = moved_over(twist, seconds);
  twist.middle = step * twist.middle;
  twist.rate.head<3>() = step.rotation * Eigen::Vector3d(twist.rate.head<3>());
  const double v = options.acceleration_mps2_rthz, w = options.turn_acceleration_radps2_rthz;
  twist.covariance.diagonal().head<3>().array() += v * v * seconds;
  twist.covariance.diagonal().tail<3>().array() += w * w * seconds;
}

void update_by_points(BodyTwist& twist, const std::vector<AgedPoint>& points, const Pose& camera_from_world,
                      const Camera& camera, const BodyTwistOptions& options) {
  if (points.size() < kLeastRows) return;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const AgedPoint& point : points) sum += moved_over(twist, point.age_s) * point.world;
  move_middle(twist, sum / static_cast<double>(points.size()));
  const BodyTwist before = twist;
  for (int round = 0; round < kRounds; ++round) {
    const Placed placed = place(twist, points, camera_from_world, camera, options.max_points);
    const auto k = static_cast<std::size_t>(options.neighbours);
    const PixelGrid grid(placed.image, options.reach_px, k + 1);
    std::vector<Row> rows;
    std::vector<double> off;
    for (std::size_t i = 0; i < placed.image.size(); ++i) {
      const auto near = grid.nearest(placed.image[i].pixel, k + 1);
      const auto row = row_of(twist, placed, i, near, camera_from_world, camera, options.max_jump);
      if (!row) continue;
      rows.push_back(*row);
      off.push_back(std::abs(row->off) / row->sigma);
    }
    if (rows.size() < kLeastRows) return;
    const double sigma_m = std::max(kLeastSigma_m, kMadToSigma * quantile(std::move(off), 0.5));
    Normal normal(before, twist.rate);
    for (Row& row : rows) {
      row.sigma *= sigma_m;
      normal.add(row, 1 / options.rows_as_one);
    }
    twist.rate += normal.matrix.ldlt().solve(normal.right);
    twist.covariance = normal.matrix.inverse();
  }
}

void update_by_pixels(BodyTwist& twist, const std::vector<PointStep>& steps,
                      const Pose& last_camera_from_world, double step_s, const Camera& camera,
                      const BodyTwistOptions& options) {
  const BodyTwist before = twist;
  const Eigen::Matrix3d turn = last_camera_from_world.rotation.toRotationMatrix();
  for (int round = 0; round < kPixelRounds; ++round) {
    Normal normal(before, twist.rate);
    const Pose back = moved_over(twist, -step_s);
    for (const PointStep& step : steps) {
      const Eigen::Vector3d last = back * step.world, p = last_camera_from_world * last;
      const auto pixel = camera.project(p);
      if (!pixel) continue;
      Eigen::Matrix<double, 2, 3> projected;
      projected << camera.fx / p.z(), 0, -camera.fx * p.x() / (p.z() * p.z()), 0, camera.fy / p.z(),
          -camera.fy * p.y() / (p.z() * p.z());
      const Eigen::Matrix<double, 2, 6> J = projected * turn * moved_by_rate(twist, last, -step_s);
      const Eigen::Vector2d off = *pixel - step.last_pixel;
      for (int axis = 0; axis < 2; ++axis) normal.add({J.row(axis), off[axis], options.pixel_sigma}, 1);
    }
    twist.rate += normal.matrix.ldlt().solve(normal.right);
    twist.covariance = normal.matrix.inverse();
  }
}

}  // namespace uniquadric
