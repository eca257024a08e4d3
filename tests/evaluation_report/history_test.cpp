#include "evaluation/report/history.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/files.h"
#include "evaluation/report/report.h"
#include "tests/evaluation_report/fabricated_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// Fabricated results of a commit; the estimates of `worse` are lost where the others' are not.
fs::path fabricate(const TempFolder& folder, const std::string& commit, bool worse) {
  const fs::path results = folder.path() / commit.substr(0, 1);
  fabricate_results(results, {.frames = 20, .with_failure = worse});
  write_text(results / "program.txt", "uniquadric 0.1.0, commit " + commit + "cdef0123, unchanged\n");
  write_report(results);
  return results;
}

TEST(History, NamesCommitsAndJudgesNeighbours) {
  const TempFolder folder;
  const fs::path a = fabricate(folder, "aaaaaaaa", false), b = fabricate(folder, "b<b>bbbb", false),
                 c = fabricate(folder, "cccccccc", true);
  const History made = history({a, b, c});
  EXPECT_NE(made.text.find("aaaaaaaa: the first\n"), std::string::npos) << made.text;
  EXPECT_NE(made.text.find("b<b>bbbb: pass"), std::string::npos) << made.text;
  EXPECT_NE(made.text.find("cccccccc: worse"), std::string::npos) << made.text;
  // APE.t of seeds 1 and 2: the median of 0.5 and 1 m, of all objects the same.
  EXPECT_NE(made.text.find("single_frame_obb  APE.t [m]"), std::string::npos) << made.text;
  EXPECT_NE(made.text.find("0.750     0.750     0.750"), std::string::npos) << made.text;
  EXPECT_EQ(made.html.find("<b>bbbb"), std::string::npos);
  EXPECT_NE(made.html.find("b&lt;b&gt;bbbb"), std::string::npos);
  EXPECT_EQ(made.html.find("http"), made.html.find("http-equiv"));
  EXPECT_EQ(history({a, b, c}).html, made.html);
}

// The report's first variant has the first colour, whatever its name.
TEST(History, VariantsHaveTheReportsColours) {
  const TempFolder folder;
  const std::string html =
      history({fabricate(folder, "aaaaaaaa", false), fabricate(folder, "bbbbbbbb", false)}).html;
  EXPECT_NE(html.find("<i class=\"f0\"></i>single_frame_obb<i class=\"f1\"></i>rotbbox</p>"),
            std::string::npos);
}

TEST(History, NeedsTwoFoldersOfResults) {
  const TempFolder folder;
  const fs::path a = fabricate(folder, "aaaaaaaa", false);
  EXPECT_THROW(history({a}), InputError);
  EXPECT_THROW(history({a, folder.path()}), InputError);
}

}  // namespace
}  // namespace uniquadric
