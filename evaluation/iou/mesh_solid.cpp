#include "evaluation/iou/mesh_solid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>

#include "core/embree/embree.h"
#include "core/embree/rtcore_parts.h"

namespace uniquadric {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

struct MeshSolid::State {
  MeshKind kind = MeshKind::open;
  Eigen::AlignedBox3d box;
  std::optional<double> volume_m3;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // of the box, the origin of the scene
  std::vector<Eigen::Vector3f> directions;
  EmbreeDevice device = new_embree_device("");
  EmbreeScene scene = new_embree_scene(device.get());
};

namespace {

constexpr std::size_t kPacket = 8;    // rays that are traced at once
constexpr std::size_t kGrain = 1024;  // points of a task; ours: some 100 us
constexpr int kPairs = 16;            // of opposite directions; ours: 32 in all

// Of corners at the same place the first one alone; triangles that become lines are left out.
Triangles weld(const std::vector<Eigen::Vector3f>& corners, const Triangles& triangles) {
  std::map<std::array<float, 3>, std::uint32_t> first;
  std::vector<std::uint32_t> same;
  for (const Eigen::Vector3f& c : corners)
    same.push_back(first.emplace(std::array{c.x(), c.y(), c.z()}, static_cast<std::uint32_t>(same.size()))
                       .first->second);
  Triangles welded;
  for (const auto& [a, b, c] : triangles)
    if (same[a] != same[b] && same[b] != same[c] && same[c] != same[a])
      welded.push_back({same[a], same[b], same[c]});
  return welded;
}

MeshKind kind_of(const Triangles& triangles) {
  std::vector<std::tuple<std::uint32_t, std::uint32_t, int>> edges;  // ends in order, and which way
  for (const auto& triangle : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = triangle[i], to = triangle[(i + 1) % 3];
      edges.emplace_back(std::min(from, to), std::max(from, to), from < to ? 1 : -1);
    }
  std::ranges::sort(edges);
  bool balanced = !edges.empty(), even = balanced;
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    const auto& [a, b, way] = edges[begin];
    int ways = 0;
    for (; end < edges.size() && std::get<0>(edges[end]) == a && std::get<1>(edges[end]) == b; ++end)
      ways += std::get<2>(edges[end]);
    balanced = balanced && ways == 0;
    even = even && (end - begin) % 2 == 0;
  }
  if (balanced) return MeshKind::closed;
  return even ? MeshKind::closed_unoriented : MeshKind::open;
}

constexpr std::size_t kMostParts = 1000;  // each is held against all others

// Triangles that hang together by corners, a part each.
std::vector<Triangles> parts_of(const Triangles& triangles, std::size_t corners) {
  std::vector<std::uint32_t> parent(corners);
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& [a, b, c] : triangles) parent[root(b)] = root(a), parent[root(c)] = root(a);
  std::map<std::uint32_t, Triangles> parts;
  for (const auto& triangle : triangles) parts[root(triangle[0])].push_back(triangle);
  std::vector<Triangles> result;
  for (auto& [corner, part] : parts) result.push_back(std::move(part));
  return result;
}

// Of parts that lie apart, whichever way each faces; nothing where their boxes meet: one may be a hole in the
// other, or overlap it.
std::optional<double> volume_of(const std::vector<Eigen::Vector3f>& corners, const Triangles& triangles) {
  const std::vector<Triangles> parts = parts_of(triangles, corners.size());
  if (parts.size() > kMostParts) return std::nullopt;
  double volume = 0;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Triangles& part : parts) {
    Eigen::AlignedBox3d box;
    for (const auto& triangle : part)
      for (const std::uint32_t corner : triangle) box.extend(corners[corner].cast<double>());
    if (std::ranges::any_of(boxes, [&](const auto& other) { return box.intersects(other); }))
      return std::nullopt;
    boxes.push_back(box);
    double six_fold = 0;
    for (const auto& [a, b, c] : part) {
      const auto at = [&](std::uint32_t i) -> Eigen::Vector3d {
        return corners[i].cast<double>() - box.center();
      };
      six_fold += at(a).dot(at(b).cross(at(c)));
    }
    volume += std::abs(six_fold) / 6;
  }
  return volume;
}

// Along no plane or diagonal that bodies are made of.
Eigen::Vector3f generic_direction() {
  return Eigen::Vector3f(0.5377F, 0.2113F, 0.8163F).normalized();
}

// Spread evenly over the sphere by the golden angle, in opposite pairs.
std::vector<Eigen::Vector3f> spread_directions() {
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), generic_direction().cast<double>());
  std::vector<Eigen::Vector3f> directions;
  for (int i = 0; i < kPairs; ++i) {
    const double z = (i + 0.5) / kPairs, ring = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Eigen::Vector3d direction =
        turn * Eigen::Vector3d(ring * std::cos(angle), ring * std::sin(angle), z);
    directions.emplace_back(direction.cast<float>());
    directions.emplace_back(-direction.cast<float>());
  }
  return directions;
}

// Of the rays of a packet; what the filter gets of the query is its first member.
struct Crossings {
  RayContext context;
  std::array<int, kPacket> outwards, all;
};

// Counts each triangle that is hit and rejects it, so that the ray goes on.
void count_crossing(const RTCFilterFunctionNArguments* arguments) {
  Crossings& crossings = *reinterpret_cast<Crossings*>(arguments->context);
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    const float along = RTCHitN_Ng_x(arguments->hit, n, i) * RTCRayN_dir_x(arguments->ray, n, i) +
                        RTCHitN_Ng_y(arguments->hit, n, i) * RTCRayN_dir_y(arguments->ray, n, i) +
                        RTCHitN_Ng_z(arguments->hit, n, i) * RTCRayN_dir_z(arguments->ray, n, i);
    const unsigned ray = RTCRayN_id(arguments->ray, n, i);
    crossings.outwards[ray] += along > 0 ? 1 : -1;
    ++crossings.all[ray];
    arguments->valid[i] = 0;
  }
}

void trace(RTCScene scene, std::span<const Eigen::Vector3f> points, const Eigen::Vector3f& direction,
           Crossings& crossings) {
  alignas(32) std::array<int, kPacket> valid{};
  alignas(32) RTCRay8 rays{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    valid[i] = -1;
    rays.org_x[i] = points[i].x(), rays.org_y[i] = points[i].y(), rays.org_z[i] = points[i].z();
    rays.dir_x[i] = direction.x(), rays.dir_y[i] = direction.y(), rays.dir_z[i] = direction.z();
    rays.tfar[i] = std::numeric_limits<float>::infinity();
    rays.mask[i] = ~0U;
    rays.id[i] = static_cast<unsigned>(i);
  }
  filter_hits(scene, valid.data(), rays, crossings.context);
}

bool is_inside(MeshKind kind, int outwards, int all, std::size_t directions) {
  if (kind == MeshKind::closed) return outwards != 0;
  if (kind == MeshKind::closed_unoriented) return all % 2 != 0;
  return 2 * static_cast<std::size_t>(std::abs(outwards)) > directions;
}

}  // namespace

const char* to_string(MeshKind kind) {
  switch (kind) {
    case MeshKind::closed:
      return "closed";
    case MeshKind::closed_unoriented:
      return "closed_unoriented";
    case MeshKind::open:
      return "open";
  }
  return "";
}

MeshSolid::MeshSolid(const std::vector<Eigen::Vector3f>& corners, const Triangles& triangles) {
  auto state = std::make_shared<State>();
  const Triangles welded = weld(corners, triangles);
  state->kind = kind_of(welded);
  state->directions = state->kind == MeshKind::open ? spread_directions() : std::vector{generic_direction()};
  for (const auto& triangle : welded)
    for (const std::uint32_t corner : triangle) state->box.extend(corners[corner].cast<double>());
  if (state->kind == MeshKind::closed) state->volume_m3 = volume_of(corners, welded);
  if (!state->box.isEmpty()) state->middle = state->box.center();
  std::vector<Eigen::Vector3f> about_middle;
  for (const Eigen::Vector3f& c : corners)
    about_middle.emplace_back((c.cast<double>() - state->middle).cast<float>());
  RTCScene scene = state->scene.get();
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);  // no ray slips through between two triangles
  attach_triangles(state->device.get(), scene, about_middle, welded);
  if (!welded.empty()) {
    RTCGeometry mesh = rtcGetGeometry(scene, 0);
    rtcSetGeometryOccludedFilterFunction(mesh, count_crossing);
    rtcCommitGeometry(mesh);
  }
  commit_embree_scene(state->device.get(), state->scene);
  state_ = std::move(state);
}

MeshKind MeshSolid::kind() const {
  return state_->kind;
}

const Eigen::AlignedBox3d& MeshSolid::box() const {
  return state_->box;
}

std::optional<double> MeshSolid::known_volume() const {
  return state_->volume_m3;
}

std::vector<char> MeshSolid::contains(std::span<const Eigen::Vector3d> points) const {
  std::vector<char> inside(points.size());
  const auto judge_packet = [&](std::size_t begin, std::size_t end) {
    std::array<Eigen::Vector3f, kPacket> about_middle;
    for (std::size_t i = begin; i < end; ++i)
      about_middle[i - begin] = (points[i] - state_->middle).cast<float>();
    Crossings crossings{};
    for (const Eigen::Vector3f& direction : state_->directions)
      trace(state_->scene.get(), std::span(about_middle).first(end - begin), direction, crossings);
    for (std::size_t i = begin; i < end; ++i)
      inside[i] = is_inside(state_->kind, crossings.outwards[i - begin], crossings.all[i - begin],
                            state_->directions.size());
  };
  const std::size_t packets = (points.size() + kPacket - 1) / kPacket;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, packets, kGrain / kPacket), [&](const auto& range) {
    for (std::size_t packet = range.begin(); packet < range.end(); ++packet)
      judge_packet(packet * kPacket, std::min(points.size(), (packet + 1) * kPacket));
  });
  return inside;
}

}  // namespace uniquadric
