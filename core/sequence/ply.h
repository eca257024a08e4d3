#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace uniquadric {

/// Points of a surface and, of a mesh, triangles of indices into them.
struct SurfaceFile {
  std::vector<Eigen::Vector3f> points;                    ///< [m]
  std::vector<Eigen::Vector3f> normals;                   ///< outwards, one a point; or none
  std::vector<std::array<std::uint32_t, 3>> triangles{};  /// of a mesh
};

inline constexpr float kMostPlyCoordinate_m = 1e9F;  ///< as of tracks

/// Writes a binary little-endian PLY: `elements` are the header's lines from "element vertex" on, `data` what
/// they announce. Throws std::runtime_error when the file cannot be written.
void write_ply(const std::filesystem::path& path, const std::string& comment, const std::string& elements,
               const std::string& data);

/// PLY, binary little-endian (Turk, "The PLY polygon file format", 1994): x, y, z, nx, ny, nz as float, faces
/// as lists of uchar and int. Throws std::runtime_error when the file cannot be written.
void write_surface_ply(const std::filesystem::path& path, const SurfaceFile& surface,
                       const std::string& comment);

/// Reads x, y, z and where there are all three the normals of a binary little-endian PLY, floats or doubles,
/// and its faces, those of more than three corners as a fan. Other values are skipped. Throws InputError with
/// the file, and line in the header, for anything else, a file without points, coordinates that are not
/// finite or beyond kMostPlyCoordinate_m, and faces of points that there are not.
SurfaceFile read_surface_ply(const std::filesystem::path& path);

}  // namespace uniquadric
