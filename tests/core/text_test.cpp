#include "core/base/text.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/utf8.h"
#include "tests/support/temp_folder.h"

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

TEST(Utf8, IsWhatRfc3629Says) {
  for (const char* text : {"", "a", "\x7f", "\xc2\x80", "\xdf\xbf", "\xe0\xa0\x80", "\xed\x9f\xbf",
                           "\xee\x80\x80", "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf", "W\xc3\xbcrfel"})
    EXPECT_TRUE(is_utf8(text)) << text;
  for (const char* text : {"\x80", "\xc1\xbf", "\xc2", "\xc2\x41", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xe2\x82",
                           "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff", "a\xff"})
    EXPECT_FALSE(is_utf8(text)) << text;
  EXPECT_TRUE(is_plain_name("W\xc3\xbcrfel"));
  EXPECT_FALSE(is_plain_name("W\xfcrfel"));
  EXPECT_TRUE(is_plain_name(std::string(200, 'x')));
  EXPECT_FALSE(is_plain_name(std::string(201, 'x')));
  for (const char* formula : {"=1+1", "+x", "-1", "@SUM", "..", ".hidden"})
    EXPECT_FALSE(is_plain_name(formula));
  EXPECT_TRUE(is_plain_name("a=1+1-@."));
}

TEST(InputError, ShowsControlBytesAsWhatTheyAre) {
  const InputError error("file", 3, std::string("a\0b\x1b[2J", 7));
  EXPECT_STREQ(error.what(), "file:3: a\\x00b\\x1b[2J");
}

TEST(InputError, ShowsTheBeginOfALongText) {
  EXPECT_EQ(std::string(InputError("f", std::string(5000, 'x')).what()),
            "f: " + std::string(997, 'x') + "...");
}

TEST(Split, BlanksCountAsOneSeparatorsEachByItself) {
  using Fields = std::vector<std::string_view>;
  EXPECT_EQ(split(" a \t bc\r"), (Fields{"a", "bc"}));
  EXPECT_EQ(split(""), Fields{});
  EXPECT_EQ(split("a, b c ,,d,", ','), (Fields{"a", "b c", "", "d", ""}));
  EXPECT_EQ(split("", ','), Fields{""});
}

TEST(Lines, EachHasItsOwnFields) {
  const TempFolder temp;
  write_text(temp.path() / "a", "1 2 3\n# no\n\n4\n");
  std::vector<std::pair<int, std::size_t>> seen;
  for_each_line(temp.path() / "a",
                [&](int line, const auto& fields) { seen.emplace_back(line, fields.size()); });
  EXPECT_EQ(seen, (std::vector<std::pair<int, std::size_t>>{{1, 3}, {4, 1}}));
}

TEST(Lines, OneWithoutEndIsRefused) {
  const TempFolder temp;
  const std::string most(1 << 20, 'x');
  int lines = 0;
  write_text(temp.path() / "a", "1\n" + most + "\n");
  for_each_line(temp.path() / "a", [&](int, const auto&) { ++lines; });
  EXPECT_EQ(lines, 2);
  write_text(temp.path() / "a", "1\n" + most + "x\n");
  EXPECT_NE(
      input_error([&] { for_each_line(temp.path() / "a", [](int, const auto&) {}); }).find("a:2: is longer"),
      std::string::npos);
}

}  // namespace
}  // namespace uniquadric
