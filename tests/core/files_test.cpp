#include "core/base/files.h"

#include <gtest/gtest.h>

#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

TEST(PendingFolder, AppearsOnlyWhenCommitted) {
  const TempFolder temp;
  const fs::path out = temp.path() / "out";
  {
    PendingFolder pending(out, false);
    write_text(pending.path() / "a.txt", "a");
    EXPECT_FALSE(fs::exists(out));
    pending.commit();
  }
  EXPECT_EQ(read_text(out / "a.txt"), "a");
  EXPECT_EQ(std::distance(fs::directory_iterator(temp.path()), {}), 1);
}

TEST(PendingFolder, LeavesNothingBehindWhenAbandoned) {
  const TempFolder temp;
  { const PendingFolder pending(temp.path() / "out", false); }
  EXPECT_TRUE(fs::is_empty(temp.path()));
}

TEST(PendingFolder, ReplacesOnlyWhenAsked) {
  const TempFolder temp;
  const fs::path out = temp.path() / "out";
  fs::create_directory(out);
  write_text(out / "old.txt", "old");
  EXPECT_NE(input_error([&] { PendingFolder(out, false); }).find("not empty"), std::string::npos);
  {
    PendingFolder pending(out.string() + "/", true);  // a trailing slash names the same folder
    write_text(pending.path() / "new.txt", "new");
    EXPECT_TRUE(fs::exists(out / "old.txt"));
    pending.commit();
  }
  EXPECT_FALSE(fs::exists(out / "old.txt"));
  EXPECT_TRUE(fs::exists(out / "new.txt"));
}

TEST(PendingFolder, LeavesFoldersOfOthersAlone) {
  const TempFolder temp;
  const fs::path out = temp.path() / "out";
  fs::create_directories(temp.path() / "out.partial");
  write_text(temp.path() / "out.partial" / "notes", "mine");
  for (const bool keep_partial : {false, true})
    EXPECT_NE(input_error([&] { PendingFolder(out, true, keep_partial); }).find("in the way"),
              std::string::npos);
  EXPECT_EQ(read_text(temp.path() / "out.partial" / "notes"), "mine");
  fs::remove_all(temp.path() / "out.partial");
  for (const char* name : {"out", "out.old", "out.old0"}) {
    fs::create_directories(temp.path() / name);
    write_text(temp.path() / name / "notes", name);
  }
  PendingFolder(out, true).commit();
  EXPECT_TRUE(fs::is_empty(out));
  EXPECT_EQ(read_text(temp.path() / "out.old" / "notes"), "out.old");
  EXPECT_EQ(read_text(temp.path() / "out.old0" / "notes"), "out.old0");
}

TEST(PendingFolder, TakesOneWriterAtATime) {
  const TempFolder temp;
  for (const bool keep_partial : {false, true}) {
    PendingFolder first(temp.path() / "out", false, keep_partial);
    write_text(first.path() / "a.txt", "a");
    EXPECT_NE(
        input_error([&] { PendingFolder(temp.path() / "out", false, keep_partial); }).find("another process"),
        std::string::npos);
    EXPECT_EQ(read_text(first.path() / "a.txt"), "a");
  }
  EXPECT_NE(input_error([] { PendingFolder("", false); }).find("no name"), std::string::npos);
}

TEST(PendingFolder, RefusesToReplaceAFile) {
  const TempFolder temp;
  write_text(temp.path() / "out", "precious");
  EXPECT_NE(input_error([&] { PendingFolder(temp.path() / "out", true); }).find("not a folder"),
            std::string::npos);
  EXPECT_EQ(read_text(temp.path() / "out"), "precious");
}

TEST(PendingFolder, RefusesALinkToNothingAndTakesOneToAFolder) {
  const TempFolder temp;
  const fs::path link = temp.path() / "link";
  fs::create_symlink(temp.path() / "nothing", link);
  EXPECT_NE(input_error([&] { PendingFolder(link, true); }).find("link: is a link to "), std::string::npos);
  EXPECT_FALSE(fs::exists(temp.path() / "nothing"));
  EXPECT_FALSE(fs::exists(link.string() + ".partial"));
  fs::create_directory(temp.path() / "nothing");
  PendingFolder(link, false).commit();
  EXPECT_TRUE(fs::is_directory(link));
}

TEST(Files, WriteTextLeavesNoAsideFile) {
  const TempFolder temp;
  write_text(temp.path() / "a.txt", "one");
  write_text(temp.path() / "a.txt", "two");
  EXPECT_EQ(read_text(temp.path() / "a.txt"), "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(temp.path()), {}), 1);
  EXPECT_THROW(write_text(temp.path() / "no/such/folder.txt", "x"), std::runtime_error);
}

}  // namespace
}  // namespace uniquadric
