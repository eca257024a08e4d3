#include "evaluation/comparison/score_table.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/files.h"
#include "evaluation/comparison/pairing.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

const std::string kHeader = "sequence,object,variant,seed,metric,value,better,status\n";
const std::string kRow = "s,cube,v,1,iou3d_ellipsoid_mean,0.5,higher,ok\n";

class ScoreFile : public testing::Test {
 protected:
  std::filesystem::path path() const { return folder_.path() / "scores.csv"; }
  ScoreTable read(const std::string& text, const ScoreSelection& selection = {}) const {
    write_text(path(), text);
    return read_score_table(path(), selection);
  }
  void expect_refusal(const std::string& text, const std::string& what,
                      const ScoreSelection& selection = {}) const {
    try {
      read(text, selection);
      FAIL() << "was read: " << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(what), std::string::npos)
          << "wanted: " << what << "\ngot: " << error.what();
    }
  }

 private:
  TempFolder folder_;
};

TEST_F(ScoreFile, ReadsEveryField) {
  const ScoreTable table = read(kHeader + kRow + "s,cube,v,18446744073709551615,id_switches,2,lower,ok\n" +
                                "s,cube,v,2,iou3d_ellipsoid_mean,,higher,failed\n");
  EXPECT_EQ(table.cells.size(), 3u);
  EXPECT_EQ(table.cells.at({{"v", "s", 1}, "cube", "iou3d_ellipsoid_mean"}), 0.5);
  EXPECT_EQ(table.cells.at({{"v", "s", 18446744073709551615u}, "cube", "id_switches"}), 2);
  EXPECT_EQ(table.cells.at({{"v", "s", 2}, "cube", "iou3d_ellipsoid_mean"}), std::nullopt);
  EXPECT_FALSE(table.lower_is_better.at("iou3d_ellipsoid_mean"));
  EXPECT_TRUE(table.lower_is_better.at("id_switches"));
}

TEST_F(ScoreFile, ReadsTheNameOfEarlierVersions) {
  const std::string text = kHeader + "s,cube,v,1,iou3d_mean,0.5,higher,ok\n";
  EXPECT_EQ(read(text).cells.at({{"v", "s", 1}, "cube", "iou3d_ellipsoid_mean"}), 0.5);
  EXPECT_EQ(read(text, {std::nullopt, {"iou3d_mean"}}).cells.size(), 1u);
}

TEST_F(ScoreFile, RefusesByLine) {
  expect_refusal("", "scores.csv: is empty, expected a header");
  expect_refusal(kHeader, "scores.csv: has no scores");
  expect_refusal(kRow, "scores.csv:1: expected the header sequence,object,variant");
  const auto expect_third = [&](const std::string& row, const std::string& what) {
    expect_refusal(kHeader + kRow + row + "\n", "scores.csv:3: " + what);
  };
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,0.5,higher", "expected 8 columns");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,0.5,higher,ok,more", "expected 8 columns");
  expect_third(",cube,v,2,iou3d_ellipsoid_mean,0.5,higher,ok", "sequence is empty");
  expect_third("s,,v,2,iou3d_ellipsoid_mean,0.5,higher,ok", "object is empty");
  expect_third("s,cube,,2,iou3d_ellipsoid_mean,0.5,higher,ok", "variant is empty");
  expect_third("s,cube,v,2,,0.5,higher,ok", "metric is empty");
  expect_third("s,cube,v,-2,iou3d_ellipsoid_mean,0.5,higher,ok", "seed '-2' is no whole number");
  expect_third("s,cube,v,1.5,iou3d_ellipsoid_mean,0.5,higher,ok", "seed '1.5' is no whole number");
  expect_third("s,cube,v,,iou3d_ellipsoid_mean,0.5,higher,ok", "seed '' is no whole number");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,half,higher,ok", "value 'half' is no finite number");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,nan,higher,ok", "value 'nan' is no finite number");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,,higher,ok", "value '' is no finite number");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,1e200,higher,ok", "value 1e200 is beyond 1e+100");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,0.5,higher,failed", "value '0.5' of a cell that failed");
  expect_third("s,cube,v,2,d_shape_mean_m,-1,lower,ok", "value -1 of an error is below 0");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,1.5,higher,ok",
               "value of iou3d_ellipsoid_mean: 1.5 is more than 1");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,-0.1,higher,ok",
               "value of iou3d_ellipsoid_mean: -0.1 is below 0");
  expect_third("s,cube,v,2,coverage,-1,higher,ok", "value of coverage: -1 is below 0");
  expect_third("s,all,v,2,mota,1.5,higher,ok", "value of mota: 1.5 is more than 1");
  read(kHeader + "s,all,v,2,mota,-1.5,higher,ok\ns,all,v,2,another_score,7,higher,ok\n");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,0.5,up,ok", "better 'up' is neither lower nor higher");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,0.5,lower,ok",
               "better 'lower' of iou3d_ellipsoid_mean, of which higher is better");
  expect_third("s,cube,v,2,iou3d_ellipsoid_mean,0.5,higher,lost", "status 'lost' is neither ok nor failed");
  expect_third("s,cube,v,1,iou3d_ellipsoid_mean,0.6,higher,ok",
               "this sequence, object, variant, seed and metric stand");
}

TEST_F(ScoreFile, ADirectionThatIsTheOtherWayRoundIsToldWhereItStands) {
  const auto row = [](int seed, const char* metric, const char* better) {
    return fmt::format("s,cube,v,{},{},0.5,{},ok\n", seed, metric, better);
  };
  expect_refusal(kHeader + row(1, "iou3d_ellipsoid_mean", "lower") + row(2, "iou3d_ellipsoid_mean", "higher"),
                 "scores.csv:2: better 'lower' of iou3d_ellipsoid_mean, of which higher is better");
  // of another program's metric most lines count
  const auto of = [&](const std::vector<const char*>& directions) {
    std::string text = kHeader;
    for (std::size_t i = 0; i < directions.size(); ++i)
      text += row(static_cast<int>(i), "crispness", directions[i]);
    return text;
  };
  expect_refusal(of({"lower", "higher", "higher"}),
                 "scores.csv:2: better 'lower' of crispness differs from 2 of its 3 lines");
  expect_refusal(of({"lower", "lower", "higher", "lower"}),
                 "scores.csv:4: better 'higher' of crispness differs from 3 of its 4 lines");
  expect_refusal(of({"lower", "higher"}),
                 "scores.csv:3: better 'higher' of crispness differs from 1 of its 2 lines");
  EXPECT_TRUE(read(of({"lower", "lower"})).lower_is_better.at("crispness"));
}

TEST_F(ScoreFile, BeginsWithAByteOrderMarkOrNot) {
  EXPECT_EQ(read("\xef\xbb\xbf" + kHeader + kRow).cells.size(), 1u);
  const std::string_view utf16("\xff\xfes\0", 4);
  expect_refusal(std::string(utf16), "scores.csv:1: begins with the byte order mark of UTF-16");
}

TEST_F(ScoreFile, Selects) {
  const std::string text = kHeader + kRow + "s,cube,w,1,iou3d_ellipsoid_mean,0.6,higher,ok\n" +
                           "s,cube,w,1,coverage,0.7,higher,ok\n";
  EXPECT_EQ(read(text).cells.size(), 3u);
  EXPECT_EQ(read(text, {"w", {}}).cells.size(), 2u);
  EXPECT_EQ(read(text, {std::nullopt, {"iou3d_ellipsoid_mean"}}).cells.size(), 2u);
  EXPECT_EQ(read(text, {"w", {"coverage"}}).cells.size(), 1u);
  expect_refusal(text, "has no variant 'x', but v, w", {"x", {}});
  expect_refusal(text, "has no metric 'mota', but coverage, iou3d_ellipsoid_mean", {std::nullopt, {"mota"}});
}

TEST_F(ScoreFile, OfAResultsFolderWithRunsThatAreMissing) {
  const std::filesystem::path folder = path().parent_path();
  EXPECT_THROW(read_score_table(folder), InputError);  // no scores.csv
  EXPECT_THROW(read_score_table(folder / "nothing"), InputError);
  write_text(path(), kHeader + kRow);
  EXPECT_EQ(read_score_table(folder).cells.size(), 1u);
  write_text(folder / "cells.csv",
             "scene,variant,seed,status,folder,message\ns,v,1,ok,x,\ns,v,2,missing,y,\ns,w,2,missing,z,\n");
  EXPECT_EQ(read_score_table(folder).not_run, (std::set<RunKey>{{"v", "s", 2}, {"w", "s", 2}}));
  EXPECT_EQ(read_score_table(folder, {"v", {}}).not_run, (std::set<RunKey>{{"v", "s", 2}}));
  EXPECT_TRUE(read_score_table(path()).not_run.empty());  // the file alone
}

// Every way in which a cell can be in A and in B.
TEST_F(ScoreFile, PairsOrSaysWhyNot) {
  const ScoreTable a = read(kHeader + kRow +
                            "s,cube,v,2,iou3d_ellipsoid_mean,0.5,higher,ok\n"
                            "s,cube,v,3,iou3d_ellipsoid_mean,,higher,failed\n"
                            "s,cube,v,3,coverage,1,higher,ok\n"
                            "s,cube,v,4,iou3d_ellipsoid_mean,,higher,failed\n"
                            "s,cube,v,4,coverage,1,higher,ok\n"
                            "s,cube,v,5,coverage,1,higher,ok\n"
                            "s,cube,v,6,coverage,1,higher,ok\n");
  const ScoreTable b = read(kHeader + kRow +
                            "s,cube,v,2,iou3d_ellipsoid_mean,,higher,failed\n"
                            "s,cube,v,2,coverage,1,higher,ok\n"
                            "s,cube,v,3,iou3d_ellipsoid_mean,0.7,higher,ok\n"
                            "s,cube,v,3,coverage,1,higher,ok\n"
                            "s,cube,v,4,iou3d_ellipsoid_mean,,higher,failed\n"
                            "s,cube,v,4,coverage,1,higher,ok\n"
                            "s,all,v,6,coverage,,higher,failed\n"
                            "s,cube,v,7,coverage,1,higher,ok\n");
  const Pairing p = pair_scores(a, b);
  EXPECT_EQ(p.pairs.size(), 3u);  // seed 1, and coverage of 3 and 4
  EXPECT_EQ(p.new_failures,
            (std::vector<Gap>{{{"v", "s", 2}, "cube", {"iou3d_ellipsoid_mean"}}, {{"v", "s", 6}, "", {}}}));
  EXPECT_EQ(p.mended, (std::vector<Gap>{{{"v", "s", 3}, "cube", {"iou3d_ellipsoid_mean"}}}));
  EXPECT_EQ(p.missing_in_b, (std::vector<Gap>{{{"v", "s", 5}, "", {}}}));
  EXPECT_EQ(p.missing_in_a,
            (std::vector<Gap>{{{"v", "s", 2}, "cube", {"coverage"}}, {{"v", "s", 7}, "", {}}}));
  EXPECT_EQ(p.failed_in_both, 1u);  // seed 4; the row of seed 6 stands for the run
}

TEST_F(ScoreFile, DirectionsOfBothSidesAreTheSame) {
  const ScoreTable a = read(kHeader + "s,cube,v,1,crispness,0.5,higher,ok\n");
  const ScoreTable b = read(kHeader + "s,cube,v,1,crispness,0.5,lower,ok\n");
  EXPECT_THROW(pair_scores(a, b), InputError);
}

TEST_F(ScoreFile, RenamedVariantsArePairs) {
  ScoreTable a = read(kHeader + kRow);
  ScoreTable b = read(kHeader + "s,cube,w,1,iou3d_ellipsoid_mean,0.6,higher,ok\n");
  EXPECT_EQ(pair_scores(a, b).pairs.size(), 0u);
  rename_variant(a, "both");
  rename_variant(b, "both");
  EXPECT_EQ(pair_scores(a, b).pairs.size(), 1u);
  EXPECT_EQ(pair_scores(a, b).pairs[0].b, 0.6);
}

}  // namespace
}  // namespace uniquadric
