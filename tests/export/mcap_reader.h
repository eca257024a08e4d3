#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace uniquadric {

/// A message as its own file describes it: numbers and texts by path, as "transforms[0].header.frame_id"; of
/// a sequence of bytes its text, of other sequences their count under "PATH.count".
struct McapMessage {
  std::string topic, type;
  std::uint64_t time_ns = 0;
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> texts;
};

/// All messages of a file in its order. Written after https://mcap.dev/spec and CDR alone: chunks without
/// compression. Fails the test where indexes, summary or statistics do not fit, or a definition leaves bytes
/// of a message over.
std::vector<McapMessage> read_mcap(const std::filesystem::path& path);

}  // namespace uniquadric
