#include "fuzz/target.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "core/base/error.h"
#include "core/base/files.h"

namespace uniquadric::fuzz {
namespace {
namespace fs = std::filesystem;

std::map<std::string, Target>& registered() {
  static std::map<std::string, Target> targets;
  return targets;
}

// Of this process alone, removed at its end.
struct MemoryFolder {
  fs::path path;
  MemoryFolder() {
    std::string pattern = "/dev/shm/uniquadric-fuzz-XXXXXX";
    if (!mkdtemp(pattern.data())) throw_unwritable(pattern);
    path = pattern;
  }
  ~MemoryFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

void write(const fs::path& file, std::string_view bytes) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

Target::Target(const std::string& name, std::string file, Read read)
    : name_(name), file_(std::move(file)), read_(std::move(read)) {
  registered().emplace(name, *this);
}

const std::map<std::string, Target>& Target::all() {
  return registered();
}

std::string Target::feed(std::string_view bytes) const {
  static const MemoryFolder memory;
  const fs::path file = memory.path / name_ / file_;
  write(file, bytes);
  try {
    read_(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void beside(const fs::path& file, const std::string& name, std::string_view text) {
  const fs::path other = file.parent_path() / name;
  if (!fs::exists(other)) write(other, text);
}

}  // namespace uniquadric::fuzz
