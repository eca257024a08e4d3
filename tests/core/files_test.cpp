#include "core/base/files.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <future>

#include "core/base/config.h"
#include "core/base/hash.h"
#include "core/base/read_file.h"
#include "core/base/text.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

TEST(PendingFolder, AppearsOnlyWhenCommitted) {
  const TempFolder temp;
  const fs::path out = temp.path() / "out";
  {
    PendingFolder pending(out, "test", false);
    write_text(pending.path() / "a.txt", "a");
    EXPECT_FALSE(fs::exists(out));
    pending.commit();
  }
  EXPECT_EQ(read_text(out / "a.txt"), "a");
  EXPECT_EQ(std::distance(fs::directory_iterator(temp.path()), {}), 1);
}

TEST(PendingFolder, LeavesNothingBehindWhenAbandoned) {
  const TempFolder temp;
  { const PendingFolder pending(temp.path() / "out", "test", false); }
  EXPECT_TRUE(fs::is_empty(temp.path()));
}

TEST(PendingFolder, ReplacesOnlyWhenAsked) {
  const TempFolder temp;
  const fs::path out = temp.path() / "out";
  PendingFolder(out, "test", false).commit();
  write_text(out / "old.txt", "old");
  EXPECT_NE(input_error([&] { PendingFolder(out, "test", false); }).find("not empty"), std::string::npos);
  {
    PendingFolder pending(out.string() + "/", "test", true);  // a trailing slash names the same folder
    write_text(pending.path() / "new.txt", "new");
    EXPECT_TRUE(fs::exists(out / "old.txt"));
    pending.commit();
  }
  EXPECT_FALSE(fs::exists(out / "old.txt"));
  EXPECT_TRUE(fs::exists(out / "new.txt"));
}

TEST(PendingFolder, ReplacesNothingButItsOwnKind) {
  const TempFolder temp;
  const fs::path out = temp.path() / "out";
  fs::create_directories(out / ".git");
  EXPECT_EQ(input_error([&] { PendingFolder(out, "test", true); }),
            out.string() + ": was not written by this program, so --force does not replace it");
  EXPECT_TRUE(fs::exists(out / ".git"));
  fs::remove_all(out);
  PendingFolder(out, "sequence", false).commit();
  EXPECT_EQ(kind_of_folder(out), "sequence");
  EXPECT_EQ(
      input_error([&] { PendingFolder(out, "test", true); }),
      out.string() + ": holds another kind of result (sequence, not test), so --force does not replace it");
  EXPECT_EQ(kind_of_folder(out), "sequence");
}

TEST(ReplaceableFile, IsARegularOneThatMayBeReplacedOrNone) {
  const TempFolder temp;
  const fs::path file = temp.path() / "file", link = temp.path() / "link", pipe = temp.path() / "pipe";
  EXPECT_NO_THROW(require_replaceable_file(file, false));
  EXPECT_NO_THROW(require_replaceable_file("", false));
  write_text(file, "mine");
  EXPECT_EQ(input_error([&] { require_replaceable_file(file, false); }),
            file.string() + ": exists; give another name or --force");
  EXPECT_NO_THROW(require_replaceable_file(file, true));
  EXPECT_NO_THROW(require_replaceable_file(file, true, {"note of mine", "mi"}));
  EXPECT_EQ(input_error([&] { require_replaceable_file(file, true, kJpegFile); }),
            file.string() + ": is no JPEG picture, so --force does not replace it");
  EXPECT_EQ(input_error([&] {
              require_replaceable_file(file, true, {"longer one", "mine and more"});
            }),
            file.string() + ": is no longer one, so --force does not replace it");
  write_text(file, "");
  EXPECT_NO_THROW(require_replaceable_file(file, true, kJpegFile));
  fs::create_symlink(file, link);
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const fs::path& other : {link, pipe, temp.path(), fs::path("/dev/null")})
    EXPECT_NE(input_error([&] { require_replaceable_file(other, true); }).find("is not a regular file"),
              std::string::npos)
        << other;
}

TEST(PendingFolder, LeavesFoldersOfOthersAlone) {
  const TempFolder temp;
  const fs::path out = temp.path() / "out";
  fs::create_directories(temp.path() / "out.partial");
  write_text(temp.path() / "out.partial" / "notes", "mine");
  for (const bool keep_partial : {false, true})
    EXPECT_NE(input_error([&] { PendingFolder(out, "test", true, keep_partial); }).find("in the way"),
              std::string::npos);
  EXPECT_EQ(read_text(temp.path() / "out.partial" / "notes"), "mine");
  fs::remove_all(temp.path() / "out.partial");
  for (const char* name : {"out", "out.old", "out.old0"}) {
    fs::create_directories(temp.path() / name);
    write_text(temp.path() / name / "notes", name);
  }
  fs::remove_all(out);
  PendingFolder(out, "test", false).commit();
  PendingFolder(out, "test", true).commit();
  EXPECT_EQ(std::distance(fs::directory_iterator(out), {}), 1);  // the mark of its kind
  EXPECT_EQ(read_text(temp.path() / "out.old" / "notes"), "out.old");
  EXPECT_EQ(read_text(temp.path() / "out.old0" / "notes"), "out.old0");
}

TEST(PendingFolder, WhatAKilledProcessLeftIsClearedAwayOrGoneOnWith) {
  const TempFolder temp;
  const fs::path out = temp.path() / "out";
  const pid_t child = fork();
  if (child == 0) {
    const PendingFolder pending(out, "test", false);
    write_text(pending.path() / "half", "done");
    _exit(0);  // as by a signal: no destructor runs
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  ASSERT_TRUE(fs::exists(temp.path() / "out.partial/half"));
  EXPECT_TRUE(fs::exists(PendingFolder(out, "test", false, true).path() / "half"));
  {
    PendingFolder pending(out, "test", false);
    EXPECT_FALSE(fs::exists(pending.path() / "half"));
    pending.commit();
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(out), {}), 1);  // the mark of its kind
  EXPECT_FALSE(fs::exists(temp.path() / "out.partial"));
}

TEST(PendingFolder, TakesOneWriterAtATime) {
  const TempFolder temp;
  PendingFolder first(temp.path() / "out", "test", false);
  write_text(first.path() / "a.txt", "a");
  const auto second = [&](bool keep_partial) {
    return std::async(std::launch::async, [&, keep_partial] {
      return input_error([&] { PendingFolder(temp.path() / "out", "test", false, keep_partial); });
    });
  };
  auto keeping = second(true), clearing = second(false);  // at once: both wait for what may be dying
  EXPECT_NE(keeping.get().find("another process"), std::string::npos);
  EXPECT_NE(clearing.get().find("another process"), std::string::npos);
  EXPECT_EQ(read_text(first.path() / "a.txt"), "a");
  EXPECT_NE(input_error([] { PendingFolder("", "test", false); }).find("no name"), std::string::npos);
}

// A killed process' workers are killed after it.
TEST(PendingFolder, WaitsForAWriterThatIsDying) {
  const TempFolder temp;
  const fs::path out = temp.path() / "out", half = temp.path() / "out.partial/half";
  const pid_t child = fork();
  if (child == 0) {
    const PendingFolder pending(out, "test", false);
    write_text(half, "done");
    usleep(200'000);
    _exit(0);  // as by a signal: no destructor runs
  }
  while (!fs::exists(half) && waitpid(child, nullptr, WNOHANG) == 0) usleep(1000);
  PendingFolder(out, "test", false).commit();
  EXPECT_EQ(std::distance(fs::directory_iterator(out), {}), 1);  // the mark of its kind
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
}

TEST(PendingFolder, RefusesToReplaceAFile) {
  const TempFolder temp;
  write_text(temp.path() / "out", "precious");
  EXPECT_NE(input_error([&] { PendingFolder(temp.path() / "out", "test", true); }).find("not a folder"),
            std::string::npos);
  EXPECT_EQ(read_text(temp.path() / "out"), "precious");
}

TEST(PendingFolder, RefusesALinkToNothingAndTakesOneToAFolder) {
  const TempFolder temp;
  const fs::path link = temp.path() / "link";
  fs::create_symlink(temp.path() / "nothing", link);
  EXPECT_NE(input_error([&] { PendingFolder(link, "test", true); }).find("link: is a link to "),
            std::string::npos);
  EXPECT_FALSE(fs::exists(temp.path() / "nothing"));
  EXPECT_FALSE(fs::exists(link.string() + ".partial"));
  fs::create_directory(temp.path() / "nothing");
  PendingFolder(link, "test", false).commit();
  EXPECT_TRUE(fs::is_directory(link));
}

TEST(Files, PipesDevicesAndSocketsAreRefused) {
  const TempFolder temp;
  const fs::path pipe = temp.path() / "pipe", link = temp.path() / "link", end = temp.path() / "socket";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);  // nobody writes: opening it would wait for ever
  fs::create_symlink(pipe, link);
  sockaddr_un address{AF_UNIX, {}};
  ASSERT_LT(end.string().size(), sizeof address.sun_path);
  end.string().copy(address.sun_path, sizeof address.sun_path - 1);
  const int socket_end = socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(bind(socket_end, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  for (const fs::path& path : {pipe, link, end, fs::path("/dev/zero")}) {
    const std::string expected = path.string() + ": is not a regular file";
    EXPECT_EQ(input_error([&] { read_text(path); }), expected);
    EXPECT_EQ(input_error([&] { read_file(path, kPointFile); }), expected);
    EXPECT_EQ(input_error([&] { for_each_line(path, [](int, const auto&) {}); }), expected);
    EXPECT_EQ(input_error([&] { ConfigNode::load(path); }), expected);
    EXPECT_EQ(input_error([&] { hash_file(path); }), expected);
    EXPECT_EQ(input_error([&] { duplicate_file(path, temp.path() / "copy"); }), expected);
  }
  close(socket_end);
  EXPECT_FALSE(fs::exists(temp.path() / "copy"));
  EXPECT_EQ(input_error([&] { read_text(temp.path()); }),
            temp.path().string() + ": is a folder, expected a file");
  EXPECT_EQ(input_error([&] { read_text(temp.path() / "none"); }),
            temp.path().string() + "/none: cannot be read: No such file or directory");
}

// Holes: no disk is needed, and none of it is read.
TEST(Files, AreReadUpToWhatTheirKindHas) {
  const TempFolder temp;
  const fs::path file = temp.path() / "large";
  const auto refusal = [&](std::uintmax_t bytes, const FileBound& bound) {
    write_text(file, "");
    fs::resize_file(file, bytes);
    return input_error([&] { read_file(file, bound); });
  };
  for (const FileBound& bound : {kTextFile, kYamlFile, kImageFile, kMeshFile, kPointFile})
    EXPECT_EQ(refusal(bound.most_bytes + 1, bound), file.string() + ": is longer than " +
                                                        std::to_string(bound.most_bytes >> 20) +
                                                        " MiB, the most of " + bound.kind);
  const std::string text_refusal = file.string() + ": is longer than 512 MiB, the most of a text file";
  refusal(std::uintmax_t{1} << 30, kTextFile);
  EXPECT_EQ(input_error([&] { for_each_line(file, [](int, const auto&) {}); }), text_refusal);
  EXPECT_EQ(input_error([&] { read_text(file); }), text_refusal);
  EXPECT_EQ(input_error([&] { ConfigNode::load(file); }),
            file.string() + ": is longer than 16 MiB, the most of a YAML file");
  write_text(file, "");
  fs::resize_file(file, kYamlFile.most_bytes);
  EXPECT_EQ(read_file(file, kYamlFile).size(), kYamlFile.most_bytes);
  EXPECT_EQ(read_file("/proc/self/comm", kTextFile).empty(), false);  // whose size is said to be 0
}

TEST(Files, WriteTextLeavesNoAsideFile) {
  const TempFolder temp;
  write_text(temp.path() / "a.txt", "one");
  write_text(temp.path() / "a.txt", "two");
  EXPECT_EQ(read_text(temp.path() / "a.txt"), "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(temp.path()), {}), 1);
  EXPECT_THROW(write_text(temp.path() / "no/such/folder.txt", "x"), std::runtime_error);
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

TEST(Files, WhatCannotBeWrittenSaysWhy) {
  const TempFolder temp;
  const fs::path file = temp.path() / "file", nowhere = temp.path() / "no/such/file";
  EXPECT_EQ(error_of([&] { write_text(nowhere, "x"); }),
            nowhere.string() + ": cannot be written: No such file or directory");
  fs::create_directory(temp.path() / "folder");
  EXPECT_EQ(error_of([&] { write_text(temp.path() / "folder", "x"); }),
            (temp.path() / "folder").string() + ": cannot be written: Is a directory");
  EXPECT_FALSE(fs::exists(temp.path() / "folder.partial"));
  write_text(file, "before");
  EXPECT_EQ(error_of([&] { duplicate_file(file, nowhere); }),
            nowhere.string() + ": cannot be written: No such file or directory");
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  fs::create_symlink("/dev/full", file.string() + ".partial");  // what it is written to first
  EXPECT_EQ(error_of([&] { write_text(file, "after"); }),
            file.string() + ": cannot be written: No space left on device");
  EXPECT_EQ(read_text(file), "before");
}

}  // namespace
}  // namespace uniquadric
