#include "estimator/window/cloud_alignment.h"

#include <pcl/kdtree/kdtree_flann.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/geometry/box_symmetry.h"
#include "estimator/shape/even_choice.h"
#include "estimator/window/normal_equations.h"

namespace uniquadric {
namespace {

struct Effort {
  int iterations;
  std::size_t stride;  // of the points that are used
};

constexpr Effort kFull{15, 1}, kRough{7, 4};
constexpr std::size_t kRefined = 5;                   // rough fits that are worth a full one
constexpr double kSamePlace = 0.02, kSameTurn = 0.1;  // [m], [rad] of rough fits that end alike
constexpr int kPartners = 6;        // model points among which one with a like normal is looked for
constexpr int kLeastModel = 50;     // points of a model that a pose is taken from
constexpr double kOtherSide = 0.3;  // share of the points that it must match more, to be the one that is seen
constexpr double kUnmatched = 0.45;  // the cost of a point one sigma off
constexpr double kEvidence = 0.1;    // of each residual: neighbours err together
constexpr double kMinDepth = 0.1;    // [m]
constexpr double kReach = 1.5;       // of a body that is not known all around, in radii of what is
constexpr double kAgreeing = 0.05;   // radii, by which points end inside the shape that they lie on
constexpr double kConverged = 1e-5;  // [m], [rad]

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Tree = pcl::KdTreeFLANN<pcl::PointXYZ>;

pcl::PointXYZ to_pcl(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

Tree tree_of(const Eigen::Matrix3Xd& points) {
  auto cloud = std::make_shared<Cloud>();
  for (const auto& p : points.colwise()) cloud->push_back(to_pcl(p));
  Tree tree;
  tree.setInputCloud(cloud);
  return tree;
}

struct SeenPoint {
  Eigen::Vector3d position, normal;  // camera frame
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
};

std::vector<SeenPoint> evenly_drawn(const BodyObservation& body, int most) {
  std::vector<SeenPoint> result;
  if (body.normals.cols() == 0) return result;
  for (const auto k : even_choice(body.points.cols(), most)) {
    result.push_back({body.points.col(k), body.normals.col(k)});
    if (body.colors.cols() > 0) result.back().color = body.colors.col(k);
  }
  return result;
}

double cauchy_loss(double residual) {
  return 2 * std::log1p(residual * residual / 4);
}

// By a right-hand perturbation of the body's pose: of the distance of a point, in the body's frame, from a
// plane of the surface with normal n.
Vector6d point_row(const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
  Vector6d row;
  row << -n, -p.cross(n);
  return row;
}

// And of how far a point of the body, p in the camera's frame, lies beyond a tangent.
Vector6d line_row(const Camera& camera, const SupportLine& line, const Pose& camera_from_body,
                  const Eigen::Vector3d& p) {
  const double u = camera.fx * line.normal.x(), v = camera.fy * line.normal.y(), z = p.z();
  const Eigen::Vector3d by_point(u / z, v / z, -(u * p.x() + v * p.y()) / (z * z));
  const Eigen::Vector3d turned = camera_from_body.rotation.conjugate() * by_point;
  Vector6d row;
  row << turned, (camera_from_body.inverse() * p).cross(turned);
  return row;
}

// Of a pose away from where it was expected.
double way_cost(const Pose& expected, const Pose& pose, const PoseSigmas& sigmas) {
  const double shift = (pose.translation - expected.translation).norm() / sigmas.translation_m;
  const double turn = expected.rotation.angularDistance(pose.rotation) / sigmas.rotation_rad;
  return (shift * shift + turn * turn) / 2;
}

struct CauchyEquations : NormalEquations {
  double cost = 0;

  void add(const Vector6d& row, double residual) {
    const double weight = 1 / (1 + residual * residual / 4);
    information += weight * row * row.transpose();
    gradient += weight * residual * row;
    cost += kEvidence * cauchy_loss(residual);
  }
};

struct Fit {
  Pose pose;
  Matrix6d information = Matrix6d::Zero();
  double cost = std::numeric_limits<double>::infinity();
  double matched = 0, distance_m = 0;
  double outline_px = 0, beyond_px = 0;  // mean distance off the tangents; of it what lies outside
};

class Aligner {
 public:
  Aligner(const Camera& camera, const BodyObservation& body, const SurfaceModel& model, const Pose& predicted,
          const PoseSigmas& sigmas, const CloudAlignmentOptions& options)
      : camera_(camera),
        model_(model),
        predicted_(predicted),
        sigmas_(sigmas),
        options_(options),
        seen_(evenly_drawn(body, options.max_points)),
        is_colored_(body.colors.cols() > 0 && model.colors.cols() > 0),
        bounds_(model.points.rowwise().minCoeff(), model.points.rowwise().maxCoeff()),
        tree_(tree_of(model.points)) {
    std::copy_if(body.silhouette->support.begin(), body.silhouette->support.end(), std::back_inserter(lines_),
                 [](const SupportLine& line) { return line.free; });
  }

  std::ptrdiff_t lines() const { return std::ssize(lines_); }

  double distance_at(const Pose& pose) const {
    Fit fit;
    fit.pose = pose;
    CauchyEquations equations;
    add_points(fit, options_.far_m, kFull.stride, equations);
    return fit.distance_m;
  }

  Fit fit_from(const Pose& start, const Effort& effort) const {
    Fit fit;
    fit.pose = start;
    for (int i = 0; i < effort.iterations; ++i) {
      const double share = static_cast<double>(i) / (effort.iterations - 1);
      const double reach_m =
          options_.far_m * std::pow(options_.near_m / options_.far_m, std::min(1.0, 1.5 * share));
      CauchyEquations equations;
      add_points(fit, reach_m, effort.stride, equations);
      if (!add_outline(fit, equations)) return {};
      fit.information = kEvidence * equations.information;
      fit.cost = equations.cost + add_prior(fit.pose, equations);
      const Vector6d step = -equations.information.ldlt().solve(equations.gradient);
      if (!step.allFinite()) return {};
      fit.pose = perturbed(fit.pose, step);
      if (fit.pose.translation.z() < kMinDepth) return {};
      if (2 * i > effort.iterations && step.norm() < kConverged) break;
    }
    return fit;
  }

  // Of cloud and outline; infinite where the body is not in front of the camera.
  double surface_disagreement(const Pose& pose) const {
    Fit fit;
    fit.pose = pose;
    CauchyEquations equations;
    add_points(fit, options_.near_m, kFull.stride, equations);
    if (!add_outline(fit, equations)) return std::numeric_limits<double>::infinity();
    const double missing = (1 - fit.matched) * static_cast<double>(seen_.size());
    return equations.cost +
           kEvidence * missing * (cauchy_loss(options_.near_m / options_.point_sigma_m) - kUnmatched);
  }

  // Whether most of the points are where the body is: an outline alone fits a small body far away as well.
  bool holds_points(const Pose& pose) const {
    const Eigen::Vector3d center = pose * bounds_.center();
    const double reach_m = kReach * bounds_.diagonal().norm() / 2;
    const auto held = std::count_if(seen_.begin(), seen_.end(), [&](const SeenPoint& seen) {
      return (seen.position - center).norm() < reach_m;
    });
    return 2 * held >= std::ssize(seen_);
  }

  // Of how the points' colours differ from the model's there. Where it has none they may be any.
  double color_cost(const Pose& pose, std::size_t stride) const {
    if (!is_colored_) return 0;
    const Pose body_from_camera = pose.inverse();
    double cost = 0;
    for (std::size_t k = 0; k < seen_.size(); k += stride) {
      const SeenPoint& seen = seen_[k];
      const auto partner = partner_of(seen, body_from_camera, options_.near_m);
      const double off =
          partner ? (seen.color - model_.colors.col(*partner)).norm() / options_.color_sigma : 1;
      cost += cauchy_loss(off);
    }
    return kEvidence * cost;
  }

 private:
  // The model's point that is nearest and faces the same way.
  std::optional<int> partner_of(const SeenPoint& seen, const Pose& body_from_camera, double reach_m) const {
    pcl::Indices indices;
    std::vector<float> squared;
    const Eigen::Vector3d position = body_from_camera * seen.position,
                          normal = body_from_camera.rotation * seen.normal;
    if (bounds_.squaredExteriorDistance(position) > reach_m * reach_m) return std::nullopt;
    tree_.nearestKSearch(to_pcl(position), kPartners, indices, squared);
    for (std::size_t k = 0; k < indices.size() && squared[k] < reach_m * reach_m; ++k)
      if (model_.normals.col(indices[k]).dot(normal) >= options_.min_normal_cosine) return indices[k];
    return std::nullopt;
  }

  void add_points(Fit& fit, double reach_m, std::size_t stride, CauchyEquations& equations) const {
    const Pose body_from_camera = fit.pose.inverse();
    int used = 0, matched = 0;
    double sum = 0;
    for (std::size_t k = 0; k < seen_.size(); k += stride) {
      const SeenPoint& seen = seen_[k];
      ++used;
      const auto partner = partner_of(seen, body_from_camera, reach_m);
      if (!partner) continue;
      const Eigen::Vector3d p = body_from_camera * seen.position, n = model_.normals.col(*partner);
      const double distance = n.dot(p - model_.points.col(*partner));
      equations.add(point_row(p, n) / options_.point_sigma_m, distance / options_.point_sigma_m);
      sum += std::abs(distance);
      ++matched;
    }
    // what has no partner costs a little, else fewer would be better; not more, as it may be a new face
    equations.cost += kEvidence * kUnmatched * (used - matched);
    fit.matched = used ? matched / static_cast<double>(used) : 0;
    fit.distance_m = matched ? sum / matched : 0;
  }

  // A point of the body that is furthest along a tangent's normal, and how far it lies beyond the tangent.
  struct OutlineEnd {
    Eigen::Vector3d position;  // camera frame
    double beyond_px = 0;
  };

  OutlineEnd end_of(const SupportLine& line, const Eigen::Vector3d& p) const {
    return {p, line.normal.dot((camera_.matrix() * p).hnormalized()) - line.offset_px};
  }

  // By the shape where the points agree with it, which end some way inside. What lies further out was not
  // seen: the outline may well be its, but it does not pull at what is known.
  std::optional<OutlineEnd> end_along(const SupportLine& line, const Pose& camera_from_body,
                                      const OutlineEnd& seen) const {
    if (!model_.shape) return seen;
    const Pose camera_from_object = camera_from_body * *model_.body_from_object;
    const Eigen::Vector3d plane(line.normal.x(), line.normal.y(), -line.offset_px);
    const Eigen::Vector3d normal = (camera_.matrix().transpose() * plane).normalized();
    const OutlineEnd end =
        end_of(line, camera_from_object *
                         support_point(*model_.shape, camera_from_object.rotation.conjugate() * normal));
    if (end.position.z() < kMinDepth) return std::nullopt;
    const double radius_px = camera_.fx * std::cbrt(model_.shape->semi_axes_m.prod()) / end.position.z();
    if (std::abs(end.beyond_px - seen.beyond_px) < kAgreeing * radius_px) return end;
    if (seen.beyond_px >= 0 || end.beyond_px < seen.beyond_px) return seen;
    return end.beyond_px > 0 ? std::nullopt : std::optional(end);
  }

  // Whether all of the body is in front of the camera: else it has no outline.
  bool add_outline(Fit& fit, CauchyEquations& equations) const {
    const Eigen::Matrix3Xd in_camera =
        (fit.pose.rotation.toRotationMatrix() * model_.points).colwise() + fit.pose.translation;
    if (in_camera.row(2).minCoeff() < kMinDepth) return false;
    const Eigen::RowVectorXd u =
        camera_.fx * in_camera.row(0).cwiseQuotient(in_camera.row(2)).array() + camera_.cx;
    const Eigen::RowVectorXd v =
        camera_.fy * in_camera.row(1).cwiseQuotient(in_camera.row(2)).array() + camera_.cy;
    double sum = 0, beyond = 0;
    for (const SupportLine& line : lines_) {
      Eigen::Index at = 0;
      (line.normal.x() * u + line.normal.y() * v).maxCoeff(&at);
      const auto end = end_along(line, fit.pose, end_of(line, in_camera.col(at)));
      if (!end) continue;
      equations.add(line_row(camera_, line, fit.pose, end->position) / options_.outline_sigma_px,
                    end->beyond_px / options_.outline_sigma_px);
      sum += std::abs(end->beyond_px);
      beyond += std::max(0.0, end->beyond_px);
    }
    const auto count = static_cast<double>(std::max<std::ptrdiff_t>(1, lines()));
    fit.outline_px = sum / count;
    fit.beyond_px = beyond / count;
    return true;
  }

  double add_prior(const Pose& pose, CauchyEquations& equations) const {
    const Eigen::Matrix3d R = pose.rotation.toRotationMatrix();
    const Eigen::Vector3d turn = log_so3(predicted_.rotation.conjugate() * pose.rotation);
    const Eigen::Vector3d shift = R.transpose() * (pose.translation - predicted_.translation);
    const double t = 1 / (sigmas_.translation_m * sigmas_.translation_m),
                 r = 1 / (sigmas_.rotation_rad * sigmas_.rotation_rad);
    equations.information.diagonal().head<3>().array() += t;
    equations.information.diagonal().tail<3>().array() += r;
    equations.gradient.head<3>() += t * shift;
    equations.gradient.tail<3>() += r * turn;
    return way_cost(predicted_, pose, sigmas_);
  }

  const Camera& camera_;
  const SurfaceModel& model_;
  Pose predicted_;
  PoseSigmas sigmas_;
  const CloudAlignmentOptions& options_;
  std::vector<SeenPoint> seen_;
  std::vector<SupportLine> lines_;
  bool is_colored_;
  Eigen::AlignedBox3d bounds_;
  Tree tree_;
};

Fit held_fit(const Aligner& aligner, const Pose& start, const Effort& effort) {
  const Fit fit = aligner.fit_from(start, effort);
  return std::isfinite(fit.cost) && aligner.holds_points(fit.pose) ? fit : Fit{};
}

bool is_same_place(const Pose& a, const Pose& b) {
  return a.rotation.angularDistance(b.rotation) < kSameTurn &&
         (a.translation - b.translation).norm() < kSamePlace;
}

// Of many starts: full fits from where the best of the rough ones ended, with what colours say.
std::vector<Fit> fits_from(const Aligner& aligner, const std::vector<Pose>& starts) {
  if (starts.size() == 1) return {held_fit(aligner, starts.front(), kFull)};
  const auto colored_fit = [&](const Pose& start, const Effort& effort) {
    Fit fit = held_fit(aligner, start, effort);
    if (std::isfinite(fit.cost)) fit.cost += aligner.color_cost(fit.pose, effort.stride);
    return fit;
  };
  std::vector<Fit> rough, fits;
  for (const Pose& start : starts) rough.push_back(colored_fit(start, kRough));
  std::ranges::stable_sort(rough, {}, &Fit::cost);
  std::vector<Pose> ends;
  for (const Fit& fit : rough) {
    if (ends.size() == kRefined || !std::isfinite(fit.cost)) break;
    const auto is_here = [&](const Pose& end) { return is_same_place(end, fit.pose); };
    if (std::ranges::any_of(ends, is_here)) continue;
    ends.push_back(fit.pose);
    fits.push_back(colored_fit(fit.pose, kFull));
  }
  return fits;
}

std::vector<Pose> other_sides(const Pose& camera_from_body, const Pose& body_from_object) {
  std::vector<Pose> sides;
  for (const Eigen::Matrix3d& turn : box_rotations())
    sides.push_back(camera_from_body * body_from_object *
                    Pose{Eigen::Quaterniond(turn), Eigen::Vector3d::Zero()} * body_from_object.inverse());
  return sides;
}

}  // namespace

std::optional<CloudAlignment> align_to_cloud(const Camera& camera, const BodyObservation& body,
                                             const SurfaceModel& model, const Pose& predicted,
                                             const PoseSigmas& sigmas, bool stale,
                                             const CloudAlignmentOptions& options) {
  if (!body.silhouette || model.points.cols() < kLeastModel) return std::nullopt;
  if (predicted.translation.z() < kMinDepth) return std::nullopt;
  std::vector<Pose> starts = {predicted};
  for (int axis = 0; stale && axis < 3; ++axis)
    for (int turn = -options.turns; turn <= options.turns; ++turn) {
      if (turn == 0) continue;
      starts.push_back(predicted);
      starts.back().rotation =
          predicted.rotation * exp_so3(turn * options.turn_rad * Eigen::Vector3d::Unit(axis));
    }
  const Aligner aligner(camera, body, model, predicted, sigmas, options);
  Fit best;
  for (const Fit& fit : fits_from(aligner, starts))
    if (fit.cost < best.cost) best = fit;
  if (stale && model.body_from_object && std::isfinite(best.cost))
    for (const Fit& fit : fits_from(aligner, other_sides(best.pose, *model.body_from_object)))
      if (fit.matched >= best.matched + kOtherSide && fit.cost < best.cost) best = fit;
  if (!std::isfinite(best.cost)) return std::nullopt;
  // A face that was never seen matches nothing: the outline is enough to go on.
  const bool known = best.matched > options.min_matched;
  const double most_px =
      std::max(options.max_outline_px, options.max_outline_share * 2 * body.silhouette->rot_bbox.semi_minor);
  // What is known of a body may well end inside its outline, if its points lie where they were.
  const double off_px = known ? best.beyond_px : best.outline_px;
  if (best.distance_m > options.max_distance_m || off_px > most_px ||
      (!known && aligner.lines() < options.min_lines))
    return std::nullopt;
  return CloudAlignment{
      best.pose, best.information, best.matched, best.distance_m, aligner.distance_at(predicted), !known};
}

std::vector<Disagreement> disagreements(const Camera& camera, const BodyObservation& body,
                                        const SurfaceModel& model,
                                        const std::vector<LandmarkSighting>& sightings,
                                        const PoseSolverOptions& solver, const std::vector<Pose>& expected,
                                        const PoseSigmas& sigmas, const std::vector<Pose>& poses,
                                        const CloudAlignmentOptions& options) {
  std::optional<Aligner> aligner;
  if (model.points.cols() >= kLeastModel)
    aligner.emplace(camera, body, model, expected.front(), sigmas, options);
  const double most = solver.gate_sigmas * solver.gate_sigmas;
  std::vector<Disagreement> result;
  for (const Pose& pose : poses) {
    Disagreement d;
    if (aligner) d.surface = aligner->surface_disagreement(pose);
    d.way = std::numeric_limits<double>::infinity();
    for (const Pose& from : expected) d.way = std::min(d.way, way_cost(from, pose, sigmas));
    for (const LandmarkSighting& sighting : sightings) {
      if (sighting.rim) continue;
      const LinearisedSighting l = linearise(camera, sighting, pose, solver.pixel_sigma_px);
      d.sightings += 0.5 * (l.valid ? std::min(most, l.residual.squaredNorm()) : most);
    }
    result.push_back(d);
  }
  return result;
}

Matrix6d surface_information(const Camera& camera, const BodyObservation& body, const Pose& camera_from_body,
                             const Pose& body_from_object, const Superellipsoid& shape,
                             const CloudAlignmentOptions& options) {
  Matrix6d sum = Matrix6d::Zero();
  const auto seen = evenly_drawn(body, options.max_points);
  if (seen.empty()) return sum;
  const auto add = [&](const Vector6d& row) { sum += kEvidence * row * row.transpose(); };
  const Pose body_from_camera = camera_from_body.inverse(), object_from_body = body_from_object.inverse();
  for (const SeenPoint& point : seen) {
    const Eigen::Vector3d p = body_from_camera * point.position;
    const Eigen::Vector3d n = body_from_object.rotation * normal_at(shape, object_from_body * p);
    add(point_row(p, n) / options.point_sigma_m);
  }
  for (const SupportLine& line : body.silhouette ? body.silhouette->support : std::vector<SupportLine>{}) {
    if (!line.free) continue;
    const auto reach_px = [&](const SeenPoint& point) {
      return line.normal.dot((camera.matrix() * point.position).hnormalized());
    };
    const auto furthest =
        std::max_element(seen.begin(), seen.end(),
                         [&](const SeenPoint& a, const SeenPoint& b) { return reach_px(a) < reach_px(b); });
    add(line_row(camera, line, camera_from_body, furthest->position) / options.outline_sigma_px);
  }
  return sum;
}

}  // namespace uniquadric
