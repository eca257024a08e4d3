#include "core/base/config.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace uniquadric
