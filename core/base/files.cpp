#include "core/base/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/read_file.h"

namespace uniquadric {
namespace fs = std::filesystem;

std::string read_text(const fs::path& path) {
  return read_file(path, kTextFile);
}

void throw_unwritable(const fs::path& path) {
  throw InputError(path, fmt::format("cannot be written: {}", std::strerror(errno)));
}

fs::path aside_of(const fs::path& path) {
  return path.string() + ".partial";
}

PendingText::PendingText(const fs::path& path) : path_(path), out_(aside_of(path), std::ios::binary) {
  if (!out_) throw_unwritable(path);
}

PendingText::~PendingText() {
  if (path_.empty()) return;
  std::error_code ignored;
  fs::remove(aside_of(path_), ignored);
}

void PendingText::keep() {
  const fs::path path = std::exchange(path_, fs::path()), aside = aside_of(path);
  out_.close();
  int reason = errno;  // before what follows can change it
  std::error_code error, ignored;
  if (out_) {
    fs::rename(aside, path, error);  // fails where a folder has the name
    if (!error) return;
    reason = error.value();
  }
  fs::remove(aside, ignored);
  errno = reason;
  throw_unwritable(path);
}

void write_text(const fs::path& path, std::string_view text) {
  PendingText file(path);
  file.stream().write(text.data(), static_cast<std::streamsize>(text.size()));
  file.keep();
}

void duplicate_file(const fs::path& from, const fs::path& to) {
  write_text(to, read_file(from, kPointFile));
}

void require_no_dangling_link(const fs::path& path) {
  std::error_code error;
  if (fs::is_symlink(path, error) && !fs::exists(path, error))
    throw InputError(path,
                     fmt::format("is a link to {}, which does not exist", fs::read_symlink(path).string()));
}

namespace {
bool is_of(const FileKind& kind, const fs::path& path) {
  std::string begins(kind.begins.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(begins.data(), static_cast<std::streamsize>(begins.size()));
  return begins == kind.begins;
}
}  // namespace

void require_replaceable_file(const fs::path& path, bool replace, const FileKind& kind) {
  if (path.empty()) return;
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (!fs::exists(status)) return;
  if (!fs::is_regular_file(status)) throw InputError(path, "exists and is not a regular file");
  if (!replace) throw InputError(path, "exists; give another name or --force");
  if (fs::file_size(path, error) > 0 && !is_of(kind, path))
    throw InputError(path, fmt::format("is no {}, so --force does not replace it", kind.name));
}

std::string kind_of_folder(const fs::path& folder) {
  if (!fs::is_regular_file(folder / kKindFile)) return "";
  std::string kind;
  std::ifstream(folder / kKindFile) >> kind;
  return kind;
}

namespace {
// Only what this program wrote may be deleted, and only for what takes its place.
void require_kind(const fs::path& folder, const std::string& kind) {
  const std::string found = kind_of_folder(folder);
  if (found.empty())
    throw InputError(folder, "was not written by this program, so --force does not replace it");
  if (found != kind)
    throw InputError(folder,
                     fmt::format("holds another kind of result ({}, not {}), so --force does not replace it",
                                 found, kind));
}

// A killed process' children are killed after it, and hold its locks until they are gone.
constexpr auto kLongestDeath = std::chrono::seconds(3);  // ours: they take milliseconds on an idle machine
constexpr auto kBetweenTries = std::chrono::milliseconds(5);

bool lock_within(int descriptor, std::chrono::steady_clock::duration limit) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(kBetweenTries);
  }
  return true;
}

// Whether the open folder still has that name: who had it may have renamed it when it was done.
bool is_open_as(int descriptor, const fs::path& folder) {
  struct stat open_one, named;
  return fstat(descriptor, &open_one) == 0 && stat(folder.c_str(), &named) == 0 &&
         open_one.st_ino == named.st_ino && open_one.st_dev == named.st_dev;
}

// A name beside `path` that nothing has.
fs::path unused_beside(const fs::path& path) {
  for (int i = 0;; ++i)
    if (fs::path other = fmt::format("{}.old{}", path.string(), i); !fs::exists(fs::symlink_status(other)))
      return other;
}

fs::path without_trailing_slash(fs::path path) {
  return path.has_filename() ? path : path.parent_path();
}

void remove_but_marker(const fs::path& partial) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(partial, ignored))
    if (entry.path().filename() != kPartialMarker) fs::remove_all(entry.path(), ignored);
}

// The marker last: what is killed meanwhile leaves a folder that is still known for a partial one.
void remove_partial(const fs::path& partial) {
  remove_but_marker(partial);
  std::error_code ignored;
  fs::remove_all(partial, ignored);
}
}  // namespace

FolderLock::FolderLock(const fs::path& folder, const fs::path& shown)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0 || (lock_within(descriptor_, kLongestDeath) && is_open_as(descriptor_, folder))) return;
  close(descriptor_);
  throw InputError(shown, "is being written by another process");
}

bool FolderLock::is_held(const fs::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return true;
  const bool is_free = flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  close(descriptor);
  return !is_free;
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

PendingFolder::PendingFolder(fs::path final_path, std::string kind, bool replace, bool keep_partial)
    : final_(without_trailing_slash(std::move(final_path))),
      partial_(final_.string() + ".partial"),
      kind_(std::move(kind)),
      keep_partial_(keep_partial) {
  std::error_code error;
  if (final_.empty()) throw InputError("the output folder has no name");
  require_no_dangling_link(final_);
  if (fs::exists(final_) && !fs::is_directory(final_)) throw InputError(final_, "exists and is not a folder");
  if (fs::exists(final_) && !fs::is_empty(final_)) {
    if (!replace) throw InputError(final_, "exists and is not empty; give another folder or --force");
    require_kind(final_, kind_);
  }
  if (fs::exists(partial_) && !fs::exists(partial_ / kPartialMarker) &&
      !(fs::is_directory(partial_) && fs::is_empty(partial_)))
    throw InputError(partial_, fmt::format("is in the way of {}, and nothing that was left behind; move it",
                                           final_.filename().string()));
  if (!keep_partial_) {
    const FolderLock others(partial_, final_);
    remove_partial(partial_);
  }
  fs::create_directories(partial_, error);
  if (error) throw InputError(final_, fmt::format("cannot be created: {}", error.message()));
  lock_.emplace(partial_, final_);
  if (!std::ofstream(partial_ / kPartialMarker))
    throw_unwritable(partial_);  // at once: it is empty or has it
  leave_when_interrupted(
      keep_partial_
          ? fmt::format("what is done is kept in {}: the same command goes on with it", partial_.string())
          : fmt::format("{} is left, which the same command clears away", partial_.string()));
}

PendingFolder::~PendingFolder() {
  leave_when_interrupted("");
  if (!committed_ && !keep_partial_) remove_partial(partial_);
}

void PendingFolder::clear() const {
  remove_but_marker(partial_);
}

// Swapped where the file system can, so that a reader sees the old folder or the new one and what is killed
// leaves a partial folder, known by its marker, and nothing else.
bool PendingFolder::swap() const {
  if (fs::is_symlink(final_)) return false;  // the link is replaced; what it points to is left as it is
  std::ofstream(final_ / kPartialMarker).close();
  if (renameat2(AT_FDCWD, partial_.c_str(), AT_FDCWD, final_.c_str(), RENAME_EXCHANGE) != 0) return false;
  remove_partial(partial_);
  return true;
}

void PendingFolder::commit() {
  write_text(partial_ / kKindFile, kind_ + "\n");
  if (!fs::exists(final_)) {
    fs::rename(partial_, final_);
  } else if (!swap()) {
    const fs::path old = unused_beside(final_);
    fs::rename(final_, old);
    fs::rename(partial_, final_);
    fs::remove_all(old);
  }
  fs::remove(final_ / kPartialMarker);
  committed_ = true;
}

}  // namespace uniquadric
