#include "evaluation/report/latex.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "core/base/files.h"
#include "core/base/text.h"
#include "tests/evaluation_report/fabricated_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

TEST(Latex, EscapesWhatItReads) {
  EXPECT_EQ(latex_escaped("a_b & 5 % #1 $x {y} ~z ^w \\input"),
            "a\\_b \\& 5 \\% \\#1 \\$x \\{y\\} \\~{}z \\^{}w \\textbackslash{}input");
  EXPECT_EQ(latex_escaped("two\nlines"), "two lines");
  EXPECT_EQ(latex_escaped("[x] <b>|"), "{[}x] \\textless{}b\\textgreater{}\\textbar{}");
}

TEST(Latex, RowsHaveTheColumnsOfTheHead) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 20});
  const std::string table = latex_table(summarize(read_results(folder.path())));
  const auto lines = split(table, '\n');
  const auto count = [](std::string_view line) { return std::count(line.begin(), line.end(), '&'); };
  long columns = -1;
  int rows = 0;
  for (const auto line : lines)
    if (line.ends_with("\\\\") && line.find("multicolumn") == line.npos) {
      if (columns < 0) columns = count(line);
      EXPECT_EQ(count(line), columns) << line;
      ++rows;
    }
  EXPECT_GT(columns, 7);
  EXPECT_EQ(rows, 1 + 2 * 3 * 2);  // two scenes, two objects and the camera, two variants
  const auto group = table.find("{\\textit{cuboid}, cube\\_cuboid}");
  ASSERT_NE(group, table.npos) << table;
  EXPECT_NE(table.find("  single\\_frame\\_obb & 2/2 & 0.750", group), table.npos) << table;
  EXPECT_NE(table.find("\\textbf{0.0150}"), table.npos) << table;
}

TEST(Latex, OutputsStandBelowTheirVariantAlone) {
  const auto row = [](const std::string& variant) {
    SummaryRow result;
    result.scene = "scene", result.object = "cube", result.variant = variant;
    return result;
  };
  const std::string table = latex_table({row("ab"), row("a@final"), row("b"), row("b@final")});
  EXPECT_NE(table.find("  ab \\\\\n  a@final \\\\\n  b \\\\\n  \\quad @final \\\\\n"), table.npos) << table;
}

TEST(Latex, SaysWhereNamesNeedOtherLetters) {
  const auto table_of = [](const std::string& scene) {
    SummaryRow row;
    row.scene = scene, row.object = "cube", row.variant = "a";
    return latex_table({row});
  };
  EXPECT_NE(table_of("桌子").find("use LuaLaTeX"), std::string::npos);
  EXPECT_EQ(table_of("table").find("LuaLaTeX"), std::string::npos);
}

// Where there is LaTeX: it has no complaint.
TEST(Latex, Compiles) {
  if (std::system("command -v pdflatex >/dev/null && kpsewhich booktabs.sty >/dev/null") != 0)
    GTEST_SKIP() << "no LaTeX here";
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 20});
  write_text(folder.path() / "table.tex",
             "\\documentclass{article}\\usepackage{booktabs}\\begin{document}\\noindent\n" +
                 latex_table(summarize(read_results(folder.path()))) + "\\end{document}\n");
  const std::string command =
      "cd '" + folder.path().string() +
      "' && timeout 60 pdflatex -halt-on-error -interaction=batchmode table.tex >/dev/null";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(read_text(folder.path() / "table.log").find("Overfull"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
