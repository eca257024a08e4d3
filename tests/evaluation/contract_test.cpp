// What evaluate writes holds every figure that scores.csv promises.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/base/resource_usage.h"
#include "core/sequence/ply.h"
#include "evaluation/results/metrics.h"
#include "evaluation/results/results.h"
#include "tests/evaluation/evaluate_fixture.h"
#include "tests/evaluation/visibility_fixture.h"

namespace uniquadric {
namespace {

const std::set<std::string> kCamera = {"ape_translation_rmse_m",
                                       "ape_rotation_rmse_rad",
                                       "rpe_translation_rmse_m",
                                       "rpe_rotation_rmse_rad",
                                       "drift_max_translation_m",
                                       "drift_max_angle_deg",
                                       "coverage"};
const std::set<std::string> kObject = {"ape_translation_rmse_m",
                                       "ape_of_distance_rmse",
                                       "ape_rotation_rmse_rad",
                                       "ape_rotation_naive_rmse_rad",
                                       "rpe_translation_rmse_m",
                                       "rpe_rotation_rmse_rad",
                                       "ape_translation_in_view_rmse_m",
                                       "ape_rotation_in_view_rmse_rad",
                                       "rpe_translation_in_view_rmse_m",
                                       "rpe_rotation_in_view_rmse_rad",
                                       "iou2d_in_view_mean",
                                       "motion_error_translation_rmse_m",
                                       "motion_error_rotation_rmse_rad",
                                       "iou3d_solid_mean",
                                       "iou3d_solid_in_view_mean",
                                       "surface_f1",
                                       "chamfer_m",
                                       "iou3d_ellipsoid_mean",
                                       "iou3d_box_mean",
                                       "iou2d_mean",
                                       "iou2d_ellipse_mean",
                                       "ape_translation_after_3s_rmse_m",
                                       "ape_rotation_after_3s_rmse_rad",
                                       "rpe_translation_after_3s_rmse_m",
                                       "rpe_rotation_after_3s_rmse_rad",
                                       "iou3d_solid_after_3s_mean",
                                       "iou3d_after_3s_mean",
                                       "iou2d_after_3s_mean",
                                       "iou3d_from_40deg_mean",
                                       "semi_axes_change_occluded_max",
                                       "d_shape_mean_m",
                                       "surface_error_median_m",
                                       "surface_error_quantile_90_m",
                                       "surface_completeness",
                                       "feature_depth_median_m",
                                       "coverage",
                                       "longest_gap_s",
                                       "id_switches",
                                       "drift_max_translation_m",
                                       "drift_max_angle_deg"};
const std::set<std::string> kAll = {"hota",
                                    "mota",
                                    "idf1",
                                    "false_bodies",
                                    "size_spread_mean",
                                    "map_precision",
                                    "map_completeness",
                                    "frame_time_mean_ms",
                                    "wall_time_s",
                                    "cpu_time_s",
                                    "peak_memory_mb"};

class Contract : public VisibilityFixture {};

TEST_F(Contract, HasEveryFigureOfTheScores) {
  constexpr std::int64_t kSlow_ns = 200'000'000;  // 6 s
  constexpr double kWide_rad = 0.05;              // a frame: 83 degrees
  write_truth(kSlow_ns, kWide_rad);
  write_visibility([](int) { return View{}; }, kSlow_ns);
  write_changed([](Tracks& tracks) {
    for (auto& object : tracks.objects) object.states[9].status = ObjectStatus::occluded;
  });
  const SurfaceFile mesh{{{0, 0, 0.2F}, {0.2F, 0, 0}, {0, 0.2F, 0}, {0, 0, 0}},
                         {},
                         {{0, 1, 2}, {1, 0, 3}, {2, 1, 3}, {0, 2, 3}}};
  for (const char* id : {"1", "2", "3"}) {
    write_surface_ply(truth() / "objects" / (std::string(id) + ".ply"), mesh, "");
    write_surface_ply(estimate() / "objects" / (std::string(id) + "0.ply"), mesh, "");
  }
  std::string features = "frame,timestamp_ns,body,track,u_px,v_px,depth_m,depth_sigma_m\n";
  for (const auto& object : kObjects) {  // of its middle, in front of which the mesh is
    const Pose camera_from_object = camera_pose(0).inverse() * object_pose(object.id, 0, kWide_rad);
    const Eigen::Vector2d pixel = *Camera{}.project(camera_from_object * Eigen::Vector3d(0.06, 0.06, 0.08));
    features += fmt::format("0,0,{},1,{},{},3,0.01\n", 10 * object.id, pixel.x(), pixel.y());
  }
  write_text(estimate() / "features.csv", features);
  write_text(estimate() / "timing.csv", "frame,stage,ms\n0,fit,2\n1,fit,4\n");
  write_usage(estimate(), {2.5, 4, 100});
  run();
  const CellEvaluation read = read_cell_evaluation(root_ / "out");
  const auto names = [](const SubjectFigures& figures) {
    std::set<std::string> set;
    for (const auto& [name, value] : figures.value) set.insert(name);
    return set;
  };
  ASSERT_EQ(read.subjects.size(), 5u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(names(read.subjects[i]), kObject) << read.subjects[i].subject;
  EXPECT_EQ(read.subjects[3].subject, "camera");
  EXPECT_EQ(names(read.subjects[3]), kCamera);
  EXPECT_EQ(read.subjects[4].subject, "all");
  std::set<std::string> without_map = kAll;  // which needs a true one
  for (const char* name : {"map_precision", "map_completeness"}) without_map.erase(name);
  EXPECT_EQ(names(read.subjects[4]), without_map);
  for (const Metric& metric : all_metrics())
    EXPECT_TRUE(kObject.contains(metric.name) || kCamera.contains(metric.name) || kAll.contains(metric.name))
        << metric.name;
  EXPECT_EQ(read.alignment, "poses");
  EXPECT_EQ(read.subjects[0].value.at("iou3d_after_3s_mean"), 1);
  EXPECT_EQ(read.subjects[4].value.at("frame_time_mean_ms"), 3);
  EXPECT_EQ(read.subjects[4].value.at("cpu_time_s"), 4);
  EXPECT_EQ(read.subjects[4].value.at("peak_memory_mb"), 100);
}

}  // namespace
}  // namespace uniquadric
