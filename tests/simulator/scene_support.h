#pragma once

#include <filesystem>
#include <string>

#include "core/base/config.h"
#include "core/base/files.h"
#include "simulator/scene/scene.h"

namespace uniquadric::scene_test {

inline const std::filesystem::path kSource = UNIQUADRIC_SOURCE_DIR;
inline const std::filesystem::path kData = kSource.parent_path() / "shared/data";

/// A folder for one test's files, removed at its end.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::string& name)
      : path_(std::filesystem::temp_directory_path() / ("uniquadric_" + name)) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    write_text(path_ / name, text);
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace uniquadric::scene_test
