// Races, and what looks like them to a thread sanitizer that does not know TBB and OpenCV.
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace std::chrono_literals;

// Each long enough for the other thread to take some.
void for_each_of_a_hundred(const std::function<void(std::size_t)>& f) {
  tbb::task_arena(2).execute([&] {
    tbb::parallel_for(std::size_t{0}, std::size_t{100}, [&](std::size_t i) {
      std::this_thread::sleep_for(1ms);
      f(i);
    });
  });
}

void two_iterations_write_the_same() {
  int sum = 0;
  for_each_of_a_hundred([&](std::size_t) { ++sum; });
}

void two_threads_write_one_image() {
  cv::Mat image = cv::Mat::zeros(1, 1, CV_8U);
  std::thread other([image]() mutable { image.at<uchar>(0) = 1; });
  image.at<uchar>(0) = 2;
  other.join();
}

void loop_is_read_after_its_end() {
  std::vector<int> values(100);
  for (int again = 0; again < 3; ++again) for_each_of_a_hundred([&](std::size_t i) { values[i] += int(i); });
  int sum = 0;
  for (const int value : values) sum += value;
  std::printf("%d\n", sum);
}

// By whoever lets go of it last, here not the thread that read it.
void image_is_freed_by_the_last() {
  cv::Mat image = cv::Mat::zeros(1, 1, CV_8U);
  std::thread other([own = image]() mutable {
    std::printf("%d\n", own.at<uchar>(0));
    own.release();
  });
  std::this_thread::sleep_for(200ms);
  image.release();
  other.join();
}

const std::map<std::string, void (*)()> kCases = {
    {"two_iterations_write_the_same", two_iterations_write_the_same},
    {"two_threads_write_one_image", two_threads_write_one_image},
    {"loop_is_read_after_its_end", loop_is_read_after_its_end},
    {"image_is_freed_by_the_last", image_is_freed_by_the_last}};

}  // namespace

int main(int, char** argv) {
  kCases.at(argv[1])();
}
