#include "core/base/config.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/config_overrides.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

ConfigNode parse(const std::string& text) {
  return ConfigNode::parse(text, "file.yaml");
}

TEST(Config, EveryRefusalNamesFileLineAndKey) {
  const std::vector<std::pair<std::string, std::function<void()>>> cases = {
      {"file.yaml:2: unknown key 'frmaes' (known: frames)",
       [] {
         const auto node = parse("frames: 3\nfrmaes: 4\n");
         (void)node.get<int>("frames");
         node.refuse_unknown_keys();
       }},
      {"file.yaml:2: key 'a' stands twice",
       [] {
         const auto node = parse("a: 1\na: 2\n");
         (void)node.get<int>("a");
         node.refuse_unknown_keys();
       }},
      {"file.yaml:1: missing key 'frames'", [] { (void)parse("a: 1").get<int>("frames"); }},
      {"file.yaml:2: a.b: expected a number",
       [] { (void)parse("a:\n  b: many\n").at("a").get<double>("b"); }},
      {"file.yaml:1: a: expected a finite number", [] { (void)parse("a: .nan").get<double>("a"); }},
      {"file.yaml:1: a: expected an integer", [] { (void)parse("a: 1.5").get<int>("a"); }},
      {"file.yaml:1: a: expected 3 numbers, found 2",
       [] { (void)parse("a: [1, 2]").get<Eigen::Vector3d>("a"); }},
      {"file.yaml:1: a: expected a number greater than 0, found -1",
       [] { (void)parse("a: -1").positive("a"); }},
      {"file.yaml:1: a: 'x' is none of: y, z",
       [] {
         (void)parse("a: x").choice("a", {"y", "z"}, "y");
       }},
      {"file.yaml:2: malformed YAML: ", [] { parse("a: [1, 2\nb: 3\n"); }},
      {"file.yaml:1: expected a map with key 'a'", [] { (void)parse("- 1").get<int>("a"); }},
  };
  int checked = 0;
  for (const auto& [expected, action] : cases) {
    EXPECT_EQ(input_error(action).substr(0, expected.size()), expected);
    ++checked;
  }
  EXPECT_EQ(checked, 11);
}

ConfigNode parse_with(const std::string& text, const std::vector<std::string>& set) {
  return ConfigNode::parse(text, "file.yaml", parse_overrides(set));
}

TEST(Config, ValuesCanBeSet) {
  const std::string text = "shared: &s {x: 1, y: 2}\nlist: [{v: 3}, *s]\n";
  const ConfigNode node =
      parse_with(text, {"shared.x=5", "list[1].y=[6, 7]", "made.up=a=b", "list[0]={w: 8}", "shared.x=9"});
  EXPECT_EQ(node.at("shared").get<int>("x"), 9) << "the last one stands";
  EXPECT_EQ(node.at("shared").get<int>("y"), 2) << "what is not set is the file's";
  EXPECT_EQ(node.at("list").items()[1].get<int>("x"), 1) << "an alias is of its own";
  EXPECT_EQ(node.at("list").items()[1].at("y").yaml(), "[6, 7]");
  EXPECT_EQ(node.at("list").items()[0].get<int>("w"), 8);
  EXPECT_EQ(node.at("made").get<std::string>("up"), "a=b");
  EXPECT_EQ(parse(text).at("shared").get<int>("x"), 1);
}

TEST(Config, ValuesThatAreSetAreRefusedAsSuch) {
  const auto refusal = [](const std::string& set, const auto& read) {
    return input_error([&] { read(parse_with("a: 1\nb: [2]\n", {set})); });
  };
  const auto a = [](const ConfigNode& node) { (void)node.get<int>("a"); };
  const auto all = [](const ConfigNode& node) {
    for (const char* key : {"a", "b"}) (void)node.find(key);
    node.refuse_unknown_keys();
  };
  EXPECT_EQ(refusal("a=x", a), "file.yaml: a: expected an integer (set, not the file's)");
  EXPECT_EQ(refusal("c=x", all), "file.yaml: unknown key 'c' (known: a, b)");
  EXPECT_EQ(refusal("a.c=2", a), "file.yaml: set a.c=2: there is no key 'c'");
  for (const char* index : {"1", "-1", "x"})
    EXPECT_EQ(refusal(fmt::format("b[{}]=2", index), a),
              fmt::format("file.yaml: set b[{0}]=2: there is no item [{0}]", index));
  std::string deep = "a";
  for (int i = 0; i < 20'000; ++i) deep += ".a";
  for (const std::string& key :
       {std::string("a]"), std::string("[0]"), std::string("a..c"), std::string(".a"), std::string("a."),
        std::string("b[0"), std::string("b[0]c"), deep})
    EXPECT_EQ(refusal(key + "=1", a)
                  .find(fmt::format("file.yaml: set {}=1: expected a key such as", key.substr(0, 100))),
              0u);
  EXPECT_EQ(refusal("a=1\n---\n2", a), "file.yaml: set a=1\\x0a---\\x0a2: expected one value");
  EXPECT_EQ(refusal("a=[", a).find("file.yaml: set a=[: malformed YAML"), 0u);
  for (const char* text : {"a", "=1", ""})
    EXPECT_EQ(refusal(text, a), fmt::format("--set {}: expected KEY=VALUE", text));
}

TEST(Config, ASecondDocumentIsRefused) {
  EXPECT_EQ(input_error([] { parse("a: 1\n---\nframes: 9\n"); }),
            "file.yaml:3: a second YAML document; expected one");
}

TEST(Config, ReadsEachType) {
  const auto node = parse(
      "b: true\ni: -3\nu: 18446744073709551615\nd: 1e-3\ns: text\nv: [1, 2, 3]\nl:\n  - {x: 1}\n  - {x: "
      "2}\n");
  EXPECT_TRUE(node.get<bool>("b"));
  EXPECT_EQ(node.get<int>("i"), -3);
  EXPECT_EQ(node.get<std::uint64_t>("u"), 18446744073709551615u);
  EXPECT_EQ(node.get<double>("d"), 1e-3);
  EXPECT_EQ(node.get<std::string>("s"), "text");
  EXPECT_EQ(node.get<Eigen::Vector3d>("v"), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(node.at("l").items().at(1).get<int>("x"), 2);
  EXPECT_EQ(node.get<int>("absent", 5), 5);
  node.refuse_unknown_keys();
}

// Ten of ten of ten ...: 1 + 10 + 100 + ... values.
std::string aliases_of_aliases(int levels) {
  std::string text = "- &a0 [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]\n";
  for (int i = 1; i <= levels; ++i) {
    text += fmt::format("- &a{} [", i);
    for (int k = 0; k < 10; ++k) text += fmt::format("{}*a{}", k ? ", " : "", i - 1);
    text += "]\n";
  }
  return text;
}

TEST(Config, AliasesCountAsWhatTheyStandFor) {
  EXPECT_EQ(parse(aliases_of_aliases(3)).items().at(3).items().size(), 10u);  // 12,346 values
  EXPECT_NE(input_error([] { parse(aliases_of_aliases(5)); }).find("file.yaml:6: more than 200000 values"),
            std::string::npos);
  EXPECT_NE(input_error([] { parse("&a [1, *a]"); }).find("an alias within what it stands for"),
            std::string::npos);
}

TEST(Config, TextsAreUtf8) {
  EXPECT_EQ(parse("a: W\xc3\xbcrfel").get<std::string>("a"), "W\xc3\xbcrfel");
  for (const char* text : {"\n\xff: 1", "\na: W\xfcrfel"})
    EXPECT_NE(input_error([&] { parse(text); }).find("file.yaml:2: a text that is not UTF-8"),
              std::string::npos);
}

TEST(Config, NestingIsBounded) {
  const auto nested = [](int levels) { return std::string(levels, '[') + std::string(levels, ']'); };
  EXPECT_TRUE(parse(nested(64)).is_sequence());
  for (const int levels : {65, 100'000})
    EXPECT_NE(input_error([&] { parse(nested(levels)); }).find("file.yaml:1: nested more than 64"),
              std::string::npos);
  std::string by_aliases = "- &a0 [0]\n";
  for (int i = 1; i < 64; ++i) by_aliases += fmt::format("- &a{} [*a{}]\n", i, i - 1);
  EXPECT_NE(input_error([&] { parse(by_aliases); }).find("nested more than 64"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
