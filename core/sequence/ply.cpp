#include "core/sequence/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/read_file.h"
#include "core/geometry/polygon.h"
#include "core/sequence/ply_file.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "values are written as they lie in memory");

template <typename T>
void put(std::string& data, T value) {
  data.append(reinterpret_cast<const char*>(&value), sizeof value);
}

constexpr std::pair<std::string_view, std::string_view> kTextureCoordinates[] = {
    {"u", "v"}, {"s", "t"}, {"tx", "ty"}, {"texture_u", "texture_v"}};

using Row = std::vector<std::vector<double>>;

template <std::size_t N>
using Columns = std::optional<std::array<std::size_t, N>>;

// Where an element has single values of these names: all, or nothing.
template <std::size_t N>
Columns<N> columns(const PlyElement& element, const std::array<std::string_view, N>& names) {
  std::array<std::size_t, N> found;
  for (std::size_t k = 0; k < N; ++k) {
    const auto property = std::ranges::find_if(
        element.properties, [&](const PlyProperty& p) { return p.name == names[k] && p.count.size == 0; });
    if (property == element.properties.end()) return std::nullopt;
    found[k] = static_cast<std::size_t>(property - element.properties.begin());
  }
  return found;
}

template <std::size_t N>
Eigen::Vector<float, N> values(const Row& row, const std::array<std::size_t, N>& columns) {
  Eigen::Vector<float, N> v;
  for (std::size_t k = 0; k < N; ++k) v[k] = static_cast<float>(row[columns[k]][0]);
  return v;
}

std::optional<std::size_t> list_column(const PlyElement& element,
                                       std::initializer_list<std::string_view> names) {
  for (std::size_t i = 0; i < element.properties.size(); ++i)
    if (element.properties[i].count.size > 0 && std::ranges::count(names, element.properties[i].name) > 0)
      return i;
  return std::nullopt;
}

class SurfaceReader {
 public:
  SurfaceReader(const fs::path& path, const std::string& bytes)
      : path_(path), header_(read_ply_header(path, bytes)), rows_(path, bytes, header_) {}

  SurfaceFile read() {
    surface_.texture_file = header_.texture_file;
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex")
        read_points(element);
      else if (element.name == "face")
        read_faces(element);
      else if (element.name == "material")
        read_materials(element);
      else
        for (std::uint64_t i = 0; i < element.count; ++i) rows_.next(element);
    }
    rows_.expect_end();
    if (surface_.points.empty()) throw InputError(path_, "has no points");
    return std::move(surface_);
  }

 private:
  void read_points(const PlyElement& element) {
    const auto position = columns<3>(element, {"x", "y", "z"}),
               normal = columns<3>(element, {"nx", "ny", "nz"});
    if (!position) throw InputError(path_, element.line, "vertex has no x, y, z");
    Columns<2> uv;
    for (const auto& [u, v] : kTextureCoordinates)
      if (!uv) uv = columns<2>(element, {u, v});
    for (std::uint64_t i = 0; i < element.count; ++i) {
      const Row& row = rows_.next(element);
      surface_.points.push_back(values(row, *position));
      const Eigen::Vector3f& point = surface_.points.back();
      if (!point.allFinite() || point.cwiseAbs().maxCoeff() > kMostPlyCoordinate_m)
        rows_.fail(fmt::format("is not finite, or lies beyond {} m", kMostPlyCoordinate_m));
      if (normal) surface_.normals.push_back(values(row, *normal));
      if (uv) point_uvs_.push_back(finite_uv(values(row, *uv)));
    }
  }
  void read_faces(const PlyElement& element) {
    const auto indices = list_column(element, {"vertex_indices", "vertex_index"}),
               texcoord = list_column(element, {"texcoord"});
    for (std::uint64_t i = 0; i < element.count; ++i) {
      const Row& row = rows_.next(element);
      if (indices) read_face(row[*indices], texcoord ? &row[*texcoord] : nullptr);
    }
  }
  void read_face(const std::vector<double>& corners, const std::vector<double>* texcoord) {
    if (corners.size() > kMostPlyCorners)
      rows_.fail(fmt::format("has {} corners, at most {} are read", corners.size(), kMostPlyCorners));
    std::vector<Eigen::Vector3f> points;
    for (const double corner : corners) {
      if (!(corner >= 0 && corner < static_cast<double>(surface_.points.size())) ||
          corner != std::floor(corner))
        rows_.fail(fmt::format("has corner {} of {} points", corner, surface_.points.size()));
      points.push_back(surface_.points[static_cast<std::size_t>(corner)]);
    }
    const bool own = texcoord && texcoord->size() == 2 * corners.size();
    for (const auto& [a, b, c] : triangulate(points)) {
      const auto index = [&](std::uint32_t k) { return static_cast<std::uint32_t>(corners[k]); };
      surface_.triangles.push_back({index(a), index(b), index(c)});
      const auto uv = [&](std::uint32_t k) -> Eigen::Vector2f {
        if (own) return finite_uv(Eigen::Vector2d((*texcoord)[2 * k], (*texcoord)[2 * k + 1]).cast<float>());
        return point_uvs_.empty() ? Eigen::Vector2f::Zero() : point_uvs_[index(k)];
      };
      if (texcoord || !point_uvs_.empty()) surface_.uvs.push_back({uv(a), uv(b), uv(c)});
    }
  }
  void read_materials(const PlyElement& element) {
    const auto diffuse = columns<3>(element, {"diffuse_red", "diffuse_green", "diffuse_blue"});
    for (std::uint64_t i = 0; i < element.count; ++i) {
      const Row& row = rows_.next(element);
      if (!diffuse || i > 0) continue;
      surface_.color = values(row, *diffuse) / (element.properties[(*diffuse)[0]].type.kind == 'f' ? 1 : 255);
      if (!(surface_.color->minCoeff() >= 0 && surface_.color->maxCoeff() <= 1))
        rows_.fail("has a colour that is not within 0 and 1, or 255");
    }
  }
  Eigen::Vector2f finite_uv(const Eigen::Vector2f& uv) const {
    if (!uv.allFinite()) rows_.fail("has texture coordinates that are not finite");
    return uv;
  }

  const fs::path& path_;
  const PlyHeader header_;
  PlyRows rows_;
  SurfaceFile surface_{};
  std::vector<Eigen::Vector2f> point_uvs_{};  // or none
};

}  // namespace

void write_ply(const fs::path& path, const std::string& comment, const std::string& elements,
               const std::string& data) {
  write_text(path, fmt::format("ply\nformat binary_little_endian 1.0\ncomment {}\n{}end_header\n", comment,
                               elements) +
                       data);
}

void write_surface_ply(const fs::path& path, const SurfaceFile& surface, const std::string& comment) {
  const bool has_normals = !surface.normals.empty();
  std::string elements = fmt::format(
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", surface.points.size());
  if (has_normals) elements += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!surface.triangles.empty())
    elements +=
        fmt::format("element face {}\nproperty list uchar int vertex_indices\n", surface.triangles.size());
  std::string data;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    for (int k = 0; k < 3; ++k) put(data, surface.points[i][k]);
    for (int k = 0; has_normals && k < 3; ++k) put(data, surface.normals[i][k]);
  }
  for (const auto& triangle : surface.triangles) {
    put(data, std::uint8_t{3});
    for (const std::uint32_t corner : triangle) put(data, static_cast<std::int32_t>(corner));
  }
  write_ply(path, comment, elements, data);
}

SurfaceFile read_surface_ply(const fs::path& path) {
  return SurfaceReader(path, read_file(path, kPointFile)).read();
}

}  // namespace uniquadric
