#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <string>

namespace uniquadric {

/// Which frames are written, with a few lines of text about each: what an interrupted run goes on from. Safe
/// to use from several threads.
class FrameLog {
 public:
  /// Opens or creates the file; a record that was cut off in the middle is dropped.
  explicit FrameLog(const std::filesystem::path& path);

  bool has(std::int64_t frame) const;
  std::int64_t size() const;  ///< frames recorded
  /// Records a frame that is not yet there. `lines` ends with a line feed or is empty.
  void add(std::int64_t frame, const std::string& lines);
  /// All frames' lines in the order of the frames.
  std::string lines() const;

 private:
  std::filesystem::path path_;
  mutable std::mutex mutex_;
  std::map<std::int64_t, std::string> records_;
  std::ofstream out_;
};

}  // namespace uniquadric
