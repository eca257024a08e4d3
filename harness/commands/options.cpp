#include "harness/commands/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>

#include "core/base/text.h"
#include "harness/bench/keys.h"

namespace uniquadric {

CLI::Validator whole_number(std::uint64_t least, std::uint64_t most) {
  return {[least, most](const std::string& text) {
            std::uint64_t value = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
            if (error == std::errc{} && end == text.data() + text.size() && value >= least && value <= most)
              return std::string();
            return fmt::format("'{}' is no whole number from {} to {}", text, least, most);
          },
          ""};
}

CLI::Validator at_least_0() {
  return {[](const std::string& text) {
            const auto value = parse_double(text);
            return value && *value >= 0 ? std::string()
                                        : fmt::format("'{}' is no number of at least 0", text);
          },
          ""};
}

CLI::App* subcommand(CLI::App& app, const std::string& name, const std::string& what, Common& common) {
  CLI::App* sub = app.add_subcommand(name, what);
  sub->add_flag("-q,--quiet", common.quiet, "no progress on stderr");
  sub->add_option("--threads", common.threads, "threads to use; 0: as many as there are cores")
      ->check(whole_number(0, kMaxCount));
  return sub;
}

void add_set(CLI::App* sub, std::vector<std::string>& set, const std::string& what) {
  sub->add_option("--set", set, "once for each key, of which the last counts: " + what)
      ->allow_extra_args(false)
      ->option_text("KEY=VALUE");  // CLI11's own has "...", as if one option took several
}

CLI::Option* add_force(CLI::App* sub, Common& common) {
  return sub->add_flag("--force", common.force,
                       "replace OUT, if this program wrote it as the same kind of result");
}

void add_no_verify(CLI::App* sub, bool& verify) {
  sub->add_flag("!--no-verify", verify, "do not compare the input's text files with its hashes.txt");
}

void add_stage_options(CLI::App* sub, Common& common) {
  add_force(sub, common);
  sub->add_option("--key", common.key, "kept in OUT.key: an OUT that is whole and has it is not made again");
}

void make_stage(const Common& common, const std::filesystem::path& out, const std::function<void()>& make) {
  if (common.key.empty()) return make();
  if (is_current(out, common.key)) return;
  forget_key(out);
  make();
  record_key(out, common.key);
}

}  // namespace uniquadric
