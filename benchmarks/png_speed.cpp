// Files of one noisy 640x480 frame as `simulate` writes them, against OpenCV's PNG encoder without
// compression. Copying rows, finishing and writing are ours; the encoder (libpng, zlib level 0) writes to
// memory alone.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "simulator/png.h"

namespace {

using namespace uniquadric;

cv::Mat noisy_image(PngFormat format) {
  cv::Mat image(480, 640, format == PngFormat::rgb_8 ? CV_8UC3 : CV_16UC1);
  cv::RNG random(1);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

void fill(StoredPng& png, const cv::Mat& image) {
  for (int v = 0; v < image.rows; ++v) std::memcpy(png.row(v), image.ptr(v), image.cols * image.elemSize());
}

void ours(benchmark::State& state, PngFormat format, bool to_file) {
  const cv::Mat image = noisy_image(format);
  StoredPng png(format, image.cols, image.rows);
  const auto file = std::filesystem::temp_directory_path() / ("png_speed." + std::to_string(getpid()));
  for (auto _ : state) {
    fill(png, image);
    const std::string_view bytes = png.finish();
    if (to_file)
      write_file(file, bytes);
    else
      benchmark::DoNotOptimize(bytes.data());
  }
  std::filesystem::remove(file);
}

void encoder(benchmark::State& state, PngFormat format) {
  const cv::Mat image = noisy_image(format);
  std::vector<unsigned char> bytes;
  for (auto _ : state) cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 0});
}

BENCHMARK_CAPTURE(ours, colour_encode, PngFormat::rgb_8, false);
BENCHMARK_CAPTURE(ours, colour_file, PngFormat::rgb_8, true);
BENCHMARK_CAPTURE(encoder, colour, PngFormat::rgb_8);
BENCHMARK_CAPTURE(ours, depth_encode, PngFormat::grey_16, false);
BENCHMARK_CAPTURE(ours, depth_file, PngFormat::grey_16, true);
BENCHMARK_CAPTURE(encoder, depth, PngFormat::grey_16);

}  // namespace

BENCHMARK_MAIN();
