#include "estimator/objects/shape_estimator.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/quantile.h"
#include "core/geometry/box_symmetry.h"
#include "estimator/objects/beside_outlines.h"
#include "estimator/objects/closer_sides.h"
#include "estimator/objects/seen_extents.h"
#include "estimator/objects/shape_by_extents.h"
#include "estimator/window/contact_sides.h"

namespace uniquadric {
namespace {

constexpr double kSphereDepth = 0.6;    // centre of a sphere behind the median of its visible depth, in radii
constexpr int kMostAxes = 100;          // single-frame estimates that are fused: bounds memory and time
constexpr double kThinnest = 0.5;       // semi-axis that a box starts with at least, in radii of the sphere
constexpr double kClearlyBetter = 0.8;  // share of the cost below which another start is taken
constexpr PoseSigmas kBoxSigmas{0.01, 0.02};  // of the box that most of Alg. 1's agree with
constexpr int kEnoughSegmented = 3;           // views, without which carried outlines count
constexpr double kLargestLook = 2;  // of its largest semi-axis: across a box's diagonal, and what is unseen
constexpr double kEdge = 1.005;     // exponent of a sharp edge, which still has a normal
constexpr SuperExponents kPlain[] = {{kEdge, kEdge, kEdge}, {2, kEdge, kEdge}, {2, 2, 2}};
constexpr double kPlainGain = 20;  // cost by which free exponents have to fit better: views share their noise
constexpr double kClearGain = 10;  // and what it must be lower by besides: as 20 of chi-square, no chance

double median_depth(const Eigen::Matrix3Xd& points) {
  return upper_median(std::vector<double>(points.row(2).begin(), points.row(2).end()));
}

bool fuses(AxisPrior prior) {
  return prior != AxisPrior::none;
}

AxisFusion fusion_rule(AxisPrior prior) {
  switch (prior) {
    case AxisPrior::mean:
      return AxisFusion::mean;
    case AxisPrior::inverse_variance:
      return AxisFusion::inverse_variance;
    case AxisPrior::literal:
      return AxisFusion::literal;
    default:
      return AxisFusion::renyi;
  }
}

// The same shape, x named z, y x, z y, so many times.
Shape with_axes_turned(Shape shape, int times) {
  Eigen::Matrix3d next;  // its columns: the new axes in the old ones
  next << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  for (int i = 0; i < times; ++i) {
    shape.body_from_object.rotation *= Eigen::Quaterniond(next);
    shape.semi_axes_m = next.transpose() * shape.semi_axes_m;
    for (int block = 0; block < 9; block += 3)
      shape.variances.segment<3>(block) = next.transpose() * shape.variances.segment<3>(block).eval();
  }
  return shape;
}

void drop_carried(std::vector<ShapeView>& views) {
  const auto is_segmented = [](const ShapeView& view) { return view.silhouette.segmented; };
  if (std::count_if(views.begin(), views.end(), is_segmented) >= kEnoughSegmented)
    std::erase_if(views, [&](const ShapeView& view) { return !is_segmented(view); });
}

}  // namespace

ShapeEstimator::ShapeEstimator(int id, const Camera& camera, const ShapeOptions& options, std::uint64_t seed)
    : id_(id), camera_(camera), options_(options), seed_(seed), surface_(options.surface) {}

std::optional<Eigen::Vector3d> ShapeEstimator::start(const PerceivedFrame& frame,
                                                     const BodyObservation& body) {
  if (!body.silhouette || body.points.cols() == 0) return std::nullopt;
  const Ellipse& box = body.silhouette->rot_bbox;
  const double m_per_px = median_depth(body.points) / camera_.fx;
  radius_m_ = std::sqrt(box.semi_major * box.semi_minor) * m_per_px;
  shape_.semi_axes_m.setConstant(radius_m_);
  surface_.reset(radius_m_, box.semi_major * m_per_px);
  return center_of(frame, body);
}

std::optional<Eigen::Vector3d> ShapeEstimator::center_of(const PerceivedFrame& frame,
                                                         const BodyObservation& body) const {
  if (!body.silhouette || body.points.cols() == 0) return std::nullopt;
  const Ellipse& box = body.silhouette->rot_bbox;
  const double depth = median_depth(body.points) + kSphereDepth * std::cbrt(shape_.semi_axes_m.prod());
  // a body too thin for its mask shows what is behind it, from where it would not look as large
  if (keyframes_ > 0 && box.semi_major * depth / camera_.fx > kLargestLook * shape_.semi_axes_m.maxCoeff())
    return std::nullopt;
  const auto ray = camera_.unproject(box.center);
  if (!ray) return std::nullopt;
  return *frame.world_from_camera * (depth * *ray);
}

void ShapeEstimator::add_keyframe(const BodyKeyframe& keyframe, const BodyObservation& body) {
  ++keyframes_;
  const Pose body_from_camera = keyframe.world_from_body.inverse() * keyframe.world_from_camera;
  surface_.add(body, body_from_camera);
  Eigen::Matrix3Xd smooth = body.normals.cols() > 0 ? body.points : Eigen::Matrix3Xd(3, 0);
  for (const auto& silhouette : {body.silhouette, body.segmented}) {
    if (!silhouette) continue;
    ShapeView view{keyframe.frame,
                   keyframe.world_from_camera,
                   keyframe.world_from_body,
                   *silhouette,
                   smooth,
                   body.normals,
                   body.contact};
    (view.silhouette.known_at_frame <= keyframe.frame ? views_ : waiting_).push_back(std::move(view));
  }
  // at first often, then now and then: what told the axes apart may only have come into view
  const int few = options_.search_keyframes;
  const bool searches = keyframes_ <= few || (few > 0 && keyframes_ % few == 0);
  std::optional<Shape> box;
  if (fuses(options_.long_window.axis_prior) || searches) box = box_of(keyframe, body.points);
  if (keyframes_ == 1 && box) shape_ = *box;
  solve(searches, box);
}

void ShapeEstimator::receive(std::int64_t frame) {
  const auto known = [&](const ShapeView& view) { return view.silhouette.known_at_frame <= frame; };
  const auto first =
      std::stable_partition(waiting_.begin(), waiting_.end(), [&](const auto& v) { return !known(v); });
  if (first == waiting_.end()) return;
  for (auto late = first; late != waiting_.end(); ++late) {  // in the place of what was carried there
    std::erase_if(views_, [&](const ShapeView& view) { return view.frame == late->frame; });
    const auto next = std::find_if(views_.begin(), views_.end(),
                                   [&](const ShapeView& view) { return view.frame > late->frame; });
    views_.insert(next, std::move(*late));
  }
  waiting_.erase(first, waiting_.end());
  solve(false, std::nullopt);
}

void ShapeEstimator::follow(const std::deque<BodyKeyframe>& window) {
  for (std::vector<ShapeView>* views : {&views_, &waiting_})
    for (ShapeView& view : *views)
      for (const BodyKeyframe& keyframe : window)
        if (keyframe.frame == view.frame) view.world_from_body = keyframe.world_from_body;
}

// Alg. 1 on one keyframe, its axes named as the shape's.
std::optional<Shape> ShapeEstimator::box_of(const BodyKeyframe& keyframe, const Eigen::Matrix3Xd& points) {
  RandomStream random(seed_, "obb_ransac", keyframe.frame, id_);
  const Pose body_from_camera = keyframe.world_from_body.inverse() * keyframe.world_from_camera;
  const Eigen::Matrix3d axes_in_camera =
      (body_from_camera.inverse().rotation * shape_.body_from_object.rotation).toRotationMatrix();
  const auto obb = fit_obb_ransac(points, options_.obb, axes_in_camera, random);
  if (!obb) return std::nullopt;
  axes_.push_back({obb->box.half_extents_m, obb->semi_axes_std_m});
  const Ellipsoid box = inscribed_ellipsoid(obb->box);
  Shape shape = shape_;
  shape.body_from_object = body_from_camera * box.world_from_object;
  shape.body_from_object.rotation.normalize();
  boxes_.push_back(shape.body_from_object);
  if (std::ssize(axes_) > kMostAxes) {
    axes_.pop_front();
    boxes_.pop_front();
  }
  // what is not seen of a body is no thinner than this; the box's seen face stays where it is
  shape.semi_axes_m = box.semi_axes_m.cwiseMax(kThinnest * radius_m_);
  const Eigen::Vector3d view = shape.body_from_object.translation - body_from_camera.translation;
  const Eigen::Vector3d away = shape.body_from_object.rotation.conjugate() * view;
  const Eigen::Vector3d grown = (shape.semi_axes_m - box.semi_axes_m).cwiseProduct(away.cwiseSign());
  shape.body_from_object.translation += shape.body_from_object.rotation * grown;
  return shape;
}

// The one that the others are nearest to, as a mode is: partial views are off in ways of their own.
Pose ShapeEstimator::usual_box() const {
  const auto far = [&](const Pose& a, const Pose& b) {
    return (a.translation - b.translation).norm() + radius_m_ * a.rotation.angularDistance(b.rotation);
  };
  const auto sum = [&](const Pose& a) {
    return std::accumulate(boxes_.begin(), boxes_.end(), 0.0,
                           [&](double all, const Pose& b) { return all + std::min(far(a, b), radius_m_); });
  };
  return *std::min_element(boxes_.begin(), boxes_.end(),
                           [&](const Pose& a, const Pose& b) { return sum(a) < sum(b); });
}

AxisBelief ShapeEstimator::sphere_belief() const {
  const Eigen::Vector3d sphere = Eigen::Vector3d::Constant(radius_m_);
  return {sphere, options_.sphere_sigma * sphere};
}

// The sphere's weak one, and the one that the options ask for (Eq. 15).
std::vector<AxisBelief> ShapeEstimator::axis_beliefs() const {
  std::vector<AxisBelief> beliefs = {sphere_belief()};
  if (fuses(options_.long_window.axis_prior)) {
    const std::vector<AxisEstimate> axes(axes_.begin(), axes_.end());
    if (const auto fused = fuse_axes(axes, fusion()); fused && fused->semi_axes_m.minCoeff() > 0)
      beliefs.push_back({fused->semi_axes_m, fused->sigma_m});
  }
  return beliefs;
}

SurfaceModel ShapeEstimator::surface() const {
  SurfaceModel model = surface_.model();
  model.body_from_object = shape_.body_from_object;
  const bool is_young = keyframes_ <= options_.search_keyframes;
  if (!is_young) model.shape = shape_.superellipsoid();
  return model;
}

// Names stay when another axis becomes the profile's.
Shape ShapeEstimator::shape() const {
  Shape shape = with_axes_turned(shape_, (3 - turns_) % 3);
  shape.profile_axis = (2 + turns_) % 3;
  return shape;
}

AxisFusionOptions ShapeEstimator::fusion() const {
  AxisFusionOptions fusion = options_.fusion;
  fusion.rule = fusion_rule(options_.long_window.axis_prior);
  return fusion;
}

ShapeSolution ShapeEstimator::solve_from(const Shape& start, const Evidence& evidence, bool turns) const {
  LongWindowOptions options = options_.long_window;
  options.held_exponents = plain_;
  DepthEvidence depth;
  if (options.surface_points) depth.surface_points = evidence.surface_points;
  depth.contacts = evidence.contacts;
  Shape from = start;
  if (fuses(options.axis_prior) && !boxes_.empty()) {  // Alg. 1's boxes say where the quadric is, too
    from.body_from_object = usual_box();
    options.offset_sigmas = options.covariance_offset_sigmas = kBoxSigmas;
  }
  options.surface_sigma_m = surface_sigma_m(options, radius_m_);
  if (options.outline_noise == OutlineNoise::measured)
    options.outline_sigma_px = std::max(options.outline_sigma_px, outline_px_);
  if (!turns) options.offset_sigmas.rotation_rad = kHeldTurn;
  std::vector<StageTime> unasked;
  Stopwatch watch(views_.back().frame, times_ ? *times_ : unasked);
  ShapeSolution solution = solve_shape(camera_, views_, depth, axis_beliefs(), from, options);
  watch.stop(kLongWindowStage);
  return solution;
}

// Round edges and larger axes look much like sharp edges and smaller ones. Of what fits alike the simplest is
// the likeliest: most of what is made is a box or a cylinder.
void ShapeEstimator::choose_plain(ShapeSolution& best, const Evidence& evidence) {
  const Shape start = best.shape;
  double least = best.cost + kPlainGain;
  std::optional<SuperExponents> chosen;
  for (const SuperExponents& exponents : kPlain) {
    plain_ = exponents;
    ShapeSolution other = solve_from(start, evidence);
    if (other.cost >= least) continue;
    least = other.cost;
    chosen = plain_;
    best = std::move(other);
  }
  plain_ = chosen;
}

std::optional<Shape> ShapeEstimator::solve_by_extents() const {
  const LongWindowOptions& window = options_.long_window;
  if (!fuses(window.axis_prior) || window.axis_samples != AxisSamples::extents) return std::nullopt;
  std::vector<StageTime> unasked;
  Stopwatch watch(views_.back().frame, times_ ? *times_ : unasked);
  const auto found = shape_by_extents(
      {camera_, views_, boxes_, options_.sphere_sigma, kThinnest * radius_m_, fusion(), window}, shape_);
  watch.stop(kLongWindowStage);
  return found;
}

void ShapeEstimator::solve(bool searches, const std::optional<Shape>& box) {
  if (views_.empty()) return;
  const LongWindowOptions& window = options_.long_window;
  if (window.segmented_outlines) drop_carried(views_);
  thin_views(views_, window.keyframes);
  if (const auto found = solve_by_extents()) {
    shape_ = *found;
    return;
  }
  Evidence evidence{{}, surface_.sample(), {}};
  if (window.contacts) evidence.contacts = contact_sides(views_);
  if (window.segmented_outlines) drop_beside_outlines(camera_, views_, evidence.surface_points);
  drop_crossed(evidence.contacts, evidence.surface_points);
  for (const ShapeView& view : views_) evidence.views.push_back(point_view(camera_, view));
  if (searches && plain_) {
    plain_.reset();
    shape_.exponents = {};
  }
  ShapeSolution best = solve_from(shape_, evidence);
  const auto is_clearly_better = [](const ShapeSolution& other, const ShapeSolution& before) {
    return other.cost < kClearlyBetter * before.cost - kClearGain;
  };
  int turns = 0;
  // with a profile of its own along z, any of the three axes may be it
  for (int more = 1; searches && window.exponents == 3 && more < 3; ++more) {
    Shape start = with_axes_turned(shape_, more);
    start.exponents = {};
    ShapeSolution other = solve_from(start, evidence);
    if (!is_clearly_better(other, best)) continue;
    best = std::move(other);
    turns = more;
  }
  if (searches && box) {
    ShapeSolution other = solve_from(*box, evidence);
    const SideEvidence sides{evidence.views, evidence.surface_points, radius_m_, evidence.contacts};
    if (is_clearly_better(other, best) ||
        (!is_clearly_better(best, other) && has_closer_sides(other.shape, best.shape, sides))) {
      best = std::move(other);
      turns = 0;
    }
  } else if (keyframes_ > options_.search_keyframes) {
    // axes that the evidence hardly tells apart, as a ball's, would wander from solve to solve
    ShapeSolution held = solve_from(shape_, evidence, false);
    if (held.cost < best.cost + kTurnGain) best = std::move(held);
  }
  turns_ = (turns_ + turns) % 3;
  if (searches && options_.plain_shapes && window.exponents == 3) choose_plain(best, evidence);
  outline_px_ = best.outline_px;
  shape_ = window.extents ? with_seen_extents(best.shape, evidence.views, radius_m_, evidence.contacts)
                          : best.shape;
  const SideEvidence sides{evidence.views, evidence.surface_points, radius_m_, evidence.contacts};
  if (window.extents && window.box_by_points) box_ = box_about(shape(), box_, searches, sides);
}

}  // namespace uniquadric
