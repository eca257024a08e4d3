#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "estimator/base/stopwatch.h"
#include "estimator/objects/surface_cloud.h"
#include "estimator/observation/perception.h"
#include "estimator/shape/axis_fusion.h"
#include "estimator/shape/obb_ransac.h"
#include "estimator/shape/reach.h"
#include "estimator/window/long_window.h"
#include "estimator/window/short_window.h"

namespace uniquadric {

/// Stage of timing.csv: one solution of the long window of one body.
inline constexpr const char* kLongWindowStage = "long_window";

struct ShapeOptions {
  ObbOptions obb;
  LongWindowOptions long_window;
  SurfaceCloudOptions surface;
  AxisFusionOptions fusion;
  // ours: of each semi-axis about the sphere's radius, relative: a face seen head-on says nothing of the
  // depth behind it; a centimetre of evidence outweighs it
  double sphere_sigma = 0.5;
  bool plain_shapes = true;  // ours: a box, cylinder or ellipsoid where other exponents fit hardly better
  int search_keyframes =
      12;  // ours: for so many, and each so manyth, other starts are tried: Alg. 1's axes, turned ones
};

/// The shape of one body: Alg. 1 on each keyframe's points, their fusion (Alg. 2) as a prior, and the long
/// window's solution.
class ShapeEstimator {
 public:
  ShapeEstimator(int id, const Camera& camera, const ShapeOptions& options, std::uint64_t seed);

  /// The sphere of the first outline and depth (Eq. 10): its centre in the world; nothing without depth.
  std::optional<Eigen::Vector3d> start(const PerceivedFrame& frame, const BodyObservation& body);

  /// Takes a keyframe, of which this is the observation, and solves.
  void add_keyframe(const BodyKeyframe& keyframe, const BodyObservation& body);

  /// Takes over the poses that the short window has refined.
  void follow(const std::deque<BodyKeyframe>& window);

  /// Takes in silhouettes that are known by now, and solves if there are any.
  void receive(std::int64_t frame);

  /// Centre of the body in the world, from one outline and depth; nothing without depth.
  std::optional<Eigen::Vector3d> center_of(const PerceivedFrame& frame, const BodyObservation& body) const;

  /// Where the time of each of the long window's solutions is noted; null: nowhere.
  void note_times(std::vector<StageTime>* times) { times_ = times; }
  /// Takes up what another knew, but not where it noted its times.
  void go_back_to(const ShapeEstimator& before) {
    std::vector<StageTime>* times = times_;
    *this = before;
    times_ = times;
  }

  Shape shape() const;
  /// The same, or the box about a body that the shape has no form for (box_about).
  Shape box() const { return box_.value_or(shape()); }
  SurfaceModel surface() const;

 private:
  Pose usual_box() const;
  AxisBelief sphere_belief() const;
  std::vector<AxisBelief> axis_beliefs() const;
  std::optional<Shape> box_of(const BodyKeyframe& keyframe, const Eigen::Matrix3Xd& points);
  AxisFusionOptions fusion() const;
  /// What all starts of one solve share.
  struct Evidence {
    std::vector<PointView> views;
    Eigen::Matrix3Xd surface_points;
    std::vector<ContactSide> contacts;
  };
  ShapeSolution solve_from(const Shape& start, const Evidence& evidence, bool turns = true) const;
  void choose_plain(ShapeSolution& best, const Evidence& evidence);
  std::optional<Shape> solve_by_extents() const;
  void solve(bool searches, const std::optional<Shape>& box);

  int id_;
  Camera camera_;
  ShapeOptions options_;
  std::uint64_t seed_;
  Shape shape_;                          // z is the profile's axis
  std::optional<Shape> box_;             // where it is not the shape's, with names of its own
  double outline_px_ = 0;                // spread of outlines about the last shape
  std::optional<SuperExponents> plain_;  // of the box, cylinder or ellipsoid that it is taken for
  int turns_ = 0;                        // of the axes' names since the start
  double radius_m_ = 0;                  // of the first sphere
  int keyframes_ = 0;
  std::vector<ShapeView> views_, waiting_;
  std::deque<AxisEstimate> axes_;  // of single keyframes by Alg. 1
  std::deque<Pose> boxes_;         // body_from_box of the same
  std::vector<StageTime>* times_ = nullptr;
  SurfaceCloud surface_;
};

}  // namespace uniquadric
