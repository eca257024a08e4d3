#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>

namespace uniquadric {

/// What is wrong with a text that should be JSON.
struct JsonFault : std::runtime_error {
  JsonFault(const std::string& what, int of_line, bool syntax)
      : std::runtime_error(what), line(of_line), is_syntax(syntax) {}
  int line;        ///< from 1
  bool is_syntax;  ///< no JSON at all
};

/// Reads JSON as the standard has it, and refuses what JSON leaves open and programs read differently: a key
/// that stands twice in one object, and an `id` beyond 2^53 - 1, which not every program can tell
/// from its neighbours. Throws JsonFault; also for a number that no double holds, and for more than
/// `most_levels` of nesting.
nlohmann::json parse_strict_json(const std::string& text, int most_levels);

/// The same of a file that the program has written, of 64 MiB and 64 levels at most: an evaluation of a
/// thousand objects takes 4 MB. Throws InputError with file and line.
nlohmann::json read_strict_json(const std::filesystem::path& file);

}  // namespace uniquadric
