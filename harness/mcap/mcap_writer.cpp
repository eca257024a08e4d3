#include "harness/mcap/mcap_writer.h"

#include <cerrno>
#include <cstring>
#include <string_view>

#include "core/base/error.h"
#include "core/base/files.h"

namespace uniquadric {
namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
constexpr std::size_t kChunkSize = 4 << 20;  // ours: what a reader loads to jump to a time

enum Opcode : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kStatistics = 0x0b,
  kDataEnd = 0x0f,
};

template <typename T>
void number(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void text(std::string& bytes, std::string_view value) {
  number(bytes, static_cast<std::uint32_t>(value.size()));
  bytes.append(value);
}

// What stands before a record's content.
void begin_record(std::string& bytes, Opcode opcode, std::size_t size) {
  bytes.push_back(static_cast<char>(opcode));
  number(bytes, static_cast<std::uint64_t>(size));
}

std::string record(Opcode opcode, std::string_view content) {
  std::string bytes;
  begin_record(bytes, opcode, content.size());
  bytes.append(content);
  return bytes;
}

std::string schema_record(std::uint16_t id, const McapSchema& schema) {
  std::string content;
  number(content, id);
  text(content, schema.name);
  text(content, "ros2msg");
  text(content, schema.definition);
  return record(kSchema, content);
}

std::string channel_record(std::uint16_t id, std::uint16_t schema, std::string_view topic) {
  std::string content;
  number(content, id);
  number(content, schema);
  text(content, topic);
  text(content, "cdr");
  text(content, "");  // no metadata
  return record(kChannel, content);
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& path) : path_(path), out_(path, std::ios::binary) {
  std::string header;
  text(header, "ros2");
  text(header, "uniquadric");
  put(std::string(kMagic) + record(kHeader, header));
}

void McapWriter::put(const std::string& bytes) {
  if (!out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()))) throw_unwritable(path_);
  size_ += bytes.size();
}

McapWriter::Channel& McapWriter::channel_of(const std::string& topic, const McapSchema& schema) {
  const auto [place, is_new] = channels_.try_emplace(topic);
  Channel& channel = place->second;
  if (!is_new) return channel;
  channel.id = static_cast<std::uint16_t>(channels_.size());
  const auto known = schemas_.try_emplace(schema.name, static_cast<std::uint16_t>(schemas_.size() + 1));
  const std::uint16_t schema_id = known.first->second;
  std::string records = known.second ? schema_record(schema_id, schema) : "";
  records += channel_record(channel.id, schema_id, topic);
  chunk_.records += records;
  summary_ += records;
  return channel;
}

void McapWriter::write(const std::string& topic, const McapSchema& schema, std::int64_t time_ns,
                       const std::string& message) {
  Channel& channel = channel_of(topic, schema);
  const auto time = static_cast<std::uint64_t>(time_ns);
  std::string head;
  number(head, channel.id);
  number(head, static_cast<std::uint32_t>(channel.messages));
  number(head, time);
  number(head, time);
  if (chunk_.index.empty()) chunk_.first_ns = time;
  chunk_.last_ns = time;
  chunk_.index[channel.id].emplace_back(time, chunk_.records.size());
  begin_record(chunk_.records, kMessage, head.size() + message.size());
  chunk_.records += head;
  chunk_.records += message;
  if (messages_ == 0) first_ns_ = time;
  last_ns_ = time;
  ++channel.messages;
  ++messages_;
  if (chunk_.records.size() > kChunkSize) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.index.empty()) return;
  const std::uint64_t begin = size_, length = chunk_.records.size();
  std::string head, begun;
  number(head, chunk_.first_ns);
  number(head, chunk_.last_ns);
  number(head, length);
  number(head, std::uint32_t{0});  // no checksum
  text(head, "");                  // no compression
  number(head, length);
  begin_record(begun, kChunk, head.size() + length);
  put(begun + head);
  put(chunk_.records);
  const std::uint64_t chunk_length = size_ - begin;
  std::string places;
  for (const auto& [channel, messages] : chunk_.index) {
    number(places, channel);
    number(places, size_);
    std::string index, entries;
    for (const auto& [time, place] : messages) {
      number(entries, time);
      number(entries, place);
    }
    number(index, channel);
    text(index, entries);
    put(record(kMessageIndex, index));
  }
  std::string index;
  number(index, chunk_.first_ns);
  number(index, chunk_.last_ns);
  number(index, begin);
  number(index, chunk_length);
  text(index, places);
  number(index, size_ - begin - chunk_length);
  text(index, "");
  number(index, length);
  number(index, length);
  chunk_indexes_ += record(kChunkIndex, index);
  ++chunks_;
  chunk_ = {};
}

void McapWriter::close() {
  end_chunk();
  put(record(kDataEnd, std::string(4, '\0')));
  const std::uint64_t summary = size_;
  std::string counts, statistics;
  for (const auto& [topic, channel] : channels_) {
    number(counts, channel.id);
    number(counts, channel.messages);
  }
  put(summary_ + chunk_indexes_);
  number(statistics, messages_);
  number(statistics, static_cast<std::uint16_t>(schemas_.size()));
  number(statistics, static_cast<std::uint32_t>(channels_.size()));
  number(statistics, std::uint32_t{0});  // attachments
  number(statistics, std::uint32_t{0});  // metadata
  number(statistics, chunks_);
  number(statistics, first_ns_);
  number(statistics, last_ns_);
  text(statistics, counts);
  put(record(kStatistics, statistics));
  std::string footer;
  number(footer, summary);
  number(footer, std::uint64_t{0});  // no offsets within the summary
  number(footer, std::uint32_t{0});  // no checksum
  put(record(kFooter, footer) + std::string(kMagic));
  if (!out_.flush()) throw_unwritable(path_);
  out_.close();
}

}  // namespace uniquadric
