#include "core/base/folder_hashes.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/text.h"
#include "core/base/threads.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
constexpr std::size_t kHashDigits = 16, kNameColumn = kHashDigits + 2;  // of a line: hash, two blanks, path

// Paths below the folder of all files but the list of hashes itself and the marks of what the folder is.
std::vector<std::string> list_files(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(folder).generic_string());
  for (const char* own : {kHashesFile, kPartialMarker, kKindFile}) std::erase(names, own);
  return names;
}

// Hash by path below the folder.
std::map<std::string, std::string> hash_files(const fs::path& folder, int threads) {
  const std::vector<std::string> names = list_files(folder);
  std::vector<std::uint64_t> hashes(names.size());
  tbb::task_arena arena(threads_to_use(threads));
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, names.size(),
                      [&](std::size_t i) { hashes[i] = hash_file(folder / names[i]); });
  });
  std::map<std::string, std::string> hash_of;
  for (std::size_t i = 0; i < names.size(); ++i) hash_of[names[i]] = hex(hashes[i]);
  return hash_of;
}

}  // namespace

std::string list_hashes(const fs::path& folder, int threads) {
  std::string text;
  for (const auto& [name, hash] : hash_files(folder, threads)) text += fmt::format("{}  {}\n", hash, name);
  return text;
}

void write_hashes(const fs::path& folder, int threads) {
  const fs::path list = folder / kHashesFile;
  fs::remove(aside_of(list));  // of a call that was killed while it wrote: no file of the folder's own
  write_text(list, list_hashes(folder, threads));
}

bool holds_all_of(std::string_view list, const fs::path& folder) {
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t end = std::min(list.find('\n', begin), list.size());
    const std::string_view line = list.substr(begin, end - begin);
    if (line.size() <= kNameColumn) return false;  // the list itself is damaged
    const fs::path file = folder / line.substr(kNameColumn);
    if (!fs::is_regular_file(file) || hex(hash_file(file)) != line.substr(0, kHashDigits)) return false;
    begin = end + 1;
  }
  return !list.empty();
}

void require_unchanged_texts(const fs::path& folder) {
  static const std::set<std::string> kTexts = {".tum", ".csv", ".yaml", ".txt"};
  const fs::path list = folder / kHashesFile;
  if (!fs::exists(list)) return;
  std::set<std::string> listed;
  for_each_line(list, [&](int line, const std::vector<std::string_view>& fields) {
    if (fields.size() != 2) throw InputError(list, line, "expected: hash path");
    listed.emplace(fields[1]);
    const fs::path file = folder / fields[1];
    if (!kTexts.contains(file.extension().string())) return;
    if (!fs::is_regular_file(file))
      throw InputError(file, fmt::format("is missing, but stands in {}", kHashesFile));
    if (hex(hash_file(file)) != fields[0])
      throw InputError(
          file, fmt::format("is not as {} says: it was edited or damaged; --no-verify takes it as it is",
                            kHashesFile));
  });
  for (const std::string& name : list_files(folder))
    if (kTexts.contains(fs::path(name).extension().string()) && !listed.contains(name))
      throw InputError(folder / name,
                       fmt::format("does not stand in {}; --no-verify takes it as it is", kHashesFile));
}

std::vector<std::string> check_hashes(const fs::path& folder, int threads) {
  const fs::path list = folder / kHashesFile;
  if (!fs::exists(list)) return {};
  std::vector<std::string> problems;
  std::map<std::string, std::string> files = hash_files(folder, threads);
  for_each_line(list, [&](int line, const std::vector<std::string_view>& fields) {
    if (fields.size() != 2) {
      problems.push_back(fmt::format("{}:{}: expected: hash path", list.string(), line));
      return;
    }
    const auto found = files.find(std::string(fields[1]));
    const std::string path = (folder / fields[1]).string();
    if (found == files.end())
      problems.push_back(fmt::format("{}: is missing, but stands in {}", path, kHashesFile));
    else if (found->second != fields[0])
      problems.push_back(
          fmt::format("{}: has changed: its hash is {}, was {}", path, found->second, fields[0]));
    if (found != files.end()) files.erase(found);
  });
  for (const auto& [name, hash] : files)
    problems.push_back(fmt::format("{}: does not stand in {}", (folder / name).string(), kHashesFile));
  return problems;
}

}  // namespace uniquadric
