#include "evaluation/strict_json_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "core/base/error.h"
#include "core/base/files.h"

namespace uniquadric {
namespace {
using nlohmann::json;

constexpr std::size_t kMostFileBytes = 64 << 20;  // ours
constexpr int kMostFileLevels = 64;               // ours: as of YAML, whose variants stand in it
constexpr double kMostId = 9007199254740991;      // 2^53 - 1: no other whole number rounds to the same double

// Goes through a text and tells another how far it has come: the parser says it of its own errors alone.
class TellingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  TellingIterator(const char* at, const char** told) : at_(at), told_(told) {}
  reference operator*() const { return *at_; }
  TellingIterator& operator++() {
    *told_ = at_++;
    return *this;
  }
  TellingIterator operator++(int) {
    const TellingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const TellingIterator& other) const { return at_ == other.at_; }

 private:
  const char* at_;
  const char** told_;
};

class StrictParser {
 public:
  StrictParser(const std::string& text, int most_levels)
      : text_(text), told_(text.data()), counted_(text.data()), most_levels_(most_levels) {}

  json parse() {
    try {
      return json::parse(TellingIterator(text_.data(), &told_),
                         TellingIterator(text_.data() + text_.size(), &told_),
                         [this](int depth, json::parse_event_t event, const json& value) {
                           if (depth > most_levels_)
                             fail(line(), fmt::format("is nested more than {} levels deep", most_levels_));
                           take(event, value);
                           return true;
                         });
    } catch (const json::parse_error&) {
      throw JsonFault("is not valid JSON", line(), true);
    } catch (const json::out_of_range&) {
      const std::string where = path();
      throw JsonFault((where.empty() ? "" : where + " ") + "holds a number that no double can", line(),
                      false);
    }
  }

 private:
  struct Object {
    std::set<std::string> keys;
    std::string key;  // whose value comes next
    int key_line = 1;
  };

  // Of the value that is being read, as "gt.c": the keys around it.
  std::string path() const {
    std::string path;
    for (const Object& object : open_)
      if (!object.key.empty()) path += (path.empty() ? "" : ".") + object.key;
    return path;
  }

  // That of the last character taken. Counted on from the last time: it is asked for at every key.
  int line() {
    line_ += static_cast<int>(std::count(counted_, told_, '\n'));
    counted_ = told_;
    return line_;
  }
  [[noreturn]] static void fail(int line, const std::string& what) { throw JsonFault(what, line, false); }

  void take(json::parse_event_t event, const json& value) {
    using Event = json::parse_event_t;
    if (event == Event::object_start || event == Event::array_start) open_.emplace_back();
    if (event == Event::object_end || event == Event::array_end) open_.pop_back();
    if (event == Event::key) take_key(value.get<std::string>());
    if (event == Event::value && !open_.empty() && open_.back().key == "id") check_id(value);
  }

  void take_key(const std::string& key) {
    Object& object = open_.back();
    object.key = key;
    object.key_line = line();
    if (!object.keys.insert(key).second) fail(line(), fmt::format("key \"{}\" stands twice", key));
  }

  void check_id(const json& value) const {
    if (value.is_number() && std::abs(value.get<double>()) > kMostId)
      fail(open_.back().key_line, fmt::format("id {} is beyond 2^53 - 1", value.dump()));
  }

  const std::string& text_;
  const char *told_, *counted_;
  int line_ = 1;
  int most_levels_;
  std::vector<Object> open_;  // lists, too, which have no keys
};

}  // namespace

json parse_strict_json(const std::string& text, int most_levels) {
  return StrictParser(text, most_levels).parse();
}

json read_strict_json(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  if (text.size() > kMostFileBytes) throw InputError(file, "is longer than 64 MiB");
  try {
    return parse_strict_json(text, kMostFileLevels);
  } catch (const JsonFault& e) {
    throw InputError(file, e.line, e.what());
  }
}

}  // namespace uniquadric
