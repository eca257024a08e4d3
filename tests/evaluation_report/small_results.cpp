#include "tests/evaluation_report/small_results.h"

#include <fstream>

namespace uniquadric {

void write_file(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

void write_small_results(const std::filesystem::path& folder) {
  write_file(folder / "cells.csv",
             "scene,variant,seed,status,folder,message\n"
             "s,a,1,ok,cells/s/a/seed_1,\n"
             "s,b,1,failed,cells/s/b/seed_1,estimate: no depth, and <script> no colour\n");
  write_file(folder / "cells/s/a/seed_1/evaluation/evaluation.json", R"({
  "schema": 1,
  "program": "uniquadric 0.1.0",
  "objects": [
    {"id": 1, "name": "Cube", "coverage": 0.5, "id_switches": 2,
     "ape": {"translation_m": {"rmse": 0.1, "mean": 0.09}, "rotation_rad": null},
     "iou3d": {"mean": 0.30000000000000004}}
  ],
  "camera": {"ape": {"translation_m": {"rmse": 0}}}
})");
  write_file(folder / "cells/s/a/seed_1/evaluation/frames.csv",
             "frame,timestamp_ns,object_id,name,matched_id,ape_translation_m,iou3d\n"
             "0,1000000000,1,Cube,4,0.125,0.3\n"
             "1,1033333333,1,Cube,,,\n");
}

}  // namespace uniquadric
