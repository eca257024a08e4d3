#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace uniquadric {

/// Bad input from outside, or a machine that lacks something, as a library or space on a disk: what the user
/// can mend. Thrown once at the edge, ends the program with exit code 2 and one line. All other exceptions
/// are faults of the program, or memory that ran out: exit code 3.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// "PATH: what"
  InputError(const std::filesystem::path& path, const std::string& what);
  /// "PATH:LINE: what", lines counted from 1
  InputError(const std::filesystem::path& path, int line, const std::string& what);
};

}  // namespace uniquadric
