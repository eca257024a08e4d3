#include "synthetic_perception.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/random.h"
#include "core/geometry/sphere_direction.h"

namespace uniquadric {
namespace {

constexpr double kGrazing = 0.2;  // cosine of the angle beyond which nothing is measured on a face
constexpr int kCloud = 600;       // points of a cloud

Eigen::Vector3d on_box(const Eigen::Vector3d& a, RandomStream& random, Eigen::Vector3d& normal) {
  const double areas[3] = {a.y() * a.z(), a.x() * a.z(), a.x() * a.y()};
  double pick = random.uniform() * (areas[0] + areas[1] + areas[2]);
  int axis = 0;
  while (axis < 2 && pick > areas[axis]) pick -= areas[axis++];
  Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  normal = Eigen::Vector3d::Zero();
  normal[axis] = p[axis] = random.uniform() < 0.5 ? -1 : 1;
  return p.cwiseProduct(a);
}

std::int64_t stamp_at(const SyntheticOptions& options, int frame) {
  return std::llround(1e9 * frame / options.rate_hz);
}

struct View {
  const Camera& camera;
  Pose camera_from_body;
  const SyntheticBody& body;

  bool sees(Eigen::Index i) const {
    const Eigen::Vector3d p = camera_from_body * body.points.col(i);
    const Eigen::Vector3d n = camera_from_body.rotation * body.normals.col(i);
    const auto pixel = camera.project(p);
    return pixel && camera.contains(*pixel) && -n.dot(p.normalized()) > kGrazing;
  }
  Eigen::Vector3d at(Eigen::Index i) const { return camera_from_body * body.points.col(i); }
};

Silhouette outline(const View& view, const SyntheticOptions& options, std::int64_t frame,
                   RandomStream& random) {
  Silhouette s;
  std::vector<Eigen::Vector2d> pixels;
  for (Eigen::Index i = 0; i < view.body.points.cols(); ++i)
    if (const auto pixel = view.camera.project(view.at(i))) pixels.push_back(*pixel);
  const auto support = [&](double angle) {
    SupportLine line;
    line.normal = {std::cos(angle), std::sin(angle)};
    line.offset_px = -std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& pixel : pixels)
      line.offset_px = std::max(line.offset_px, line.normal.dot(pixel));
    line.offset_px += options.outline_sigma_px * random.normal();
    return line;
  };
  for (int k = 0; k < options.directions; ++k)
    s.support.push_back(support(2 * std::numbers::pi * k / options.directions));
  for (int k = 0; k < 4; ++k) s.bbox[k] = support(std::numbers::pi / 2 * k);
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 90; ++k) {  // the rectangle of least area, to a degree
    const double angle = std::numbers::pi * k / 180;
    std::array<SupportLine, 4> sides;
    for (int j = 0; j < 4; ++j) sides[j] = support(angle + std::numbers::pi / 2 * j);
    const double a = (sides[0].offset_px + sides[2].offset_px) / 2,
                 b = (sides[1].offset_px + sides[3].offset_px) / 2;
    if (a * b >= least) continue;
    least = a * b;
    s.rot_bbox.center = (sides[0].offset_px - sides[2].offset_px) / 2 * sides[0].normal +
                        (sides[1].offset_px - sides[3].offset_px) / 2 * sides[1].normal;
    s.rot_bbox.semi_major = std::max(a, b);
    s.rot_bbox.semi_minor = std::min(a, b);
    s.rot_bbox.angle_rad = a >= b ? angle : angle + std::numbers::pi / 2;
  }
  s.side_free = {true, true, true, true};
  s.area_px = 4 * least;
  s.segmented = true;
  s.known_at_frame = frame;
  return s;
}

}  // namespace

SyntheticBody box_body(const Eigen::Vector3d& a, std::function<Pose(double)> motion) {
  SyntheticBody body{Eigen::Matrix3Xd(3, 2008), Eigen::Matrix3Xd(3, 2008), a, std::move(motion)};
  RandomStream random(7, "box_body");
  for (int i = 0; i < 2000; ++i) {
    Eigen::Vector3d normal;
    body.points.col(i) = on_box(a, random, normal);
    body.normals.col(i) = normal;
  }
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner((i & 1) ? 1 : -1, (i & 2) ? 1 : -1, (i & 4) ? 1 : -1);
    body.points.col(2000 + i) = corner.cwiseProduct(a);
    body.normals.col(2000 + i).setZero();  // of the outline alone
  }
  return body;
}

SyntheticBody cylinder_body(double r, double h, std::function<Pose(double)> motion) {
  SyntheticBody body{Eigen::Matrix3Xd(3, 4000), Eigen::Matrix3Xd(3, 4000), {r, r, h}, std::move(motion)};
  RandomStream random(7, "cylinder_body");
  for (int i = 0; i < 4000; ++i) {
    const double turn = random.uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Vector3d out(std::cos(turn), std::sin(turn), 0);
    const bool on_side = random.uniform() * (r + 2 * h) < 2 * h, up = random.uniform() < 0.5;
    const Eigen::Vector3d top = Eigen::Vector3d::UnitZ() * (up ? 1 : -1);
    const double z = on_side ? random.uniform(-1, 1) : 1;
    body.points.col(i) = (on_side ? r : r * std::sqrt(random.uniform())) * out + z * h * top;
    body.normals.col(i) = on_side ? out : top;
  }
  return body;
}

SyntheticBody ellipsoid_body(const Eigen::Vector3d& a, std::function<Pose(double)> motion) {
  SyntheticBody body{Eigen::Matrix3Xd(3, 4000), Eigen::Matrix3Xd(3, 4000), a, std::move(motion)};
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d u = sphere_direction(i, 4000);
    body.points.col(i) = u.cwiseProduct(a);
    body.normals.col(i) = u.cwiseQuotient(a).normalized();
  }
  return body;
}

SyntheticPerception synthetic_perception(const std::vector<SyntheticBody>& bodies,
                                         const SyntheticOptions& options) {
  SyntheticPerception perception;
  for (int f = 0; f < options.frames; ++f) {
    const double t = f / options.rate_hz;
    PerceivedFrame frame{{f, stamp_at(options, f), options.world_from_camera(t)}, {}};
    for (int b = 0; b < std::ssize(bodies); ++b) {
      if (options.hidden && options.hidden(b, t)) continue;
      RandomStream random(options.seed, "synthetic", f, b);
      const View view{perception.camera, frame.world_from_camera->inverse() * bodies[b].world_from_body(t),
                      bodies[b]};
      BodyObservation body;
      body.id = b + 1;
      body.silhouette = outline(view, options, f, random);
      bool was_hidden = false;
      for (int k = 0; k < f && !options.found_again; ++k)
        was_hidden |= options.hidden && options.hidden(b, k / options.rate_hz);
      const Eigen::Index step = std::max<Eigen::Index>(1, view.body.points.cols() / (3 * options.features));
      for (Eigen::Index i = 0; i < view.body.points.cols(); i += step) {
        if (!view.sees(i)) continue;
        const Eigen::Vector3d p = view.at(i);
        Feature feature;
        feature.track = 100000 * b + i + (was_hidden ? 50000 : 0);
        feature.pixel = *perception.camera.project(p) +
                        options.pixel_sigma_px * Eigen::Vector2d(random.normal(), random.normal());
        feature.depth_m = p.z() + options.depth_sigma_m * random.normal();
        feature.depth_sigma_m = options.depth_sigma_m;
        body.features.push_back(feature);
      }
      std::vector<Eigen::Vector3d> cloud, normals;
      for (int k = 0; k < kCloud; ++k) {
        const Eigen::Index i = random.below(static_cast<std::uint32_t>(view.body.points.cols()));
        if (!view.sees(i)) continue;
        const Eigen::Vector3d p = view.at(i);
        cloud.push_back(p + options.point_sigma_m * random.normal() * p / p.z());
        const Eigen::Vector3d noise(random.normal(), random.normal(), random.normal());
        const Eigen::Vector3d normal = view.camera_from_body.rotation * view.body.normals.col(i);
        normals.push_back((normal + options.normal_sigma * noise).normalized());
      }
      body.points.resize(3, std::ssize(cloud));
      body.normals.resize(3, std::ssize(cloud));
      for (int k = 0; k < std::ssize(cloud); ++k) {
        body.points.col(k) = cloud[k];
        body.normals.col(k) = normals[k];
      }
      frame.bodies.push_back(std::move(body));
    }
    perception.frames.push_back(std::move(frame));
  }
  return perception;
}

Tracks synthetic_truth(const std::vector<SyntheticBody>& bodies, const SyntheticOptions& options) {
  Tracks tracks;
  for (int b = 0; b < std::ssize(bodies); ++b) tracks.objects.push_back({b + 1, "", {}});
  for (int f = 0; f < options.frames; ++f) {
    const double t = f / options.rate_hz;
    tracks.camera.push_back({stamp_at(options, f), options.world_from_camera(t)});
    for (int b = 0; b < std::ssize(bodies); ++b) {
      ObjectState state;
      state.frame = f;
      state.stamp_ns = stamp_at(options, f);
      state.ellipsoid = {bodies[b].world_from_body(t), bodies[b].semi_axes_m};
      tracks.objects[b].states.push_back(state);
    }
  }
  return tracks;
}

}  // namespace uniquadric
