#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "harness/commands/commands.h"
#include "harness/commands/options.h"

namespace uniquadric {
namespace {

// The words before the cursor lead to a subcommand (path) and so many positionals in it; an option before the
// cursor wants its value. Where the tables have nothing to offer, bash offers files (complete -o default).
constexpr const char* kFunction = R"(_uniquadric() {
  local path=uniquadric position=1 word words i
  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word=${COMP_WORDS[i]}
    if [[ $word == -* ]]; then
      i=$((i + ${_uniquadric_values[$path $word]:-0}))
    elif [[ -n ${_uniquadric_options[$path $word]-} ]]; then
      path+=" $word" position=1
    else
      position=$((position + 1))
    fi
  done
  if [[ ${_uniquadric_values[$path $before]:-0} != 0 ]]; then
    words=${_uniquadric_choices[$path $before]-}
  elif [[ $current == -* ]]; then
    words=${_uniquadric_options[$path]-}
  else
    words="${_uniquadric_choices[$path $position]-}"
    [[ $position != 1 ]] || words+=" ${_uniquadric_subcommands[$path]-}"
  fi
  COMPREPLY=($(compgen -W "$words" -- "$current"))
}
complete -o default -F _uniquadric uniquadric
)";

/// Tables of bash: what stands at a subcommand's path ("uniquadric import tum"), or at a path with an option
/// or the number of a positional behind it.
struct Tables {
  std::string subcommands, options, values, choices;
};

void add_entry(std::string& table, const std::string& key, const std::string& value) {
  if (!value.empty()) table += fmt::format("  ['{}']='{}'\n", key, value);
}

// The words an option takes, as its check names them ("TEXT:{osmesa,egl}").
std::string choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{'), end = type.find('}');
  if (begin == type.npos || end == type.npos) return "";
  std::string words = type.substr(begin + 1, end - begin - 1);
  std::replace(words.begin(), words.end(), ',', ' ');
  return words;
}

void describe(const CLI::App& app, const std::string& path, Tables& tables) {
  std::vector<std::string> options, subcommands;
  int position = 0;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_positional()) {
      add_entry(tables.choices, fmt::format("{} {}", path, ++position), choices_of(*option));
      continue;
    }
    std::vector<std::string> names;
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    for (const std::string& name : names) {
      options.push_back(name);
      const int values = option->get_items_expected_max();
      if (values > 0) add_entry(tables.values, path + " " + name, std::to_string(values));
      add_entry(tables.choices, path + " " + name, choices_of(*option));
    }
  }
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    subcommands.push_back(sub->get_name());
    describe(*sub, path + " " + sub->get_name(), tables);
  }
  add_entry(tables.options, path, fmt::format("{}", fmt::join(options, " ")));
  add_entry(tables.subcommands, path, fmt::format("{}", fmt::join(subcommands, " ")));
}

std::string bash_completion(const CLI::App& app) {
  Tables tables;
  describe(app, "uniquadric", tables);
  std::string text = "# made by: uniquadric completion bash\n";
  const auto put = [&](const char* name, const std::string& entries) {
    text += fmt::format("declare -gA _uniquadric_{}=(\n{})\n", name, entries);
  };
  put("subcommands", tables.subcommands);
  put("options", tables.options);
  put("values", tables.values);
  put("choices", tables.choices);
  return text + kFunction;
}

}  // namespace

void add_completion(CLI::App& app, Common&) {
  auto* sub = app.add_subcommand("completion", "what a shell needs to complete words: source <(...)");
  static std::string shell;
  sub->add_option("SHELL", shell, "to complete in")->required()->check(CLI::IsMember({"bash"}));
  sub->callback([&app] { std::cout << bash_completion(app); });
}

}  // namespace uniquadric
