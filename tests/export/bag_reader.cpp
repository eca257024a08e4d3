#include "tests/export/bag_reader.h"

#include <gtest/gtest.h>

#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {

using Fields = std::map<std::string, std::string>;

struct Record {
  Fields header;
  std::string data;
};

std::uint32_t u32(const std::string& bytes, std::size_t at) {
  std::uint32_t value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

Fields read_fields(const std::string& bytes) {
  Fields fields;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::uint32_t size = u32(bytes, at);
    const std::string field = bytes.substr(at + 4, size);
    const std::size_t equals = field.find('=');
    fields[field.substr(0, equals)] = field.substr(equals + 1);
    at += 4 + size;
  }
  return fields;
}

std::vector<Record> read_records(const std::string& bytes, std::size_t at) {
  std::vector<Record> records;
  while (at < bytes.size()) {
    const std::uint32_t header = u32(bytes, at), data = u32(bytes, at + 4 + header);
    records.push_back({read_fields(bytes.substr(at + 4, header)), bytes.substr(at + 8 + header, data)});
    at += 8 + header + data;
  }
  EXPECT_EQ(at, bytes.size());
  return records;
}

}  // namespace

std::vector<BagMessage> read_bag(const std::filesystem::path& path) {
  const std::string bytes = bytes_of(path), magic = "#ROSBAG V2.0\n";
  EXPECT_EQ(bytes.substr(0, magic.size()), magic);
  std::map<std::string, BagMessage> connections;  // by the bytes of their number
  std::vector<BagMessage> messages;
  for (const Record& chunk : read_records(bytes, magic.size())) {
    if (chunk.header.at("op") != "\x05") continue;
    EXPECT_EQ(chunk.header.at("compression"), "none");
    for (const Record& record : read_records(chunk.data, 0)) {
      const std::string& connection = record.header.at("conn");
      if (record.header.at("op") == "\x07") {
        Fields fields = read_fields(record.data);
        connections[connection] = {record.header.at("topic"),
                                   fields["type"],
                                   fields["md5sum"],
                                   fields["message_definition"],
                                   fields["latching"] == "1",
                                   0,
                                   ""};
      } else if (record.header.at("op") == "\x02") {
        messages.push_back(connections.at(connection));
        const std::string& time = record.header.at("time");
        messages.back().record_ns = std::uint64_t{u32(time, 0)} * 1'000'000'000 + u32(time, 4);
        messages.back().data = record.data;
      }
    }
  }
  return messages;
}

}  // namespace uniquadric
