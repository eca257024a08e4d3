#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

struct PcdField {
  std::string name;
  int size = 4;     ///< bytes
  char type = 'F';  ///< F, I or U
  int count = 1;    ///< values; more than one of padding alone

  bool is_padding() const { return name == "_"; }  ///< PCL's, and as often as it likes
};

/// A PCD 0.7 file with binary data.
struct PcdFile {
  std::vector<PcdField> fields;
  std::int64_t points = 0;
  Pose viewpoint;    ///< VIEWPOINT: translation, then quaternion w x y z
  std::string data;  ///< points in turn, their fields packed, little-endian

  int point_size() const;
  /// Appends a value to the data.
  template <typename T>
  void put(T value) {
    data.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
};

/// Where a field lies in a point.
struct PcdColumn {
  const PcdFile& file;
  std::size_t offset = 0;
  std::size_t point_size = static_cast<std::size_t>(file.point_size());

  template <typename T>
  T at(std::int64_t point) const {
    T value;
    std::copy_n(file.data.data() + static_cast<std::size_t>(point) * point_size + offset, sizeof value,
                reinterpret_cast<char*>(&value));
    return value;
  }
};

/// A field by name; throws InputError naming the file when it is missing or of another type.
PcdColumn pcd_column(const std::filesystem::path& path, const PcdFile& file, std::string_view name, char type,
                     int size);

/// Throws std::runtime_error when the file cannot be written; it is never seen half-written.
void write_pcd(const std::filesystem::path& path, const PcdFile& file);

/// Throws InputError naming file (and line, in the header) for a header that is incomplete or contradicts
/// itself or its data, for data that are not binary, for fields of more than one value or of one name. Bytes
/// of zero after the data are left out, as PCL pads its files with them.
PcdFile read_pcd(const std::filesystem::path& path);

}  // namespace uniquadric
