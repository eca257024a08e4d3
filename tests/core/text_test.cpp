#include "core/base/text.h"

#include <gtest/gtest.h>

namespace uniquadric {
namespace {

TEST(CsvText, IsQuotedAsRfc4180AndReadBack) {
  EXPECT_EQ(csv_quoted("a, b"), "\"a, b\"");
  EXPECT_EQ(csv_quoted("say \"no\""), "\"say \"\"no\"\"\"");
  EXPECT_EQ(csv_quoted("plain: text;\nmore"), "plain: text; more");
  for (const char* text : {"", "plain", "a,b, c", "\"", "\"\"", ",\"a\",", "it is \"x\"", "ends in \"x\""})
    EXPECT_EQ(csv_unquoted(csv_quoted(text)), text);
  EXPECT_EQ(csv_unquoted("commas, as they are"), "commas, as they are");
}

}  // namespace
}  // namespace uniquadric
