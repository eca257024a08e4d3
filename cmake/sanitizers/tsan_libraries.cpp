// Linked into every program that is built with the thread sanitizer, for libraries of Debian that are not
// instrumented: how their threads wait for each other is not seen, so that what is done after it would look
// like a race. Their loops run on one thread, and the hand-over of an image from thread to thread is told.
#include <dlfcn.h>
#include <sanitizer/tsan_interface.h>

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <string>

namespace {

template <typename Function>
Function next(const char* symbol) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, symbol));
}

[[maybe_unused]] const bool opencv_has_one_thread = [] {
  cv::setNumThreads(1);
  return true;
}();

}  // namespace

/// Embree's, in whose place it stands: building its trees is the loop here.
extern "C" void* rtcNewDevice(const char* config) {
  static const auto original = next<void* (*)(const char*)>("rtcNewDevice");
  const std::string given = config ? config : "";
  return original((given + (given.empty() ? "" : ",") + "threads=1").c_str());
}

/// OpenCV's, in whose place it stands: some tests ask for several.
void cv::setNumThreads(int /*threads*/) {
  next<void (*)(int)>("_ZN2cv13setNumThreadsEi")(1);
}

// OpenCV's, in whose place they stand: whoever lets go of an image last frees it, after all others let go of
// it.
void cv::Mat::release() {
  static const auto original = next<void (*)(Mat*)>("_ZN2cv3Mat7releaseEv");
  if (u) __tsan_release(u);
  original(this);
}

void cv::Mat::deallocate() {
  static const auto original = next<void (*)(Mat*)>("_ZN2cv3Mat10deallocateEv");
  if (u) __tsan_acquire(u);
  original(this);
}
