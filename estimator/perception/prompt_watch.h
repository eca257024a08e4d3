#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace uniquadric {

/// Which of the user's prompts led to a mask. Thread-safe.
class PromptWatch {
 public:
  /// `ids_last`: ids name objects over the frames; else each prompt is an object of its own.
  PromptWatch(std::filesystem::path prompts, bool ids_last)
      : prompts_(std::move(prompts)), ids_last_(ids_last) {}

  /// A prompt at a stamp, as messages name it: "point (3, 4)".
  void expect(std::int64_t stamp_ns, int id, const std::string& name);
  void found(std::int64_t stamp_ns, int id);

  /// A line for each object of whose prompts none led to a mask, a few of them at most.
  std::vector<std::string> faults() const;

 private:
  using Key = std::pair<std::int64_t, int>;  // stamp (0 where ids last), id
  Key key_of(std::int64_t stamp_ns, int id) const { return {ids_last_ ? 0 : stamp_ns, id}; }

  struct Expected {
    std::int64_t first_ns = 0;
    std::string name;  // of the first
    int count = 0;
    bool found = false;
  };

  std::filesystem::path prompts_;
  bool ids_last_;
  std::map<Key, Expected> expected_;
  mutable std::mutex mutex_;
};

}  // namespace uniquadric
