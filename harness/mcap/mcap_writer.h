#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace uniquadric {

/// A message type: its name, as `sensor_msgs/msg/Imu`, and its definition with those that it uses.
struct McapSchema {
  std::string name, definition;
};

/// Writes an MCAP file of ROS 2 messages (https://mcap.dev/spec: profile `ros2`, encodings `ros2msg` and
/// `cdr`): chunks without compression, each with its index, and a summary, as `ros2 bag play` and Foxglove
/// want them.
class McapWriter {
 public:
  /// Throws InputError when the file cannot be written, as all its members do.
  explicit McapWriter(const std::filesystem::path& path);

  /// `time_ns`: not before that of the last message. A topic always has the same type.
  void write(const std::string& topic, const McapSchema& schema, std::int64_t time_ns,
             const std::string& message);
  /// Nothing may be written afterwards. Without it the file is none.
  void close();

 private:
  struct Channel {
    std::uint16_t id = 0;
    std::uint64_t messages = 0;
  };
  struct Chunk {
    std::string records;
    std::uint64_t first_ns = 0, last_ns = 0;
    std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> index;  // times and places
  };

  Channel& channel_of(const std::string& topic, const McapSchema& schema);
  void end_chunk();
  void put(const std::string& bytes);

  std::filesystem::path path_;
  std::ofstream out_;
  std::uint64_t size_ = 0;
  std::map<std::string, std::uint16_t> schemas_;
  std::map<std::string, Channel> channels_;
  Chunk chunk_;
  std::string summary_, chunk_indexes_;  // summary: schemas and channels
  std::uint32_t chunks_ = 0;
  std::uint64_t messages_ = 0, first_ns_ = 0, last_ns_ = 0;
};

}  // namespace uniquadric
