#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "core/sequence/image_file.h"
#include "core/sequence/sequence.h"
#include "evaluation/report/jpeg.h"
#include "evaluation/report/overlay.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kTileWidth_px = 480, kGap_px = 4, kMaxColumns = 4;

std::vector<fs::path> frame_files(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw InputError(folder, "is not a folder");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".jpg" && parse_integer(entry.path().stem().string()))
      files.push_back(entry.path());
  if (files.empty()) throw InputError(folder, "holds no frames (NNNNNN.jpg)");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

void write_jpeg(const fs::path& path, const cv::Mat& image, int quality) {
  write_text(path, encode_image(".jpg", image, {cv::IMWRITE_JPEG_QUALITY, quality}, path));
}

void write_contact_sheet(const fs::path& overlays, const fs::path& picture) {
  std::vector<cv::Mat> tiles;
  for (const fs::path& file : frame_files(overlays)) {
    const cv::Mat image = read_image(file);
    if (image.type() != CV_8UC3) throw InputError(file, "expected an 8-bit colour image");
    cv::Mat tile;
    cv::resize(image, tile, {kTileWidth_px, std::max(1, kTileWidth_px * image.rows / image.cols)}, 0, 0,
               cv::INTER_AREA);
    if (!tiles.empty() && tile.rows != tiles.front().rows)
      throw InputError(file, "is not of the same shape as the other frames");
    tiles.push_back(tile);
  }
  const int n = static_cast<int>(tiles.size()), height = tiles.front().rows;
  const int columns = std::min(n <= 4 ? 2 : n <= 9 ? 3 : kMaxColumns, n), rows = (n + columns - 1) / columns;
  cv::Mat sheet(rows * (height + kGap_px) + kGap_px, columns * (kTileWidth_px + kGap_px) + kGap_px, CV_8UC3,
                cv::Scalar(255, 255, 255));
  for (int i = 0; i < n; ++i) {
    const cv::Point corner(kGap_px + i % columns * (kTileWidth_px + kGap_px),
                           kGap_px + i / columns * (height + kGap_px));
    tiles[static_cast<std::size_t>(i)].copyTo(sheet(cv::Rect(corner, tiles.front().size())));
  }
  write_jpeg(picture, sheet);
}

}  // namespace uniquadric
