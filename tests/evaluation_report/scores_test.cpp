#include "evaluation/results/scores.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/base/files.h"
#include "core/base/text.h"
#include "evaluation/report/report.h"
#include "evaluation/results/metrics.h"
#include "tests/evaluation_report/fabricated_results.h"
#include "tests/evaluation_report/small_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

TEST(Scores, OneRowAFigureAndFailedRowsWithoutValue) {
  const TempFolder folder;
  write_small_results(folder.path());
  write_report(folder.path());
  EXPECT_EQ(read_text(folder.path() / "scores.csv"),
            "sequence,object,variant,seed,metric,value,better,status\n"
            "s,cube,a,1,ape_translation_rmse_m,0.1,lower,ok\n"
            "s,cube,a,1,iou3d_ellipsoid_mean,0.30000000000000004,higher,ok\n"
            "s,cube,a,1,coverage,0.5,higher,ok\n"
            "s,cube,a,1,id_switches,2,lower,ok\n"
            "s,camera,a,1,ape_translation_rmse_m,0,lower,ok\n"
            "s,cube,b,1,ape_translation_rmse_m,,lower,failed\n"
            "s,cube,b,1,iou3d_ellipsoid_mean,,higher,failed\n"
            "s,cube,b,1,coverage,,higher,failed\n"
            "s,cube,b,1,id_switches,,lower,failed\n"
            "s,camera,b,1,ape_translation_rmse_m,,lower,failed\n");
}

// One name in tables, one in scores.csv, one in evaluation.json: docs/formats.md has each beside the others.
TEST(Scores, EveryMetricStandsInTheFormats) {
  const std::string page = read_text(std::filesystem::path(UNIQUADRIC_SOURCE_DIR) / "docs/formats.md");
  std::size_t rows = 0;
  for (const Metric& metric : all_metrics()) {
    std::string of, where = metric.pointer + 1;
    for (const auto& [scope, name] : {std::pair{MetricScope::object, "objects"},
                                      {MetricScope::camera, "camera"},
                                      {MetricScope::all, "all"}})
      if (metric.scopes & static_cast<int>(scope)) of += (of.empty() ? "" : ", ") + std::string(name);
    std::replace(where.begin(), where.end(), '/', '.');
    const std::string unit = *metric.unit ? fmt::format(" [{}]", metric.unit) : "";
    const std::string row = fmt::format("\n| `{}` | {}{} | {} | `{}` | {} |\n", metric.name, metric.label,
                                        unit, of, where, metric.lower_is_better ? "lower" : "higher");
    EXPECT_NE(page.find(row), page.npos) << row;
    ++rows;
  }
  EXPECT_GT(rows, 25u);
}

TEST(Scores, SequenceWithoutAGoodRunKeepsOneRowARun) {
  const TempFolder folder;
  write_file(folder.path() / "cells.csv",
             "scene,variant,seed,status,folder,message\ns,a,1,failed,x,\"gone, \"\"so\"\" "
             "said\"\ns,a,2,missing,y,\n");
  EXPECT_EQ(read_results(folder.path()).cells.at(0).message, "gone, \"so\" said");
  write_report(folder.path());
  EXPECT_EQ(read_text(folder.path() / "scores.csv"),
            "sequence,object,variant,seed,metric,value,better,status\n"
            "s,all,a,1,coverage,,higher,failed\n");  // what was not run is no failure
}

TEST(Scores, LostObjectFailsWhereAnotherRunHasAFigure) {
  const TempFolder folder;
  write_small_results(folder.path());
  write_file(
      folder.path() / "cells.csv",
      "scene,variant,seed,status,folder,message\ns,a,1,ok,cells/s/a/seed_1,\ns,c,1,ok,cells/s/c/seed_1,\n");
  write_file(folder.path() / "cells/s/c/seed_1/evaluation/evaluation.json",
             R"({"schema": 1, "objects": [{"id": 1, "name": "cube", "coverage": 0, "ape": null}]})");
  write_file(folder.path() / "cells/s/c/seed_1/evaluation/frames.csv", "frame,timestamp_ns,object_id\n");
  int lost = 0, covered = 0;
  for (const Score& score : scores(read_results(folder.path()))) {
    if (score.variant != "c" || score.object != "cube") continue;
    if (std::string(score.metric->name) == "coverage") covered += score.value == 0.0;
    if (std::string(score.metric->name) == "ape_translation_rmse_m") lost += !score.value.has_value();
  }
  EXPECT_EQ(covered, 1);
  EXPECT_EQ(lost, 1);
}

TEST(Scores, EveryFigureOfAFabricatedBenchReadsBack) {
  const TempFolder folder;
  fabricate_results(folder.path(), {.frames = 5, .overlays = 0});
  const Results results = read_results(folder.path());
  const std::vector<Score> rows = scores(results);
  // Per run 2 objects x 18 metrics without drift, the camera's 5 and 4 of `all`.
  EXPECT_EQ(rows.size(), 8u * (2 * 18 + 5 + 4));
  int line = -2, failed = 0;
  write_file(folder.path() / "scores.csv", scores_csv(rows));
  for_each_line(
      folder.path() / "scores.csv",
      [&](int, const std::vector<std::string_view>& fields) {
        if (++line < 0) return;
        ASSERT_EQ(fields.size(), 8u);
        const Score& row = rows[static_cast<std::size_t>(line)];
        EXPECT_EQ(parse_double(fields[5]), row.value);  // to the last bit
        EXPECT_EQ(fields[7], row.value ? "ok" : "failed");
        failed += !row.value;
      },
      ',');
  EXPECT_EQ(line + 1, static_cast<int>(rows.size()));
  EXPECT_EQ(failed, 2 * 18 + 5 + 4);  // the one failed run
}

}  // namespace
}  // namespace uniquadric
