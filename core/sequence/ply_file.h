#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace uniquadric {

struct PlyType {
  int size = 0;     ///< bytes
  char kind = 'u';  ///< unsigned, i signed, f floating-point
};

struct PlyProperty {
  std::string name;
  PlyType type, count;  ///< count: of a list's values; size 0 where it is none
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  int line = 0;  ///< of the header
  std::vector<PlyProperty> properties{};
};

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::string texture_file;  ///< "comment TextureFile NAME", the last one; or empty
  std::size_t end = 0;       ///< where the data begin
  int lines = 0;             ///< up to there
};

/// The header of a PLY file (Turk, "The PLY polygon file format", 1994), its lines ended in any system's way.
/// Throws InputError with the file and line for what is none, elements without properties or named twice, and
/// more rows of an element than the rest of the file can hold.
PlyHeader read_ply_header(const std::filesystem::path& path, std::string_view bytes);

/// Reads the rows of a PLY's elements in turn. All arguments are to outlive it.
class PlyRows {
 public:
  PlyRows(const std::filesystem::path& path, std::string_view bytes, const PlyHeader& header);

  /// The next row: a property's numbers each, one where it is no list. As long as no other is read. Throws
  /// InputError, as fail(), for what is none.
  const std::vector<std::vector<double>>& next(const PlyElement& element);
  /// Throws InputError for anything after the last row but blank lines of text.
  void expect_end();
  /// Throws InputError about the row that was read last: "PATH:LINE: what" in text, else "PATH: face 3:
  /// what".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  void begin_row(const PlyElement& element);
  double number(const PlyType& type);
  double word();
  const std::filesystem::path& path_;
  std::string_view left_;
  PlyFormat format_;
  int line_;
  const PlyElement* element_ = nullptr;
  std::uint64_t row_ = 0;  // of the element
  std::vector<std::vector<double>> values_{};
};

}  // namespace uniquadric
