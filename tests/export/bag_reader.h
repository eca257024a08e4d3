#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace uniquadric {

struct BagMessage {
  std::string topic, type, md5sum, definition;
  bool latching = false;
  std::uint64_t record_ns = 0;
  std::string data;
};

/// All messages of a bag in the order of the file. Written after the definition of the format alone
/// (wiki.ros.org/Bags/Format/2.0): chunks that are not compressed.
std::vector<BagMessage> read_bag(const std::filesystem::path& path);

/// Reads values of a message in turn, little-endian, as ROS serializes them.
class MessageReader {
 public:
  explicit MessageReader(const std::string& data) : data_(data) {}
  template <typename T>
  T next() {
    T value;
    std::memcpy(&value, data_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string text() {  // length first
    const auto size = next<std::uint32_t>();
    at_ += size;
    return data_.substr(at_ - size, size);
  }
  std::vector<double> doubles(std::size_t count) {
    std::vector<double> values;
    for (std::size_t i = 0; i < count; ++i) values.push_back(next<double>());
    return values;
  }
  bool at_end() const { return at_ == data_.size(); }
  /// seq, stamp, frame_id; returns the stamp in ns.
  std::uint64_t header(std::string& frame_id) {
    next<std::uint32_t>();
    const std::uint64_t sec = next<std::uint32_t>(), nsec = next<std::uint32_t>();
    frame_id = text();
    return sec * 1'000'000'000 + nsec;
  }

 private:
  std::string data_;
  std::size_t at_ = 0;
};

}  // namespace uniquadric
