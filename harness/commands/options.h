#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace uniquadric {

constexpr int kBadInput = 2;       ///< exit code of bad input and of an incomplete answer
constexpr int kInternalError = 3;  ///< exit code of a fault of the program, and of memory that ran out
constexpr std::uint64_t kMaxCount = 10'000'000;

/// What the subcommands share.
struct Common {
  std::string command;  ///< the line the program was called with, for reports to state
  bool quiet = false;
  bool force = false;
  std::string key;  ///< of the output, as a bench knows it by (harness/bench/keys.h); empty: none
  int threads = 0;
  int exit_code = 0;  ///< of the program; a callback sets it
};

/// Takes a whole number of at least `least` and at most `most`, digits only: CLI11 itself lets -5 wrap
/// around.
CLI::Validator whole_number(std::uint64_t least = 0,
                            std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

/// Takes a finite number of at least 0.
CLI::Validator at_least_0();

/// A subcommand with the options that every one has: --quiet, --threads.
CLI::App* subcommand(CLI::App& app, const std::string& name, const std::string& what, Common& common);

/// --set KEY=VALUE, any number of times; `what` says which values there are.
void add_set(CLI::App* sub, std::vector<std::string>& set, const std::string& what);

CLI::Option* add_force(CLI::App* sub, Common& common);

/// --no-verify, which takes an input whose text files are not as its hashes.txt says.
void add_no_verify(CLI::App* sub, bool& verify);

/// Options of a subcommand that is a stage of a bench: --force and --key.
void add_stage_options(CLI::App* sub, Common& common);

/// Makes `out`, unless it stands there whole under the key that --key gave; then gives it that key.
void make_stage(const Common& common, const std::filesystem::path& out, const std::function<void()>& make);

}  // namespace uniquadric
