#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace uniquadric::fuzz {

/// A reader of files as the fuzzer and the test of the corpora drive it: bytes become a file in memory, which
/// it reads. Anything that leaves it but an InputError is a finding.
class Target {
 public:
  using Read = std::function<void(const std::filesystem::path& file)>;

  /// Enters the target in all(). `file`: name the bytes go by, what else the reader wants lies beside it.
  Target(const std::string& name, std::string file, Read read);

  /// Why the reader refused the bytes; empty: it did not.
  std::string feed(std::string_view bytes) const;

  static const std::map<std::string, Target>& all();

 private:
  std::string name_, file_;
  Read read_;
};

/// Writes a file that a reader wants beside the one it is fed, once.
void beside(const std::filesystem::path& file, const std::string& name, std::string_view text);

}  // namespace uniquadric::fuzz
