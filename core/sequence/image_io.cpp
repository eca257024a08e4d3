#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/sequence.h"

namespace uniquadric {
namespace {

// OpenCV decodes truncated files to partly grey images: look for the format's own end first.
bool is_complete(const std::string& bytes) {
  const std::string_view view(bytes);
  if (view.starts_with("\x89PNG")) return view.size() > 12 && view.substr(view.size() - 8, 4) == "IEND";
  if (view.starts_with("\xff\xd8"))
    return view.find("\xff\xd9", view.size() > 64 ? view.size() - 64 : 0) != view.npos;
  return true;
}

}  // namespace

cv::Mat read_image(const std::filesystem::path& path) {
  const std::string bytes = read_text(path);
  if (bytes.empty()) throw InputError(path, "is empty");
  if (!is_complete(bytes)) throw InputError(path, "is a truncated image");
  cv::Mat image;
  try {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    image = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
  }
  if (image.empty()) throw InputError(path, "is not an image that can be decoded");
  return image;
}

void write_png(const std::filesystem::path& path, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", image, bytes,
                    {cv::IMWRITE_PNG_COMPRESSION, 1}))  // level 1: 30 times faster than 9
    throw std::runtime_error(fmt::format("{}: cannot be encoded", path.string()));
  write_text(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace uniquadric
