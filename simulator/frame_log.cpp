#include "simulator/frame_log.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/files.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {

// "FRAME NUMBER_OF_LINES" and the lines.
std::string record(std::int64_t frame, const std::string& lines) {
  return fmt::format("{} {}\n{}", frame, std::count(lines.begin(), lines.end(), '\n'), lines);
}

// The first `count` lines of `text` with their line feeds, taken off it; nothing when there are fewer.
std::optional<std::string> take_lines(std::string_view& text, std::int64_t count) {
  std::size_t end = 0;
  for (; count > 0; --count) {
    const std::size_t feed = text.find('\n', end);
    if (feed == std::string_view::npos) return std::nullopt;
    end = feed + 1;
  }
  std::string lines(text.substr(0, end));
  text.remove_prefix(end);
  return lines;
}

std::map<std::int64_t, std::string> parse(std::string_view text) {
  std::map<std::int64_t, std::string> records;
  while (const auto head = take_lines(text, 1)) {
    const std::size_t space = head->find(' ');
    if (space == std::string::npos) break;
    const auto frame = parse_integer(std::string_view(*head).substr(0, space));
    const auto count = parse_integer(std::string_view(*head).substr(space + 1, head->size() - space - 2));
    const auto lines = count ? take_lines(text, *count) : std::nullopt;
    if (!frame || !lines) break;
    records[*frame] = *lines;
  }
  return records;
}

}  // namespace

FrameLog::FrameLog(const std::filesystem::path& path) : path_(path) {
  if (std::filesystem::exists(path)) records_ = parse(read_text(path));
  std::string complete;
  for (const auto& [frame, lines] : records_) complete += record(frame, lines);
  write_text(path, complete);
  out_.open(path, std::ios::binary | std::ios::app);
  if (!out_) throw_unwritable(path);
}

bool FrameLog::has(std::int64_t frame) const {
  const std::lock_guard lock(mutex_);
  return records_.contains(frame);
}

std::int64_t FrameLog::size() const {
  const std::lock_guard lock(mutex_);
  return std::ssize(records_);
}

void FrameLog::add(std::int64_t frame, const std::string& lines) {
  const std::lock_guard lock(mutex_);
  records_[frame] = lines;
  out_ << record(frame, lines) << std::flush;
  if (!out_) throw_unwritable(path_);
}

std::string FrameLog::lines() const {
  const std::lock_guard lock(mutex_);
  std::string all;
  for (const auto& [frame, lines] : records_) all += lines;
  return all;
}

}  // namespace uniquadric
