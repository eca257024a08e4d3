#include "tests/lidar/lidar_support.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "core/base/files.h"
#include "simulator/scene/mesh_building.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {

std::vector<Beam> beams_of(const ScanPattern& pattern, std::int64_t from, std::int64_t count) {
  std::vector<Beam> beams;
  BeamBlock block;
  for (std::int64_t done = 0; done < count; done += block.count) {
    pattern.fill(from + done, static_cast<int>(std::min<std::int64_t>(BeamBlock::kCapacity, count - done)),
                 block);
    for (int i = 0; i < block.count; ++i)
      beams.push_back({block.time_ns[i],
                       {block.x[i], block.y[i], block.z[i]},
                       {block.origin_x[i], block.origin_y[i], block.origin_z[i]},
                       block.ring[i]});
  }
  return beams;
}

Beam beam_at(const ScanPattern& pattern, std::int64_t time_ns) {
  const Beam beam = beams_of(pattern, pattern.first_at(time_ns), 1).front();
  if (beam.time_ns != time_ns) throw std::logic_error("no beam is fired at that time");
  return beam;
}

ScanPattern square_pattern(int n, double width_deg, double length_s) {
  const TempFolder folder;
  std::string text = "Time/s,Azimuth/deg,Zenith/deg\n";
  for (int i = 0; i < n * n; ++i)
    text += fmt::format("{:.9f},{:.9f},{:.9f}\n", length_s * i / (n * n),
                        width_deg * ((i % n + 0.5) / n - 0.5), 90 + width_deg * ((i / n + 0.5) / n - 0.5));
  write_text(folder.path() / "square.csv", text);
  return csv_pattern(folder.path() / "square.csv");
}

Body body(int id, Mesh mesh, Motion motion, float color) {
  mesh.color = Eigen::Vector3f::Constant(color);
  Body result;
  result.id = id;
  result.name = fmt::format("body{}", id);
  result.meshes = {std::move(mesh)};
  result.motion = std::move(motion);
  return result;
}

Mesh square(double side_m) {
  Mesh mesh;
  const double a = side_m / 2;
  add_quad(mesh, {0, a, -a}, {0, -a, -a}, {0, -a, a}, {0, a, a});
  return mesh;
}

Mesh sphere(double radius_m, int segments) {
  Mesh mesh;
  add_grid(mesh, segments / 2, segments, [&](int row, int column) {
    const double polar = 180 * kDegree * row / (segments / 2), around = 360 * kDegree * column / segments;
    const Eigen::Vector3d out(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                              std::cos(polar));
    return Vertex{radius_m * out, out, Eigen::Vector2d::Zero()};
  });
  return mesh;
}

LidarRig exact_rig(ScanPattern pattern) {
  LidarRig rig;
  rig.pattern_name = "test";
  rig.pattern = std::move(pattern);
  rig.noise = LidarNoise::none();
  return rig;
}

Pose path_at(const Motion& motion, std::int64_t time_ns) {
  return motion.at(static_cast<double>(time_ns) * 1e-9);
}

std::string bytes_of(const LidarScan& scan) {
  std::string bytes = fmt::format("{} {} ", scan.start_ns, scan.beams);
  const auto add = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const LidarPoint& p = scan.points[i];
    const LidarPointTruth& t = scan.truth[i];
    for (const float value : {p.x, p.y, p.z, p.intensity, t.range_m, t.incidence_cos}) add(value);
    add(p.offset_ns);
    add(p.ring);
    add(p.tag);
    add(t.instance);
    add(t.kind);
  }
  return bytes;
}

}  // namespace uniquadric
