#include "core/base/text.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

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

TEST(InputError, ShowsControlBytesAsWhatTheyAre) {
  const InputError error("file", 3, std::string("a\0b\x1b[2J", 7));
  EXPECT_STREQ(error.what(), "file:3: a\\x00b\\x1b[2J");
}

}  // namespace
}  // namespace uniquadric
