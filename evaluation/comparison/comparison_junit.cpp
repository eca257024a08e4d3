#include <fmt/format.h>

#include <algorithm>

#include "evaluation/comparison/comparison_table.h"
#include "evaluation/comparison/score_comparison.h"
#include "evaluation/results/markup.h"

namespace uniquadric {
namespace {

// Text of an attribute in double quotes; XML has no control characters.
std::string attribute(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
  std::string quoted;
  for (const char c : escaped(text)) quoted += c == '"' ? std::string("&quot;") : std::string(1, c);
  return quoted;
}

// A head of `<testcase ...`, and what is inside: a failure or what was skipped.
std::string test_case(const std::string& group, const std::string& name, const char* inside,
                      const std::string& message) {
  const std::string head =
      fmt::format("    <testcase classname=\"{}\" name=\"{}\"", attribute(group), attribute(name));
  if (*inside == '\0') return head + "/>\n";
  return fmt::format("{}><{} message=\"{}\"/></testcase>\n", head, inside, attribute(message));
}

std::string test_case(const MetricChange& change) {
  const bool worse = change.verdict == Verdict::worse, skipped = change.verdict == Verdict::not_judged;
  const char* const inside = worse ? "failure" : skipped ? "skipped" : "";
  return test_case("compare." + change.variant + "." + change.subjects, change.metric, inside,
                   describe_change(change));
}

}  // namespace

std::string comparison_junit(const ScoreComparison& comparison) {
  const bool passed = comparison.answer == GateAnswer::pass;
  std::string cases = test_case("compare", "answer", passed ? "" : "failure", headline(comparison));
  for (const MetricChange& change : comparison.metrics) cases += test_case(change);
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n"
      "  <testsuite name=\"uniquadric compare\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\">\n{}"
      "  </testsuite>\n</testsuites>\n",
      comparison.metrics.size() + 1, count_verdicts(comparison, Verdict::worse) + (passed ? 0 : 1),
      count_verdicts(comparison, Verdict::not_judged), cases);
}

}  // namespace uniquadric
