// Small files that would unfold to more than a machine's memory, or recurse deeper than its stack, through
// every reader: refused, within a bound on the memory.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <iostream>
#include <set>

#include "fuzz/target.h"

namespace uniquadric::fuzz {
namespace {

constexpr long kMostMemory_KiB = 700 << 10;  // of a process that starts with 100 MB of libraries
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr long kSanitizer = 6;  // their shadows and quarantines
#else
constexpr long kSanitizer = 1;
#endif

using Bomb = std::function<std::string(const std::string& target)>;

// What has no one input to refuse: an answer for each line, a list of what differs, any numbers; and tables
// whose first row may be a header, after which no row need come.
bool goes_on(const std::string& target) {
  static const std::set<std::string> kTargets = {"metric_jsonl", "hashes_txt", "kitti_scan", "omd_vicon_csv",
                                                 "euroc_states_csv"};
  return kTargets.contains(target);
}

// Ends this process: 0 where each of the targets refuses its bomb and the memory stays within bounds.
[[noreturn]] void feed_all(const Bomb& bomb, const std::string& only = "") {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const rlimit limit{8l << 30, 8l << 30};  // so that no failure takes the machine with it
  setrlimit(RLIMIT_AS, &limit);
#endif
  int bad = 0;
  for (const auto& [name, target] : Target::all()) {
    if (!only.empty() && name != only) continue;
    const std::string refusal = target.feed(bomb(name));
    if (refusal.empty() && !goes_on(name)) ++bad, std::cerr << name << " takes it\n";
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    if (usage.ru_maxrss < kMostMemory_KiB * kSanitizer) continue;
    std::cerr << name << ": " << usage.ru_maxrss / 1024 << " MiB\n";
    std::exit(2);
  }
  std::exit(bad == 0 ? 0 : 1);
}

class Bombs : public testing::Test {
 protected:
  static void SetUpTestSuite() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

std::string repeated(const std::string& text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) result += text;
  return result;
}

Bomb always(const std::string& bytes) {
  return [bytes](const std::string&) { return bytes; };
}

void expect_refused(const Bomb& bomb, const std::string& only = "") {
  EXPECT_EXIT(feed_all(bomb, only), testing::ExitedWithCode(0), "");
}

TEST_F(Bombs, AliasesOfAliases) {
  std::string laughs = "a0: &a0 [ha, ha, ha, ha, ha, ha, ha, ha, ha, ha]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string before = ", *a" + std::to_string(i - 1), name = "a" + std::to_string(i);
    laughs += name + ": &" + name + " [" + repeated(before, 10).substr(2) + "]\n";
  }
  expect_refused(always(laughs));
  expect_refused(always("&a [*a, *a]\n"));
}

TEST_F(Bombs, DeepNesting) {
  for (const char* level : {"[", "{a: ", "- ", "{\"a\":["}) expect_refused(always(repeated(level, 20'000)));
  expect_refused(always(repeated("[", 1'000'000) + repeated("]", 1'000'000) + "\n"));
}

TEST_F(Bombs, EndlessLines) {
  for (const std::string field : {"1 ", ",", "a"}) {
    const std::string line = repeated(field, (1 << 20) / static_cast<int>(field.size()) + 1);
    // YAML may hold a long text.
    expect_refused(
        [&](const std::string& name) { return name == "yaml" || name == "run_yaml" ? "[" + line : line; });
  }
}

TEST_F(Bombs, HugeNumbers) {
  const std::string digits(1 << 16, '9');
  for (const std::string& number : {digits, "1e" + digits, std::string("1e999999999"), "-0." + digits})
    expect_refused(always(repeated(number + " ", 2) + "\n" + number + ": " + number + "\n"));
}

TEST_F(Bombs, ImagesLargerThanMemory) {
  const std::string size("\0\1\x86\xa0\0\1\x86\xa0", 8);  // 100,000 x 100,000
  const std::string png = "\x89PNG\r\n\x1a\n" + std::string("\0\0\0\rIHDR", 8) + size +
                          std::string("\x08\2\0\0\0....", 9) + std::string("\0\0\0\0IEND....", 12);
  expect_refused(always(png), "png");
}

// OpenCV would give it to its reader of DICOM, which an assertion of its own ends, and the program with it.
TEST_F(Bombs, AnImageOfAnotherFormatThanItsFirstBytesSay) {
  const std::string dicom = std::string(124, '\0') + "DICM" + std::string("\2\0\x10\0\0\0\0\x60", 8);
  const std::string end("\0\0\0\0IEND....", 12);
  expect_refused(always("\x89PNG" + dicom + std::string(64, '\0') + end), "png");
  expect_refused(always("\xff\xd8" + dicom + std::string(64, '\0') + "\xff\xd9"), "jpeg");
}

TEST_F(Bombs, CountsThatTheFileCannotHold) {
  const auto pcd = [](const std::string& points, const std::string& width) {
    return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + width +
           "\nHEIGHT 1\nPOINTS " + points + "\nDATA binary\n";
  };
  for (const char* points : {"1000000000000", "1000000000", "9223372036854775807"})
    expect_refused(always(pcd(points, points)), "pcd");
  for (const char* count : {"1000000000000", "4000000000", "100000000"})
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
      for (const char* target : {"mesh_ply", "surface_ply"})
        expect_refused(always("ply\nformat " + std::string(format) + " 1.0\nelement vertex " + count +
                              "\nproperty float x\nend_header\n"),
                       target);
  expect_refused(always(std::string("\0\0\0\0\x40\0\0\0\0", 9)), "observations_bin");  // bodies
}

}  // namespace
}  // namespace uniquadric::fuzz
