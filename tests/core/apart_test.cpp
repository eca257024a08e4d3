#include "core/base/apart.h"

#include <gtest/gtest.h>
#include <unistd.h>

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

// As <(...) of a shell gives one; its name leads to nothing that could be resolved.
TEST(RequireApart, APipeIsNoPlaceToHarm) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const fs::path in = "/dev/fd/" + std::to_string(ends[0]);
  EXPECT_EQ(refusal("out", {in}), "");
  close(ends[0]);
  close(ends[1]);
  EXPECT_EQ(refusal("out", {in}), "");  // gone: whoever reads it says so
}

TEST(RequireApart, ALinkInACircleIsNamed) {
  const TempFolder temp;
  fs::create_symlink(temp.path() / "b", temp.path() / "a");
  fs::create_symlink(temp.path() / "a", temp.path() / "b");
  EXPECT_NE(refusal(temp.path() / "a", {temp.path()}).find("a: cannot be resolved"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
