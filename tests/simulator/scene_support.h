#pragma once

#include <filesystem>
#include <string>

#include "core/base/config.h"
#include "core/base/files.h"
#include "simulator/scene/scene.h"
#include "tests/support/temp_folder.h"

namespace uniquadric::scene_test {

inline const std::filesystem::path kSource = UNIQUADRIC_SOURCE_DIR;
inline const std::filesystem::path kData = kSource.parent_path() / "shared/data";

/// A folder for one test's files, called `name` in a place of its own, removed at its end.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::string& name) : path_(place_.path() / name) {
    std::filesystem::create_directory(path_);
  }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    write_text(path_ / name, text);
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  TempFolder place_;
  std::filesystem::path path_;
};

}  // namespace uniquadric::scene_test
