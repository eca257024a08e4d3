#include "simulator/render/short_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

namespace uniquadric {
namespace {

using Index = std::uint32_t;

// At z metres, seen from h metres beside it, the time of a row errs by h fy / 16 z rows at most: one of 480
// in most of an image, ten where a floor comes into it. A quarter took 8 % of all drawing.
constexpr float kShare = 0.5f;
constexpr float kShortest_m = 0.05f;  // ours: of nothing nearer than 10 cm

class Splitter {
 public:
  Splitter(Mesh& mesh, const std::vector<Eigen::Vector3f>& cameras_m) : mesh_(mesh), cameras_m_(cameras_m) {}

  // Whether an edge was too long. Neighbours agree on the edges they share, so that no gap opens.
  bool split_once() {
    middles_.clear();
    std::vector<std::array<Index, 3>> parts;
    parts.reserve(mesh_.triangles.size());
    for (const auto& triangle : mesh_.triangles) split(triangle, parts);
    std::swap(mesh_.triangles, parts);
    return !middles_.empty();
  }

 private:
  bool is_long(Index a, Index b) const {
    const Eigen::Vector3f &from = mesh_.positions[a], &to = mesh_.positions[b];
    const float length_m = (to - from).norm();
    if (length_m <= kShortest_m) return false;
    const Eigen::Vector3f middle = 0.5f * (from + to);
    float nearest_m2 = std::numeric_limits<float>::infinity();
    for (const Eigen::Vector3f& camera : cameras_m_)
      nearest_m2 = std::min(nearest_m2, (camera - middle).squaredNorm());
    return length_m > kShare * std::sqrt(nearest_m2);
  }

  Index middle_of(Index a, Index b) {
    const auto [place, is_new] =
        middles_.try_emplace(std::minmax(a, b), static_cast<Index>(mesh_.positions.size()));
    if (is_new) {
      mesh_.positions.emplace_back(0.5f * (mesh_.positions[a] + mesh_.positions[b]));
      mesh_.normals.emplace_back((mesh_.normals[a] + mesh_.normals[b]).normalized());
      mesh_.uvs.emplace_back(0.5f * (mesh_.uvs[a] + mesh_.uvs[b]));
    }
    return place->second;
  }

  // Turned so that the edge after the last long one comes last, two or three parts are cut off.
  void split(const std::array<Index, 3>& t, std::vector<std::array<Index, 3>>& parts) {
    const std::array<bool, 3> is_cut = {is_long(t[0], t[1]), is_long(t[1], t[2]), is_long(t[2], t[0])};
    const auto count = std::ranges::count(is_cut, true);
    const auto turned = [&](int k) { return std::array{t[k % 3], t[(k + 1) % 3], t[(k + 2) % 3]}; };
    if (count == 0) {
      parts.push_back(t);
    } else if (count == 3) {
      const Index ab = middle_of(t[0], t[1]), bc = middle_of(t[1], t[2]), ca = middle_of(t[2], t[0]);
      parts.insert(parts.end(), {{t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}, {ab, bc, ca}});
    } else if (count == 1) {
      const auto [a, b, c] = turned(static_cast<int>(std::ranges::find(is_cut, true) - is_cut.begin()));
      const Index ab = middle_of(a, b);
      parts.insert(parts.end(), {{a, ab, c}, {ab, b, c}});
    } else {
      const auto [a, b, c] = turned(static_cast<int>(std::ranges::find(is_cut, false) - is_cut.begin()));
      const Index bc = middle_of(b, c), ca = middle_of(c, a);
      parts.insert(parts.end(), {{c, ca, bc}, {a, b, bc}, {a, bc, ca}});
    }
  }

  Mesh& mesh_;
  const std::vector<Eigen::Vector3f>& cameras_m_;
  std::map<std::pair<Index, Index>, Index> middles_;
};

}  // namespace

Mesh with_short_edges(Mesh mesh, const std::vector<Eigen::Vector3f>& cameras_m) {
  Splitter splitter(mesh, cameras_m);
  while (splitter.split_once()) {
  }
  return mesh;
}

}  // namespace uniquadric
