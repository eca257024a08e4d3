#include <fstream>
#include <sstream>

#include "evaluation/comparison/score_table.h"
#include "evaluation/metric.h"
#include "evaluation/report/poses.h"
#include "evaluation/results/lidar_routes.h"
#include "evaluation/results/results.h"
#include "evaluation/run_record.h"
#include "fuzz/target.h"

namespace uniquadric::fuzz {
namespace {
namespace fs = std::filesystem;

const char* const kEvaluation = R"({"schema": 1, "objects": [{"id": 1, "name": "a"}]})";
const char* const kFrames = "frame,timestamp_ns,object_id,name,iou3d\n0,0,1,a,0.5\n";

const Target evaluation_json("evaluation_json", "evaluation.json", [](const fs::path& file) {
  beside(file, "frames.csv", kFrames);
  read_cell_evaluation(file.parent_path());
});
const Target frames_csv("frames_csv", "frames.csv", [](const fs::path& file) {
  beside(file, "evaluation.json", kEvaluation);
  read_cell_evaluation(file.parent_path());
});
const Target poses_csv("poses_csv", "poses.csv", [](const fs::path& file) { read_poses(file); });
const Target cells_csv("cells_csv", "cells.csv", [](const fs::path& file) { read_cells(file); });
const Target scores_csv("scores_csv", "scores.csv", [](const fs::path& file) { read_score_table(file); });
const Target timing_csv("timing_csv", "timing.csv",
                        [](const fs::path& file) { read_timing(file.parent_path()); });
const Target run_yaml("run_yaml", "run.yaml",
                      [](const fs::path& file) { camera_was_given(read_run_config(file.parent_path())); });

void read_routes(const fs::path& file) {
  beside(file, "comparison.csv", "scan,beams,matched,lost,extra,mean_m,median_abs_m,p95_abs_m,rms_m\n");
  beside(file, "errors.csv", "from_m,to_m,beams\n");
  read_lidar_routes(file.parent_path(), "scene", 0);
}
const Target comparison_csv("lidar_comparison_csv", "comparison.csv", read_routes);
const Target errors_csv("lidar_errors_csv", "errors.csv", read_routes);

const Target metric("metric_jsonl", "lines.jsonl", [](const fs::path& file) {
  for (const char* kind : {"iou3d", "iou2d", "project", "pose"}) {
    std::ifstream in(file);
    std::ostringstream out;
    run_metric(kind, {}, in, out);
  }
});

}  // namespace
}  // namespace uniquadric::fuzz
