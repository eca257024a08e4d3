#include <gtest/gtest.h>

#include "core/base/files.h"
#include "evaluation/report/report.h"
#include "evaluation/results/results.h"
#include "tests/evaluation_report/small_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

const char* const kEvaluation = "cells/s/a/seed_1/evaluation/evaluation.json";
const char* const kOverlay = "cells/s/a/seed_1/overlays/000000.jpg";
const char* const kFrames = "cells/s/a/seed_1/evaluation/frames.csv";
const char* const kPoses = "cells/s/a/seed_1/evaluation/poses.csv";
const char* const kScenery = "scenery/s/scenery.json";
const std::string kPosesHeader =
    "source,subject,id,timestamp_ns,x_m,y_m,z_m,qx,qy,qz,qw,semi_axis_x_m,semi_axis_y_m,semi_axis_z_m\n";
const std::string kCellsHeader = "scene,variant,seed,status,folder,message\n";

// A scenery.json with these lists.
std::string scenery(const std::string& frames, const std::string& meshes = "[]",
                    const std::string& cloud = "{}") {
  return R"({"camera": {"width": 4, "height": 3, "fx": 2, "fy": 2, "cx": 2, "cy": 1.5}, "frames": )" +
         frames + R"(, "meshes": )" + meshes + R"(, "cloud": )" + cloud + "}";
}

// A file of the small results folder with other content, and what the message must hold.
struct BadFile {
  const char* file;
  std::string content;
  std::string message;
};

const BadFile kBadFiles[] = {
    {"cells.csv", "", "cells.csv: is empty"},
    {"cells.csv", "scene,variant\n", "cells.csv:1: expected the header"},
    {"cells.csv", kCellsHeader + "s,a,1,ok\n", "cells.csv:2: expected 6 columns"},
    {"cells.csv", kCellsHeader + "s,a,one,ok,x,\n", "cells.csv:2: seed 'one'"},
    {"cells.csv", kCellsHeader + "s,a,1,fine,x,\n", "cells.csv:2: status 'fine'"},
    {"cells.csv", kCellsHeader + "s,a,1,failed,x,\ns,a,1,failed,x,\n",
     "cells.csv:3: this scene, variant and seed"},
    {"cells.csv", kCellsHeader + "s,a@final,1,failed,x,\n",
     "cells.csv:2: 'a@final': an @ in a variant's name"},
    {"cells.csv", kCellsHeader + "s,a,1,ok,/etc,\n", "cells.csv:2: folder is not relative"},
    {"cells.csv", kCellsHeader + "s,a,1,ok,x/../..,\n", "cells.csv:2: folder leads out of"},
    {kOverlay, "\xff\xd8 cut", "000000.jpg: is no whole JPEG image"},
    {"inputs.csv", "name,hash\n", "inputs.csv:1: expected the columns kind,name,hash"},
    {"inputs.csv", "kind,name,hash\nscene,a\n", "inputs.csv:2: expected the columns kind,name,hash"},
    {kEvaluation, "{\n\"schema\": 1,\n oops}", "evaluation.json:3: is not valid JSON"},
    {kEvaluation, "[]", "evaluation.json: expected an object"},
    {kEvaluation, "{\n\"schema\": 1e999\n}", "evaluation.json:2: schema holds a number"},
    {kEvaluation, "{\"schema\": 1,\n\"objects\": [{\"id\": 1,\n\"id\": 2}]}",
     "evaluation.json:3: key \"id\" stands twice"},
    {kEvaluation, "{\"schema\": 1,\n\n\"objects\": [{\"id\": 9007199254740993}]}",
     "evaluation.json:3: id 9007199254740993 is beyond 2^53"},
    {kEvaluation, "{\"objects\": []}", "evaluation.json: field schema"},
    {kEvaluation, "{\"schema\": 2, \"objects\": []}", "evaluation.json: field schema"},
    {kEvaluation, "{\"schema\": 1}", "evaluation.json: field objects: expected a list"},
    {kEvaluation, R"({"schema": 1, "objects": [{"name": "x"}]})", "field objects[0].id: expected an integer"},
    {kEvaluation, R"({"schema": 1, "objects": [{"id": 1, "name": 3}]})",
     "field objects[0].name: expected a text"},
    {kEvaluation, R"({"schema": 1, "objects": [{"id": 1, "ape": {"translation_m": {"rmse": "far"}}}]})",
     "field objects[0].ape.translation_m.rmse: expected a number"},
    {kEvaluation, R"({"schema": 1, "objects": [{"id": 1, "iou3d": {"mean": 1.5}}]})",
     "evaluation.json: field objects[0].iou3d.mean: 1.5 is more than 1"},
    {kEvaluation, R"({"schema": 1, "objects": [{"id": 1, "iou2d": {"mean": -0.5}}]})",
     "evaluation.json: field objects[0].iou2d.mean: -0.5 is below 0"},
    {kEvaluation, R"({"schema": 1, "objects": [], "camera": {"coverage": 2}})",
     "evaluation.json: field camera.coverage: 2 is more than 1"},
    {kEvaluation, R"({"schema": 1, "objects": [{"id": 1, "ape": {"translation_m": {"rmse": -1}}}]})",
     "evaluation.json: field objects[0].ape.translation_m.rmse: -1 is below 0"},
    {kEvaluation, R"({"schema": 1, "objects": [{"id": 1, "ape": 3}]})",
     "field objects[0].ape: expected an object"},
    {kFrames, "", "frames.csv: is empty"},
    {kFrames, "frame,object_id\n", "frames.csv:1: expected a header with the column timestamp_ns"},
    {kFrames, "frame,timestamp_ns,object_id,iou3d\n0,5,1\n", "frames.csv:2: expected 4 columns, found 3"},
    {kFrames, "frame,timestamp_ns,object_id,iou3d\n0,5,1,nan\n", "frames.csv:2: column iou3d: 'nan'"},
    {kFrames, "frame,timestamp_ns,object_id,iou3d\n0,5.5,1,0\n", "frames.csv:2: column timestamp_ns: '5.5'"},
    {kFrames, "frame,timestamp_ns,object_id\n0,5,7\n", "frames.csv:2: object 7 is not in evaluation.json"},
    {kFrames, "frame,timestamp_ns,object_id\n0,5,1\n1,5,1\n",
     "frames.csv:3: timestamp 5 does not come after 5"},
    {kPoses, "", "poses.csv: is empty"},
    {kPoses, "source,id\n", "poses.csv:1: expected the header"},
    {kPoses, kPosesHeader + "truth,camera,0,5\n", "poses.csv:2: expected 14 columns, found 4"},
    {kEvaluation, R"({"schema": 1, "objects": [], "camera": []})",
     "evaluation.json: field camera: expected an object"},
    {kEvaluation, R"({"schema": 1, "objects": [], "tracking": [1]})", "field tracking: expected an object"},
    {kEvaluation, R"({"schema": 1, "objects": [{"id": 1, "name": )" + std::string(100'000, '['),
     "nested more than 64"},
    {kPoses, kPosesHeader + "guess,camera,0,5,0,0,0,0,0,0,1,,,\n", "poses.csv:2: column source: 'guess'"},
    {kPoses, kPosesHeader + "truth,unmatched,1,5,0,0,0,0,0,0,1,1,1,1\n",
     "poses.csv:2: column subject: 'unmatched'"},
    {kPoses, kPosesHeader + "truth,camera,0,5,0,0,0,0,0,0,2,,,\n",
     "poses.csv:2: column qx: '0' is of a quaternion"},
    {kPoses, kPosesHeader + "truth,camera,0,5,0,nan,0,0,0,0,1,,,\n", "poses.csv:2: column y_m: 'nan'"},
    {kPoses, kPosesHeader + "truth,camera,0,5,0,0,0,0,0,0,1,,,\ntruth,camera,0,5,0,0,0,0,0,0,1,,,\n",
     "poses.csv:3: column timestamp_ns: '5' is not after"},
    {kScenery, std::string(1'000'000, '['), "scenery.json:1: is nested more than 64"},
    {kScenery, "[]", "scenery.json: expected an object with camera"},
    {kScenery, R"({"camera": null})", "field camera: expected an object"},
    {kScenery, R"({"camera": {"width": 0}})", "field camera.width: expected a positive number"},
    {kScenery, scenery("[1]"), "field frames[0]: expected an object"},
    {kScenery, scenery(R"([{"frame": 1, "stamp_ns": "x"}])"), "field frames[0].stamp_ns: expected a whole"},
    {kScenery, scenery("[]", R"([{"id": 1, "positions_mm": [1, 2, 3], "triangles": [0, 0, 1]}])"),
     "field meshes[0].triangles[2]: expected the index of a point"},
    {kScenery, scenery("[]", R"([{"id": 1, "positions_mm": "x", "triangles": []}])"),
     "field meshes[0].positions_mm: expected a list"},
    {kScenery, scenery("[]", "[]", "[1, 2]"), "field cloud: expected an object"},
    {kScenery, scenery("[]", "[]", R"({"positions_mm": [1, 2, 3], "colors": []})"),
     "field cloud.colors: expected one colour a point"},
    {kPoses, kPosesHeader + "estimate,object,1,5,0,0,0,0,0,0,1,1,0,1\n",
     "poses.csv:2: column semi_axis_x_m: '1' is of semi-axes"},
};

TEST(ReportInput, NamesFileAndLineOrFieldAndWritesNothing) {
  int cases = 0;
  for (const BadFile& bad : kBadFiles) {
    const TempFolder folder;
    write_small_results(folder.path());
    write_file(folder.path() / bad.file, bad.content);
    const std::string message = input_error([&] { write_report(folder.path()); });
    EXPECT_NE(message.find(bad.message), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
    for (const char* file : {"report.html", "report.md", "scores.csv"})
      EXPECT_FALSE(fs::exists(folder.path() / file));
    ++cases;
  }
  EXPECT_EQ(cases, 57);
}

TEST(ReportInput, FolderThatIsNoResultsFolder) {
  const TempFolder folder;
  EXPECT_NE(input_error([&] { write_report(folder.path()); }).find("is no results folder"),
            std::string::npos);
  EXPECT_NE(input_error([&] { write_report(folder.path() / "none"); }).find("is not a folder"),
            std::string::npos);
}

TEST(ReportInput, AFolderInTheWayOfTheReportIsFoundBeforeAnyFileIsWritten) {
  const TempFolder folder;
  write_small_results(folder.path());
  fs::create_directory(folder.path() / "report.html");
  EXPECT_NE(input_error([&] { write_report(folder.path()); }).find("report.html: is a folder, in the way of"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(folder.path() / "scores.csv"));
  fs::remove(folder.path() / "report.html");
  write_report(folder.path());
}

TEST(ReportInput, GoodRunWithoutItsEvaluation) {
  const TempFolder folder;
  write_small_results(folder.path());
  fs::remove(folder.path() / kEvaluation);
  EXPECT_NE(input_error([&] { summary_table(folder.path()); }).find("evaluation.json: cannot be read"),
            std::string::npos);
}

TEST(ReportInput, ReadsWhatIsThere) {
  const TempFolder folder;
  write_small_results(folder.path());
  const Results results = read_results(folder.path());
  ASSERT_EQ(results.cells.size(), 2u);
  EXPECT_EQ(results.cells[1].status, CellStatus::failed);
  EXPECT_EQ(results.cells[1].message,
            "estimate: no depth, and <script> no colour");  // commas are the message's own
  const CellEvaluation& evaluation = results.cells[0].evaluation.value();
  ASSERT_EQ(evaluation.series.size(), 1u);
  EXPECT_EQ(evaluation.series[0].subject, "cube");
  EXPECT_EQ(evaluation.series[0].stamps_ns, (std::vector<std::int64_t>{1000000000, 1033333333}));
  EXPECT_EQ(evaluation.series[0].columns.at("ape_translation_m"),
            (std::vector<std::optional<double>>{0.125, std::nullopt}));
}

TEST(ReportInput, ObjectsWithoutANameOrWithOneThatStandsTwice) {
  const TempFolder folder;
  write_small_results(folder.path());
  write_file(
      folder.path() / kEvaluation,
      R"({"schema": 1, "objects": [{"id": 1, "name": "Car"}, {"id": 2, "name": "car"}, {"id": 3, "name": ""}]})");
  write_file(folder.path() / kFrames, "frame,timestamp_ns,object_id\n");
  EXPECT_EQ(subjects_of(read_results(folder.path()), "s"),
            (std::vector<std::string>{"car_1", "car_2", "object_3"}));
}

}  // namespace
}  // namespace uniquadric
