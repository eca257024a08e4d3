// What the fuzzer starts from, and what it once found: each file of fuzz/corpus/TARGET goes through its
// reader.
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "fuzz/target.h"

namespace uniquadric::fuzz {
namespace {
namespace fs = std::filesystem;

const fs::path kCorpora = fs::path(UNIQUADRIC_SOURCE_DIR) / "fuzz/corpus";

std::string bytes_of(const fs::path& file) {
  std::ostringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  return std::move(bytes).str();
}

TEST(FuzzCorpus, EachFileIsReadOrRefused) {
  for (const auto& [name, target] : Target::all()) {
    int fed = 0;
    for (const auto& entry : fs::directory_iterator(kCorpora / name)) {
      SCOPED_TRACE(entry.path().string());
      EXPECT_NO_THROW(target.feed(bytes_of(entry.path())));
      ++fed;
    }
    EXPECT_GT(fed, 0) << name;
  }
  EXPECT_GE(Target::all().size(), 25u);
}

TEST(FuzzCorpus, EachCorpusHasItsReader) {
  for (const auto& entry : fs::directory_iterator(kCorpora))
    EXPECT_TRUE(Target::all().contains(entry.path().filename().string())) << entry.path();
}

}  // namespace
}  // namespace uniquadric::fuzz
