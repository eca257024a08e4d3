#include "core/base/folder_hashes.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// What `xxh64sum` of xxHash 0.8.1 prints for these files.
TEST(HashFile, IsXxh64) {
  const TempFolder temp;
  const fs::path file = temp.path() / "file";
  for (const auto& [content, expected] : {std::pair{std::string(), "ef46db3751d8e999"},
                                          {std::string("abc"), "44bc2cf5ad770999"},
                                          {std::string(1'000'000, 'a'), "dc483aaa9b4fdc40"}}) {
    write_text(file, content);
    EXPECT_EQ(hex(hash_file(file)), expected) << content.size() << " bytes";
  }
  EXPECT_NE(input_error([&] { hash_file(temp.path()); }).find("is a folder"), std::string::npos);
  EXPECT_NE(input_error([&] { hash_file(temp.path() / "none"); }).find("cannot be read"), std::string::npos);
}

TEST(FolderHashes, ListEveryFileInOrderForAnyThreads) {
  const TempFolder temp;
  fs::create_directories(temp.path() / "a/b");
  write_text(temp.path() / "z", "abc");
  write_text(temp.path() / "a/b/empty", "");
  for (const int threads : {1, 2}) {
    write_hashes(temp.path(), threads);
    EXPECT_EQ(read_text(temp.path() / kHashesFile), "ef46db3751d8e999  a/b/empty\n44bc2cf5ad770999  z\n");
    EXPECT_TRUE(check_hashes(temp.path(), threads).empty());
  }
}

TEST(FolderHashes, LeaveOutAListThatWasNeverFinished) {
  const TempFolder temp;
  write_text(temp.path() / "z", "abc");
  write_text(aside_of(temp.path() / kHashesFile), "44bc2");
  write_hashes(temp.path());
  EXPECT_EQ(read_text(temp.path() / kHashesFile), "44bc2cf5ad770999  z\n");
}

TEST(FolderHashes, TellWhatHasChanged) {
  const TempFolder temp;
  for (const char* name : {"same", "changed", "gone"}) write_text(temp.path() / name, name);
  write_hashes(temp.path());
  write_text(temp.path() / "changed", "Changed");
  fs::remove(temp.path() / "gone");
  write_text(temp.path() / "new", "new");
  const std::vector<std::string> problems = check_hashes(temp.path());
  ASSERT_EQ(problems.size(), 3);
  EXPECT_NE(problems[0].find("changed: has changed"), std::string::npos) << problems[0];
  EXPECT_NE(problems[1].find("gone: is missing"), std::string::npos) << problems[1];
  EXPECT_NE(problems[2].find("new: does not stand"), std::string::npos) << problems[2];
}

TEST(FolderHashes, AListHoldsWhileItsFilesAreTheSameAndMayHaveCompany) {
  const TempFolder temp;
  fs::create_directories(temp.path() / "sub");
  for (const char* name : {"one", "sub/with a blank"}) write_text(temp.path() / name, name);
  const std::string list = list_hashes(temp.path());
  write_text(temp.path() / "more", "");
  EXPECT_TRUE(holds_all_of(list, temp.path()));
  for (const char* damaged : {"", "a", "0123456789abcdef", "0123456789abcdef  "})
    EXPECT_FALSE(holds_all_of(damaged, temp.path())) << damaged;
  write_text(temp.path() / "one", "eno");
  EXPECT_FALSE(holds_all_of(list, temp.path())) << "changed";
  write_text(temp.path() / "one", "one");
  EXPECT_TRUE(holds_all_of(list, temp.path()));
  fs::remove(temp.path() / "sub/with a blank");
  EXPECT_FALSE(holds_all_of(list, temp.path())) << "missing";
}

// A damaged list, an edited text or a missing one; images are not looked at.
TEST(FolderHashes, TextsThatAreNotAsListedAreRefused) {
  const TempFolder temp;
  const fs::path folder = temp.path();
  fs::create_directories(folder / "objects");
  for (const char* name : {"objects/1.tum", "objects.yaml", "image.png"})
    write_text(folder / name, "as it was");
  EXPECT_NO_THROW(require_unchanged_texts(folder));  // there is no list
  write_hashes(folder);
  write_text(folder / "image.png", "edited");
  EXPECT_NO_THROW(require_unchanged_texts(folder));
  write_text(folder / "objects/1.tum", "edited");
  EXPECT_EQ(input_error([&] { require_unchanged_texts(folder); }),
            (folder / "objects/1.tum").string() +
                ": is not as hashes.txt says: it was edited or damaged; --no-verify takes it as it is");
  fs::remove(folder / "objects/1.tum");
  EXPECT_EQ(input_error([&] { require_unchanged_texts(folder); }),
            (folder / "objects/1.tum").string() + ": is missing, but stands in hashes.txt");
  write_text(folder / "hashes.txt", "");  // a list that lost its lines vouches for nothing
  EXPECT_NE(input_error([&] {
              require_unchanged_texts(folder);
            }).find("objects.yaml: does not stand in hashes.txt"),
            std::string::npos);
  write_text(folder / "hashes.txt", "damaged\n");
  EXPECT_EQ(input_error([&] { require_unchanged_texts(folder); }),
            (folder / "hashes.txt").string() + ":1: expected: hash path");
}

}  // namespace
}  // namespace uniquadric
