#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/files.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {

namespace fs = std::filesystem;

/// The program in a folder of the test's own.
class Cli : public testing::Test {
 protected:
  const fs::path& folder() const { return temp_.path(); }
  fs::path out() const { return folder() / "out"; }
  fs::path write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder() / name).parent_path());
    write_text(folder() / name, text);
    return folder() / name;
  }
  void expect_refusal(const std::vector<std::string>& arguments, const std::string& what) const {
    expect_refused(run_program(arguments), what);
    EXPECT_FALSE(fs::exists(out()));
    for (const auto& entry : fs::directory_iterator(folder()))
      EXPECT_FALSE(entry.path().string().ends_with(".partial")) << entry.path();
  }
  // The small scene with `find` replaced; the error must stand at the end of the replacement, or
  // `lines_after`.
  void expect_scene_refused(const std::string& find, const std::string& by, const std::string& what,
                            int lines_after = 0) const {
    std::string text = small_scene_yaml();
    const std::size_t begin = text.find(find);
    ASSERT_NE(begin, std::string::npos);
    text.replace(begin, find.size(), by);
    const fs::path scene = write("scene.yaml", text);
    const auto end = static_cast<std::ptrdiff_t>(begin + by.size());
    const auto line = std::count(text.begin(), text.begin() + end, '\n') + 1 + lines_after;
    expect_refusal({"simulate", scene, out()}, scene.string() + ":" + std::to_string(line) + ": " + what);
  }

 private:
  TempFolder temp_;
};

}  // namespace uniquadric
