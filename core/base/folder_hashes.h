#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace uniquadric {

/// Name of the file that holds the hashes of all others of its folder.
inline constexpr const char* kHashesFile = "hashes.txt";

/// Writes `hashes.txt` into a folder: a line `hash  path` for every other file below it, in order of their
/// paths, which are relative to the folder; the hash is hash_file(path), the layout that of `xxh64sum`, which
/// can check it too. `threads`: 0, as many as the machine has.
void write_hashes(const std::filesystem::path& folder, int threads = 0);

/// The text of such a list of all files below a folder but hashes.txt.
std::string list_hashes(const std::filesystem::path& folder, int threads = 0);

/// Whether a folder still holds every file of such a list, with the same bytes; more files do not count. An
/// empty list is no list.
bool holds_all_of(std::string_view list, const std::filesystem::path& folder);

/// Throws InputError for the first text file (TUM, CSV, YAML, lists) that differs from, or does not stand in,
/// the folder's hashes.txt, or is missing; nothing where there is no such list. Images and scans are not
/// read: `info
/// --check` does that.
void require_unchanged_texts(const std::filesystem::path& folder);

/// What has changed in a folder since: a line each for files that differ, are missing, or came since, and for
/// lines of hashes.txt that cannot be read. None when there is no hashes.txt.
std::vector<std::string> check_hashes(const std::filesystem::path& folder, int threads = 0);

}  // namespace uniquadric
