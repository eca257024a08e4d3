#include "box_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace uniquadric {
namespace fs = std::filesystem;

Eigen::Matrix3Xd box_cloud(const OrientedBox& box, const BoxCloudOptions& options, RandomStream& random) {
  std::vector<Eigen::Vector3d> points;
  const Eigen::Vector3d& a = box.half_extents_m;
  for (int k = 0; k < 3; ++k)
    for (const int side : {-1, 1}) {
      if (options.visible_only && side < 0) continue;
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      const auto count = std::lround(4 * a[i] * a[j] / (options.spacing_m * options.spacing_m));
      for (long n = 0; n < count; ++n) {
        Eigen::Vector3d q;
        q[k] = side * a[k] + (options.noise_m > 0 ? options.noise_m * random.normal() : 0);
        q[i] = random.uniform(-a[i], a[i]);
        q[j] = random.uniform(-a[j], a[j]);
        points.emplace_back(box.center + box.axes * q);
      }
    }
  const auto outliers = std::lround(options.outliers * static_cast<double>(points.size()));
  for (long n = 0; n < outliers; ++n)
    points.emplace_back(box.center + Eigen::Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5),
                                                     random.uniform(-0.5, 0.5)));
  Eigen::Matrix3Xd cloud(3, std::ssize(points));
  for (Eigen::Index n = 0; n < cloud.cols(); ++n) cloud.col(n) = points[n];
  return cloud;
}

OrientedBox generic_box(const Eigen::Vector3d& half_extents_m) {
  return {{0.3, -0.2, 1.7}, exp_so3({0.4, -0.3, 0.25}).toRotationMatrix(), half_extents_m};
}

namespace {

// z of the nearest hit along a ray from `eye` (slab method); nothing where it misses.
std::optional<double> hit_box(const OrientedBox& box, const Eigen::Vector3d& eye,
                              const Eigen::Vector3d& ray) {
  const Eigen::Vector3d o = box.axes.transpose() * (eye - box.center), d = box.axes.transpose() * ray;
  double enter = 0, leave = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double t1 = (-box.half_extents_m[k] - o[k]) / d[k], t2 = (box.half_extents_m[k] - o[k]) / d[k];
    enter = std::max(enter, std::min(t1, t2));
    leave = std::min(leave, std::max(t1, t2));
  }
  return enter < leave ? std::optional(enter) : std::nullopt;
}

cv::Vec3b noisy(const cv::Vec3d& colour, RandomStream& random) {
  cv::Vec3b pixel;
  for (int c = 0; c < 3; ++c) pixel[c] = cv::saturate_cast<unsigned char>(colour[c] + 8 * random.normal());
  return pixel;
}

}  // namespace

BoxImage render_box(const Camera& camera, const Pose& world_from_camera, const OrientedBox& box,
                    RandomStream& random) {
  BoxImage image{cv::Mat(camera.height, camera.width, CV_8UC3),
                 cv::Mat::zeros(camera.height, camera.width, CV_16UC1),
                 cv::Mat::zeros(camera.height, camera.width, CV_16UC1)};
  const Eigen::Vector3d eye = world_from_camera.translation;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = world_from_camera.rotation * *camera.unproject({u, v});
      const auto z_box = hit_box(box, eye, ray);
      const double z_floor = ray.z() < 0 ? -eye.z() / ray.z() : std::numeric_limits<double>::infinity();
      const double z = z_box ? *z_box : z_floor;
      image.mask.at<std::uint16_t>(v, u) = z_box ? 1 : 0;
      image.rgb.at<cv::Vec3b>(v, u) =
          noisy(z_box ? cv::Vec3d(160, 70, 40) : cv::Vec3d(150, 150, 150), random);
      if (z < 10) image.depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(std::lround(5000 * z));
    }
  return image;
}

Pose look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  Eigen::Matrix3d R;
  R.col(2) = (target - eye).normalized();
  R.col(0) = R.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return {Eigen::Quaterniond(R), eye};
}

OrientedBox scene_box(int i) {
  const Eigen::Matrix3d yaw = exp_so3({0, 0, 0.25 + 0.02 * i}).toRotationMatrix();
  return {{0.03 * i, 0.01 * i, 0.12}, yaw, {0.2, 0.15, 0.12}};
}

Pose scene_camera(int i) {
  return look_at({1.1 - 0.02 * i, 1.0, 0.9}, {0.05, 0.05, 0.1});
}

Sequence write_box_sequence(const fs::path& folder, int frames, bool gaps) {
  fs::remove_all(folder);
  for (const char* name : {"rgb", "depth", "masks"}) fs::create_directories(folder / name);
  Sequence sequence;
  sequence.folder = folder;
  sequence.name = "box";
  sequence.camera = {320, 240, 260, 260, 159.5, 119.5, {}};
  sequence.rate_hz = 30;
  sequence.given_camera.emplace();
  for (int i = 0; i < frames; ++i) {
    RandomStream random(7, "box_scene", i);
    const BoxImage image = render_box(sequence.camera, scene_camera(i), scene_box(i), random);
    const std::string file = fmt::format("{:06}.png", i);
    SequenceFrame frame;
    frame.frame = i;
    frame.stamp_ns = 1'000'000'000 + 33'333'333LL * i;
    frame.rgb = fs::path("rgb") / file;
    write_png(folder / frame.rgb, image.rgb);
    if (!(gaps && i == 2)) write_png(folder / (frame.depth = fs::path("depth") / file), image.depth);
    if (!(gaps && i == 3)) write_png(folder / (frame.masks = fs::path("masks") / file), image.mask);
    frame.masks_arrival_ns = frame.stamp_ns;
    sequence.frames.push_back(frame);
    sequence.given_camera->push_back({frame.stamp_ns, scene_camera(i)});
  }
  write_sequence_index(folder, sequence);
  return sequence;
}

}  // namespace uniquadric
