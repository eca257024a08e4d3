#include "core/base/folder_hashes.h"

#include <fmt/format.h>

#include <map>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// hash by relative path, of all files but the list of hashes itself
std::map<std::string, std::string> hash_files(const fs::path& folder) {
  std::map<std::string, std::string> hashes;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).generic_string();
    if (entry.is_regular_file() && name != kHashesFile) hashes[name] = Hash().add_file(entry.path()).hex();
  }
  return hashes;
}

}  // namespace

void write_hashes(const fs::path& folder) {
  std::string text;
  for (const auto& [name, hash] : hash_files(folder)) text += fmt::format("{} {}\n", hash, name);
  write_text(folder / kHashesFile, text);
}

std::vector<std::string> check_hashes(const fs::path& folder) {
  const fs::path list = folder / kHashesFile;
  if (!fs::exists(list)) return {};
  std::vector<std::string> problems;
  std::map<std::string, std::string> files = hash_files(folder);
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
