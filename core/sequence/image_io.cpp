#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>

#include "core/base/files.h"
#include "core/sequence/image_file.h"
#include "core/sequence/sequence.h"

namespace uniquadric {

cv::Mat read_image(const std::filesystem::path& path) {
  return decode_image(read_text(path), kMostImageSide_px, path);
}

void write_png(const std::filesystem::path& path, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", image, bytes,
                    {cv::IMWRITE_PNG_COMPRESSION, 1}))  // level 1: 30 times faster than 9
    throw std::runtime_error(fmt::format("{}: cannot be encoded", path.string()));
  write_text(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace uniquadric
