#include "evaluation/results/lidar_routes.h"

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "evaluation/report/page.h"
#include "evaluation/report/report.h"
#include "tests/evaluation_report/small_results.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

const std::string kComparison =
    "scan,beams,matched,lost,extra,mean_m,median_abs_m,p95_abs_m,rms_m\n"
    "0,110,90,10,10,0.02,0.02,0.2,0.1\n"
    "1,100,30,70,0,-0.03,0.04,0.4,0.2\n"
    "2,0,0,0,0,0,0,0,0\n";
const std::string kErrors = "from_m,to_m,beams\n,-0.01,12\n-0.01,0.01,100\n0.01,,8\n";
const std::string kTiming = "stage,count,ms_each\nframes,4,20\nlidar_octree,3,90\nlidar_embree,3,7.5\n";

void write_routes(const fs::path& results) {
  write_small_results(results);
  write_file(results / "lidar/s/seed_1/comparison.csv", kComparison);
  write_file(results / "lidar/s/seed_1/errors.csv", kErrors);
  write_file(results / "lidar/s/seed_1/timing.csv", kTiming);
}

TEST(LidarRoutes, AreSummedOverScans) {
  const TempFolder folder;
  write_routes(folder.path());
  const LidarRoutes routes = read_lidar_routes(folder.path() / "lidar/s/seed_1", "s", 1).value();
  EXPECT_EQ(routes.scans, 3);
  EXPECT_EQ(routes.beams, 210);
  EXPECT_EQ(routes.extra, 10);
  EXPECT_EQ(routes.completeness(), 120.0 / 200);
  EXPECT_NEAR(routes.mean_m, (90 * 0.02 - 30 * 0.03) / 120, 1e-15);
  EXPECT_NEAR(routes.rms_m, std::sqrt((90 * 0.01 + 30 * 0.04) / 120), 1e-15);
  EXPECT_EQ(routes.median_abs_m, 0.02);  // of 0, 0.02, 0.04
  EXPECT_EQ(routes.p95_abs_m, 0.2);
  EXPECT_EQ(routes.speed_ratio(), 12);
  EXPECT_EQ(routes.beyond(), 20);
  fs::remove(folder.path() / "lidar/s/seed_1/timing.csv");
  EXPECT_FALSE(read_lidar_routes(folder.path() / "lidar/s/seed_1", "s", 1)->speed_ratio());
  EXPECT_FALSE(read_lidar_routes(folder.path(), "s", 1));
}

TEST(LidarRoutes, StandInBothReports) {
  const TempFolder folder;
  write_routes(folder.path());
  write_report(folder.path());
  const std::string text = read_text(folder.path() / "report.md");
  EXPECT_NE(text.find("| s | 1 | 3 | 0.6000 | 10 | 0.0075 |"), std::string::npos) << text;
  EXPECT_NE(text.find("| 90.00 | 7.500 | 12.00 |"), std::string::npos) << text;
  const Results results = read_results(folder.path());
  const json lidar = json::parse(page_data(results, summarize(results), {}, {})).at("lidar");
  ASSERT_EQ(lidar.size(), 1u);
  EXPECT_EQ(lidar[0].at("completeness"), 0.6);
  EXPECT_EQ(lidar[0].at("speed_ratio"), 12);
  EXPECT_EQ(lidar[0].at("errors"), json::parse("[[0.0, 100]]"));  // the cells that have both ends
  EXPECT_NE(read_text(folder.path() / "report.html").find("id=\"lidar-table\""), std::string::npos);
}

TEST(LidarRoutes, AreLeftOutWhereNoSceneHasThem) {
  const TempFolder folder;
  write_small_results(folder.path());
  write_report(folder.path());
  EXPECT_EQ(read_text(folder.path() / "report.md").find("LiDAR"), std::string::npos);
}

TEST(LidarRoutes, RefuseBadFilesByLine) {
  struct BadFile {
    const char* file;
    std::string content, message;
  };
  const std::vector<BadFile> cases = {
      {"comparison.csv", "", "comparison.csv: is empty"},
      {"comparison.csv", "scan\n", "comparison.csv:1: expected the header"},
      {"comparison.csv", kComparison + "3,1\n", "comparison.csv:5: expected 9 columns, found 2"},
      {"comparison.csv", kComparison + "3,1,-1,0,0,0,0,0,0\n", "comparison.csv:5: '-1' is no whole number"},
      {"comparison.csv", kComparison + "3,1,1,0,0,nan,0,0,0\n", "comparison.csv:5: 'nan' is not a finite"},
      {"errors.csv", kErrors + "0.2,0.3,1\n", "errors.csv:5: a cell begins where"},
      {"timing.csv", "stage,count,ms_each\nlidar_octree,3,slow\n", "timing.csv:2: 'slow' is not"}};
  for (const BadFile& bad : cases) {
    const TempFolder folder;
    write_routes(folder.path());
    write_file(folder.path() / "lidar/s/seed_1" / bad.file, bad.content);
    const std::string message = input_error([&] { write_report(folder.path()); });
    EXPECT_NE(message.find(bad.message), std::string::npos) << message;
    EXPECT_FALSE(fs::exists(folder.path() / "report.html"));
  }
}

}  // namespace
}  // namespace uniquadric
