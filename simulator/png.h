#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

namespace uniquadric {

enum class PngFormat { rgb_8, grey_16 };

/// A PNG file that is written row by row, uncompressed: sensor noise leaves little to win (a factor 1.7) for
/// twenty times the time. It may be filled and finished again and again.
class StoredPng {
 public:
  /// Asserts that a row fits a block of 65535 bytes, which every image that OpenGL draws does.
  StoredPng(PngFormat format, int width, int height);

  /// Where row v's samples belong: red, green, blue; or the high byte before the low one.
  unsigned char* row(int v);
  /// The whole file, until a row is changed.
  std::string_view finish();

 private:
  std::size_t row_size_, rows_a_block_, rows_, data_begin_ = 0;
  std::string bytes_;
};

/// A 16UC1 image of areas as a PNG file, compressed: each row as its difference from the row above, runs of
/// equal bytes taken together.
std::string pack_png(const cv::Mat& ids);

/// Writes a file in place: for folders that nothing reads before they are complete.
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace uniquadric
