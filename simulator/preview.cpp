#include "simulator/preview.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/image_file.h"
#include "simulator/render/renderer.h"
#include "simulator/scene_files.h"

namespace uniquadric {
namespace {

constexpr int kGap_px = 4, kJpegQuality = 80;  // ours: 20 kB a picture of 240 px, no blocks to be seen

bool is_png(const std::filesystem::path& picture) {
  return picture.extension() == ".png";
}

}  // namespace

FileKind picture_kind(const std::filesystem::path& picture) {
  return is_png(picture) ? kPngFile : kJpegFile;
}

void require_picture_ending(const std::filesystem::path& picture) {
  const std::string ending = picture.extension().string();
  if (!is_png(picture) && ending != ".jpg" && ending != ".jpeg")
    throw InputError(picture, "a picture's name ends in .png, .jpg or .jpeg");
}

void write_preview(const Scene& scene, const PreviewOptions& options, const std::filesystem::path& file) {
  require_picture_ending(file);
  if (options.frames > scene.frames)
    throw InputError(
        fmt::format("scene {}: has {} frames, {} asked for", scene.name, scene.frames, options.frames));
  const int width = (options.width_px - kGap_px * (options.frames - 1)) / options.frames;
  const int height = width * scene.camera.height / scene.camera.width;
  if (width < 1 || height < 1)
    throw InputError(
        fmt::format("preview: {} frames do not fit into {} px", options.frames, options.width_px));
  cv::Mat picture(height, options.frames * (width + kGap_px) - kGap_px, CV_8UC3, cv::Scalar::all(255));
  Renderer renderer(scene);
  for (int i = 0; i < options.frames; ++i) {
    const double time_s = frame_time_s(scene, scene.frames * (2 * i + 1) / (2 * options.frames));
    cv::Mat colour, small;
    cv::cvtColor(renderer.render(poses_at(scene, time_s), color_steps(scene, time_s)).rgba, colour,
                 cv::COLOR_RGBA2BGR);
    cv::resize(colour, small, {width, height}, 0, 0, cv::INTER_AREA);
    small.copyTo(picture(cv::Rect(i * (width + kGap_px), 0, width, height)));
  }
  write_text(file, is_png(file)
                       ? encode_image(".png", picture, {}, file)
                       : encode_image(".jpg", picture, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality}, file));
}

}  // namespace uniquadric
