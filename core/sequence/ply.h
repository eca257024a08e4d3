#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace uniquadric {

/// Points of a surface and, of a mesh, triangles of indices into them and its look.
struct SurfaceFile {
  std::vector<Eigen::Vector3f> points;                    ///< [m]
  std::vector<Eigen::Vector3f> normals;                   ///< outwards, one a point; or none
  std::vector<std::array<std::uint32_t, 3>> triangles{};  ///< of a mesh
  std::vector<std::array<Eigen::Vector2f, 3>> uvs{};      ///< of the triangles' corners, v upwards; or none
  std::string texture_file{};                             ///< as the file names it; or empty
  std::optional<Eigen::Vector3f> color{};                 ///< red, green, blue in [0, 1]
};

inline constexpr float kMostPlyCoordinate_m = 1e9F;   ///< as of tracks
inline constexpr std::size_t kMostPlyCorners = 1000;  ///< of a face; ours: triangles take their square

/// Writes a binary little-endian PLY: `elements` are the header's lines from "element vertex" on, `data` what
/// they announce. Throws std::runtime_error when the file cannot be written.
void write_ply(const std::filesystem::path& path, const std::string& comment, const std::string& elements,
               const std::string& data);

/// PLY, binary little-endian (Turk, "The PLY polygon file format", 1994): x, y, z, nx, ny, nz as float, faces
/// as lists of uchar and int. Throws std::runtime_error when the file cannot be written.
void write_surface_ply(const std::filesystem::path& path, const SurfaceFile& surface,
                       const std::string& comment);

/// Reads a PLY, ascii or binary of either byte order, values of any type:
/// - of "vertex" x, y, z, where there are all three nx, ny, nz, and texture coordinates (u and v, s and t, tx
/// and ty,
///   texture_u and texture_v);
/// - of "face" vertex_indices (or vertex_index), triangulate()d, those of fewer than three corners left out,
/// and
///   the corners' own texture coordinates (texcoord);
/// - of "material" the first one's diffuse_red, diffuse_green, diffuse_blue, and "comment TextureFile".
///
/// Other values are skipped. Throws InputError with the file and the line, or in binary data the number of
/// the point or face, for anything else, a file without points, coordinates that are not finite or beyond
/// kMostPlyCoordinate_m, faces of more than kMostPlyCorners and of points that there are not.
SurfaceFile read_surface_ply(const std::filesystem::path& path);

}  // namespace uniquadric
