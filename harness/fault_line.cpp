#include "harness/fault_line.h"

#include <fmt/format.h>

#include <new>
#include <opencv2/core.hpp>
#include <string_view>

namespace uniquadric {
namespace {

bool is_out_of_memory(const std::exception& e) {
  const auto* opencv = dynamic_cast<const cv::Exception*>(&e);
  return dynamic_cast<const std::bad_alloc*>(&e) || (opencv && opencv->code == cv::Error::StsNoMem);
}

}  // namespace

std::string fault_line(const std::exception& e) {
  if (is_out_of_memory(e)) return "out of memory";
  std::string_view what = e.what();
  while (what.ends_with('\n')) what.remove_suffix(1);  // OpenCV's end with one
  return fmt::format("internal error: {}; please report it with the command and its input", what);
}

}  // namespace uniquadric
