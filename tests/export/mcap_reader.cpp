#include "tests/export/mcap_reader.h"

#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

#include "core/base/files.h"

namespace uniquadric {
namespace {

// Values of a record in turn, little-endian.
class Bytes {
 public:
  explicit Bytes(std::string data) : data_(std::move(data)) {}
  template <typename T>
  T next() {
    T value{};
    EXPECT_LE(at_ + sizeof value, data_.size());
    if (at_ + sizeof value <= data_.size()) std::memcpy(&value, data_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string take(std::uint64_t size) {
    EXPECT_LE(at_ + size, data_.size());
    at_ += size;
    return data_.substr(std::min(data_.size(), at_ - size), size);
  }
  std::string text() { return take(next<std::uint32_t>()); }
  std::string rest() { return take(data_.size() - at_); }
  bool at_end() const { return at_ >= data_.size(); }
  std::size_t at() const { return at_; }
  void align(std::size_t size) { at_ = (at_ + size - 1) / size * size; }

 private:
  std::string data_;
  std::size_t at_ = 0;
};

struct Record {
  std::uint8_t opcode = 0;
  std::size_t begin = 0;
  std::string content;
};

std::vector<Record> records_of(const std::string& data) {
  std::vector<Record> records;
  Bytes bytes(data);
  while (!bytes.at_end()) {
    const std::size_t begin = bytes.at();
    const auto opcode = bytes.next<std::uint8_t>();
    records.push_back({opcode, begin, bytes.take(bytes.next<std::uint64_t>())});
  }
  return records;
}

// Types of a definition: lists of "type name".
using Types = std::map<std::string, std::vector<std::pair<std::string, std::string>>>;

Types types_of(const std::string& name, const std::string& definition) {
  Types types;
  std::string type = name, line;
  std::istringstream in(definition);
  while (std::getline(in, line)) {
    if (line.starts_with("=")) continue;
    std::istringstream words(line);
    std::string first, second;
    words >> first >> second;
    if (first == "MSG:")
      type = second, types[type];
    else
      types[type].emplace_back(first, second);
  }
  return types;
}

class CdrDecoder {
 public:
  CdrDecoder(const Types& types, const std::string& data, McapMessage& out)
      : types_(types), bytes_(data.substr(4)), out_(out) {
    EXPECT_EQ(data.substr(0, 4), std::string("\0\1\0\0", 4));
  }
  void decode(const std::string& type, const std::string& path) {
    if (const auto bracket = type.find('['); bracket != std::string::npos)
      decode_array(type.substr(0, bracket), type.substr(bracket + 1, type.size() - bracket - 2), path);
    else if (type == "string")
      out_.texts[path] = text();
    else if (!decode_number(type, path))
      for (const auto& [field, name] : types_.at(type))
        decode(field, path.empty() ? name : path + "." + name);
  }
  bool at_end() const { return bytes_.at_end(); }

 private:
  void decode_array(const std::string& type, const std::string& size, const std::string& path) {
    const std::size_t count = size.empty() ? number<std::uint32_t>() : std::stoul(size);
    if (type == "uint8") {
      out_.texts[path] = bytes_.take(count);
      return;
    }
    out_.numbers[path + ".count"] = static_cast<double>(count);
    for (std::size_t i = 0; i < count; ++i) decode(type, path + "[" + std::to_string(i) + "]");
  }
  template <typename T>
  T number() {
    bytes_.align(sizeof(T));
    return bytes_.next<T>();
  }
  template <typename T>
  bool keep(const std::string& path) {
    out_.numbers[path] = static_cast<double>(number<T>());
    return true;
  }
  bool decode_number(const std::string& type, const std::string& path) {
    if (type == "uint8" || type == "bool") return keep<std::uint8_t>(path);
    if (type == "int32") return keep<std::int32_t>(path);
    if (type == "uint32") return keep<std::uint32_t>(path);
    if (type == "float32") return keep<float>(path);
    return type == "float64" && keep<double>(path);
  }
  std::string text() {
    std::string value = bytes_.take(number<std::uint32_t>());
    EXPECT_TRUE(value.ends_with('\0'));
    value.pop_back();
    return value;
  }

  const Types& types_;
  Bytes bytes_;
  McapMessage& out_;
};

struct Channel {
  std::uint16_t schema = 0;
  std::string topic;
};

struct Described {
  std::map<std::uint16_t, std::pair<std::string, std::string>> schemas;  // name, definition
  std::map<std::uint16_t, Channel> channels;
  bool operator==(const Described& other) const {
    return schemas == other.schemas && channels.size() == other.channels.size();
  }
  bool take(const Record& record) {
    Bytes bytes(record.content);
    const auto id = bytes.next<std::uint16_t>();
    if (record.opcode == 3) {
      const std::string name = bytes.text();
      EXPECT_EQ(bytes.text(), "ros2msg");
      schemas[id] = {name, bytes.text()};
    } else if (record.opcode == 4) {
      const auto schema = bytes.next<std::uint16_t>();
      EXPECT_TRUE(schemas.contains(schema));
      channels[id] = {schema, bytes.text()};
      EXPECT_EQ(bytes.text(), "cdr");
    }
    return record.opcode == 3 || record.opcode == 4;
  }
};

McapMessage message_of(const Described& described, const Record& record) {
  Bytes bytes(record.content);
  const Channel& channel = described.channels.at(bytes.next<std::uint16_t>());
  const auto& [name, definition] = described.schemas.at(channel.schema);
  bytes.next<std::uint32_t>();
  McapMessage message{channel.topic, name, bytes.next<std::uint64_t>(), {}, {}};
  bytes.next<std::uint64_t>();
  const Types types = types_of(name, definition);
  CdrDecoder decoder(types, bytes.rest(), message);
  decoder.decode(name, "");
  EXPECT_TRUE(decoder.at_end()) << name;
  return message;
}

}  // namespace

std::vector<McapMessage> read_mcap(const std::filesystem::path& path) {
  const std::string data = read_text(path), magic = "\x89MCAP0\r\n";
  EXPECT_TRUE(data.starts_with(magic) && data.ends_with(magic));
  std::vector<McapMessage> messages;
  Described inside, summary;
  std::string chunk;
  std::uint64_t indexed = 0, chunks = 0, counted = 0, summary_start = 0, data_end = 0;
  const std::string body = data.substr(magic.size(), data.size() - 2 * magic.size());
  for (const Record& record : records_of(body)) {
    const std::size_t begin = record.begin + magic.size();
    Bytes bytes(record.content);
    if (record.opcode == 1) {
      EXPECT_EQ(bytes.text(), "ros2");
    } else if (record.opcode == 6) {
      const auto first = bytes.next<std::uint64_t>(), last = bytes.next<std::uint64_t>();
      const auto size = bytes.next<std::uint64_t>();
      bytes.next<std::uint32_t>();
      EXPECT_EQ(bytes.text(), "");
      EXPECT_EQ(bytes.next<std::uint64_t>(), size);
      chunk = bytes.rest();
      EXPECT_EQ(chunk.size(), size);
      for (const Record& inner : records_of(chunk)) {
        if (inside.take(inner)) continue;
        messages.push_back(message_of(inside, inner));
        EXPECT_GE(messages.back().time_ns, first);
        EXPECT_LE(messages.back().time_ns, last);
      }
    } else if (record.opcode == 7) {
      const auto channel = bytes.next<std::uint16_t>();
      bytes.next<std::uint32_t>();
      while (!bytes.at_end()) {
        const auto time = bytes.next<std::uint64_t>(), place = bytes.next<std::uint64_t>();
        Bytes indexed_record(chunk.substr(place));
        EXPECT_EQ(indexed_record.next<std::uint8_t>(), 5);
        indexed_record.next<std::uint64_t>();
        EXPECT_EQ(indexed_record.next<std::uint16_t>(), channel);
        indexed_record.next<std::uint32_t>();
        EXPECT_EQ(indexed_record.next<std::uint64_t>(), time);
        ++indexed;
      }
    } else if (record.opcode == 8) {
      bytes.next<std::uint64_t>(), bytes.next<std::uint64_t>();
      EXPECT_EQ(static_cast<int>(data.at(bytes.next<std::uint64_t>())), 6);
      ++chunks;
    } else if (record.opcode == 0x0b) {
      counted = bytes.next<std::uint64_t>();
      EXPECT_EQ(bytes.next<std::uint16_t>(), summary.schemas.size());
      EXPECT_EQ(bytes.next<std::uint32_t>(), summary.channels.size());
    } else if (record.opcode == 0x0f) {
      data_end = begin + 9 + record.content.size();
    } else if (record.opcode == 2) {
      summary_start = bytes.next<std::uint64_t>();
    } else {
      EXPECT_TRUE(summary.take(record)) << int{record.opcode};
    }
  }
  EXPECT_EQ(summary_start, data_end);
  EXPECT_EQ(indexed, messages.size());
  EXPECT_EQ(counted, messages.size());
  EXPECT_GT(chunks, 0u);
  EXPECT_TRUE(summary == inside);
  return messages;
}

}  // namespace uniquadric
