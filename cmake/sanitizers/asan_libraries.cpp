// Linked into every program that is built with the address sanitizer: OpenCV makes tables of the Lab colour
// space at its first use and never frees them, which counts as a leak. Its stacks are not complete enough for
// a suppression by name.
#include <sanitizer/lsan_interface.h>

#include <opencv2/imgproc.hpp>

namespace {

[[maybe_unused]] const bool has_tables = [] {
  const __lsan::ScopedDisabler disabler;
  cv::Mat lab;
  cv::cvtColor(cv::Mat::zeros(1, 1, CV_8UC3), lab, cv::COLOR_BGR2Lab);
  return true;
}();

}  // namespace
