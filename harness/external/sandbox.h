#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace uniquadric {

/// What a program sees when it is isolated: the system (/usr, /etc, ...), read only, and what is named here.
/// This program and its scenes are hidden, where they are
/// installed: they would make the truth anew. It has no network, its own processes alone, and writes to `out`
/// and to `scratch` (its /tmp and /dev/shm).
struct Sandbox {
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>> readable;  ///< outside, inside
  std::filesystem::path out, scratch;                                             ///< folders outside
  std::filesystem::path folder;                                                   ///< inside, that it runs in
  bool gpu = false;
};

/// Where the sandbox has its parts.
inline constexpr const char* kInsideSequence = "/sequence";
inline constexpr const char* kInsideOut = "/out";
inline constexpr const char* kInsidePrompt = "/prompt";

/// Whether a path lies in a folder of the system, which every program sees. Needs an existing path.
bool is_in_system(const std::filesystem::path& path);

/// Whether bubblewrap is installed and may make a sandbox here.
bool can_isolate();

/// The command run in the sandbox, by bubblewrap (bwrap).
std::vector<std::string> isolated(const std::vector<std::string>& command, const Sandbox& sandbox);

}  // namespace uniquadric
