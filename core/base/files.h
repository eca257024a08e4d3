#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace uniquadric {

/// A whole text file: read_file() with kTextFile.
std::string read_text(const std::filesystem::path& path);

/// Throws std::runtime_error "PATH: cannot be written: REASON", the reason of the system call that just
/// failed (errno).
[[noreturn]] void throw_unwritable(const std::filesystem::path& path);

/// Where write_text writes what is to become `path`; stays behind when the process is killed meanwhile.
std::filesystem::path aside_of(const std::filesystem::path& path);

/// A text file that is written aside, so that it is never seen half-written.
class PendingText {
 public:
  /// Throws throw_unwritable.
  explicit PendingText(const std::filesystem::path& path);
  ~PendingText();  ///< removes what was not kept
  PendingText(const PendingText&) = delete;
  PendingText& operator=(const PendingText&) = delete;

  std::ostream& stream() { return out_; }
  /// Gives the file its name. Throws throw_unwritable where that, or what was written before, failed.
  void keep();

 private:
  std::filesystem::path path_;
  std::ofstream out_;
};

/// Writes a PendingText and keeps it.
void write_text(const std::filesystem::path& path, std::string_view text);

/// As write_text of read_text: what is wrong names the file that it is wrong of.
void duplicate_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// Throws InputError for a link to nothing: neither a place to write to nor a new one.
void require_no_dangling_link(const std::filesystem::path& path);

/// What a file is known by.
struct FileKind {
  std::string_view name = "file";  ///< "picture", as messages call it
  std::string_view begins = "";    ///< its first bytes; none: any file is of this kind
};
constexpr FileKind kJpegFile{"JPEG picture", "\xFF\xD8\xFF"};
constexpr FileKind kPngFile{"PNG picture", "\x89PNG\r\n\x1A\n"};

/// Makes sure that a file can be written at `path` without harm; an empty path is none. Throws InputError for
/// what exists and is not a regular file (a folder, a link, a device, a pipe), for a regular file unless
/// `replace`, and for one with content that does not begin as the files of `kind`.
void require_replaceable_file(const std::filesystem::path& path, bool replace, const FileKind& kind = {});

/// A folder that one process at a time writes, and those forked from it. Holds nothing where there is no such
/// folder.
class FolderLock {
 public:
  /// Waits some seconds for processes that are being killed; throws InputError of `shown` when another
  /// process still holds the folder.
  FolderLock(const std::filesystem::path& folder, const std::filesystem::path& shown);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  /// Whether a process holds the folder now; what cannot be opened counts as held.
  static bool is_held(const std::filesystem::path& folder);

 private:
  int descriptor_;
};

/// Name of the file in a PendingFolder's partial folder, so that nothing of anybody else is taken for one.
inline constexpr const char* kPartialMarker = ".uniquadric_partial";

/// Name of the file that says what a folder of this program is: its kind in one line.
inline constexpr const char* kKindFile = ".uniquadric";

/// The kind of a folder that this program wrote; empty for any other.
std::string kind_of_folder(const std::filesystem::path& folder);

/// A folder that appears under its final name only when complete: work goes to `path()` (a sibling named
/// OUT.partial), `commit()` renames it to OUT, with kKindFile in it. Left uncommitted, the partial folder is
/// removed, unless `keep_partial` asks for it to stay for a later resume.
class PendingFolder {
 public:
  /// Throws InputError when `final_path` exists as anything but an empty folder, unless `replace` is true and
  /// it is a folder of the same `kind`; and when OUT.partial exists and no PendingFolder made it.
  PendingFolder(std::filesystem::path final_path, std::string kind, bool replace, bool keep_partial = false);
  ~PendingFolder();
  PendingFolder(const PendingFolder&) = delete;
  PendingFolder& operator=(const PendingFolder&) = delete;

  const std::filesystem::path& path() const { return partial_; }
  void clear() const;  ///< of what an earlier process left in it
  void commit();

 private:
  bool swap() const;
  std::filesystem::path final_, partial_;
  std::string kind_;
  std::optional<FolderLock> lock_;  // of the partial folder
  bool keep_partial_, committed_ = false;
};

}  // namespace uniquadric
