#include "core/base/apart.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

std::string refusal(const fs::path& out, const std::vector<fs::path>& inputs) {
  try {
    require_apart(out, inputs);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(RequireApart, RefusesTheInputItselfWhatHoldsItAndWhatLiesInside) {
  const TempFolder temp;
  const fs::path in = temp.path() / "data/sequence";
  fs::create_directories(in);
  EXPECT_NE(refusal(in, {in}).find("is the input"), std::string::npos);
  EXPECT_NE(refusal(in.parent_path(), {in}).find("holds the input"), std::string::npos);
  EXPECT_NE(refusal(in / "new/out", {in}).find("lies inside the input"), std::string::npos);
  EXPECT_NE(refusal(in / "", {"", in}).find("is the input"), std::string::npos);
  EXPECT_NE(refusal(in / "../../data", {in}).find("holds the input"), std::string::npos);
}

TEST(RequireApart, FollowsLinks) {
  const TempFolder temp;
  const fs::path in = temp.path() / "sequence", link = temp.path() / "link";
  fs::create_directories(in);
  fs::create_directory_symlink(in, link);
  EXPECT_NE(refusal(link, {in}).find("is the input"), std::string::npos);
  EXPECT_NE(refusal(in, {link / "rgb"}).find("holds the input"), std::string::npos);
}

TEST(RequireApart, LetsNeighboursAndNamesThatBeginAlikePass) {
  const TempFolder temp;
  const fs::path in = temp.path() / "sequence";
  fs::create_directories(in);
  EXPECT_EQ(refusal(temp.path() / "sequence_2", {in}), "");
  EXPECT_EQ(refusal(temp.path() / "seq", {in}), "");
  EXPECT_EQ(refusal(in / "../out", {in}), "");
  EXPECT_EQ(refusal("", {in}), "");
}

}  // namespace
}  // namespace uniquadric
