#include "tests/evaluation_report/fabricated_results.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/base/random.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

struct FabricatedScene {
  const char* name;
  const char* objects[2];
};
constexpr FabricatedScene kScenes[] = {{"cube_cuboid", {"Cuboid", "Cube"}},
                                       {"skateboard_ball", {"SkateBoard", "Ball"}}};
constexpr const char* kVariants[] = {"single_frame_obb", "rotbbox"};

void write(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

json stats(double level) {
  return {{"rmse", level},     {"mean", level},    {"median", level}, {"std", level / 4},
          {"min", level / 10}, {"max", level * 4}, {"sse", level},    {"n", 300}};
}

json pose_error(double translation_m, double rotation_rad) {
  return {{"translation_m", stats(translation_m)}, {"rotation_rad", stats(rotation_rad)}};
}

json object_json(int id, const std::string& name, double error_m) {
  json ape = pose_error(error_m, 2 * error_m);
  ape["rotation_naive_rad"] = stats(4 * error_m);
  json surface = stats(error_m / 10);
  surface["quantile_90"] = error_m / 4;
  return {{"id", id},
          {"name", name},
          {"matched_id", id + 10},
          {"coverage", 0.98},
          {"id_switches", 1},
          {"longest_gap_s", 0.1},
          {"ape", ape},
          {"rpe", pose_error(error_m / 2, error_m)},
          {"motion_error", pose_error(error_m, error_m)},
          {"iou3d", stats(1 / (1 + error_m))},
          {"iou3d_solid", stats(1 / (1 + error_m / 4))},
          {"iou2d", stats(1 / (1 + error_m / 2))},
          {"iou2d_ellipse", stats(1 / (1 + error_m / 3))},
          {"d_shape_m", stats(error_m)},
          {"surface", {{"error_m", surface}, {"completeness", 0.6}, {"within_m", 0.03}}}};
}

std::string frames_csv(const FabricatedScene& scene, double error_m, std::uint64_t seed, int frames) {
  std::string text =
      "frame,timestamp_ns,object_id,name,matched_id,ape_translation_m,ape_rotation_rad,ape_rotation_naive_"
      "rad,iou3d,"
      "iou3d_stderr,iou2d,iou2d_ellipse,d_shape_m,est_semi_axis_x_m,est_semi_axis_y_m,est_semi_axis_z_m,"
      "true_semi_axis_x_m,true_semi_axis_y_m,true_semi_axis_z_m,rpe_translation_m,rpe_rotation_rad,arc_deg\n";
  for (int frame = 0; frame < frames; ++frame)
    for (int id = 1; id <= 2; ++id) {
      RandomStream random(seed, scene.name, static_cast<std::uint64_t>(frame),
                          static_cast<std::uint32_t>(id));
      const double e = error_m * (0.6 + 0.4 * std::sin(frame * 0.05 + id) + 0.3 * std::abs(random.normal()));
      text +=
          fmt::format("{},{},{},{},", frame, 1'000'000'000 + frame * 33'333'333LL, id, scene.objects[id - 1]);
      const bool lost = frame >= 120 && frame < 130 && id == 1;
      if (lost) {
        text += ",,,,,,,,,,,,0.2,0.15,0.1,,,\n";
        continue;
      }
      text += fmt::format("{},{},{},{},{},0.001,{},{},{},{},{},{},0.2,0.15,0.1,", id + 10, e, 2 * e, 4 * e,
                          1 / (1 + 4 * e), 1 / (1 + 2 * e), 1 / (1 + e), e, 0.2 + e * 0.3 * random.normal(),
                          0.15 + e * 0.2 * random.normal(), 0.1 + e * 0.2);
      text += frame == 0 ? ",," : fmt::format("{},{},", e / 2, e);
      text += fmt::format("{}\n", 0.9 * frame);
    }
  return text;
}

std::string pose_row(const char* source, const char* subject, int id, int frame, double x_m, double y_m,
                     double turn_rad, const std::string& axes_m) {
  return fmt::format("{},{},{},{},{},{},0.5,0,0,{},{},{}\n", source, subject, id,
                     1'000'000'000 + frame * 33'333'333LL, x_m, y_m, std::sin(turn_rad / 2),
                     std::cos(turn_rad / 2), axes_m);
}

// Objects on two lines, estimated `error_m` to the side and as much too large; the camera behind them.
std::string poses_csv(double error_m, int frames) {
  std::string text =
      "source,subject,id,timestamp_ns,x_m,y_m,z_m,qx,qy,qz,qw,semi_axis_x_m,semi_axis_y_m,semi_axis_z_m,"
      "outline,upper,lower,profile_axis,sigma_x_m,sigma_y_m,sigma_z_m\n";
  for (int frame = 0; frame < frames; ++frame)
    for (const char* source : {"truth", "estimate"}) {
      const bool estimated = source[0] == 'e';
      const double off_m = estimated ? error_m : 0;
      text += fmt::format("{},camera,0,{},{},-2,0.8,-0.7071067811865476,0,0,0.7071067811865476,,,,,,,,,,\n",
                          source, 1'000'000'000 + frame * 33'333'333LL, 0.001 * frame);
      for (int id = 1; id <= 2; ++id)
        if (!estimated || id == 2 || frame < 120 || frame >= 130)
          text += pose_row(source, "object", id, frame, 0.01 * frame - 1, 0.8 * id + off_m, 0.01 * frame,
                           fmt::format("{},0.15,0.1,{}", 0.2 + off_m,
                                       id == 1 ? "1.5,2,1.2,0,0.01,0.02,0.03" : "1,1,1,2,,,"));
      if (estimated && frame < 10)
        text += pose_row(source, "unmatched", 7, frame, 1, 1, 0, "0.1,0.1,0.1,2,2,2,2,,,");
    }
  return text;
}

void write_picture(const fs::path& path, int frame, int width) {
  cv::Mat image(width * 3 / 4, width, CV_8UC3, cv::Scalar(70, 80, 90));
  const cv::Point center(width / 4 + frame * width / 600, width * 3 / 8);
  cv::ellipse(image, center, {width / 6, width / 10}, frame, 0, 360, {60, 220, 80}, 2, cv::LINE_AA);
  cv::ellipse(image, center + cv::Point(width / 60, 2), {width / 6, width / 9}, frame, 0, 360, {0, 140, 255},
              2, cv::LINE_AA);
  cv::imwrite(path.string(), image);
}

// A camera of 640 x 480, of which pictures are as wide as the options say.
void write_scenery(const fs::path& folder, const FabricatedOptions& options) {
  fs::create_directories(folder / "frames");
  json frames = json::array();
  for (int frame = 0; frame < options.frames; frame += 10) {
    write_picture(folder / fmt::format("frames/{:06}.jpg", frame), frame, options.image_width_px);
    frames.push_back({{"frame", frame}, {"stamp_ns", 1'000'000'000 + frame * 33'333'333LL}});
  }
  const json camera = {{"width", 640}, {"height", 480}, {"fx", 525}, {"fy", 520}, {"cx", 320.5}, {"cy", 238}};
  const json cloud = {{"positions_mm", {0, 0, 0, 500, 0, 500}}, {"colors", {0xff0000, 0x00ff00}}};
  const json tetrahedron = {{"id", 1},
                            {"positions_mm", {200, 0, 0, -200, 150, 0, -200, -150, 0, 0, 0, 100}},
                            {"triangles", {0, 1, 3, 1, 2, 3, 2, 0, 3, 0, 2, 1}}};
  write(folder / "scenery.json",
        json{{"camera", camera}, {"frames", frames}, {"meshes", {tetrahedron}}, {"cloud", cloud}}.dump());
}

void write_cell(const fs::path& folder, const FabricatedScene& scene, double error_m, std::uint64_t seed,
                const FabricatedOptions& options) {
  fs::create_directories(folder / "evaluation");
  fs::create_directories(folder / "overlays");
  json root = {{"schema", 1}, {"program", "uniquadric 0.1.0"}, {"config", "none"}, {"seed", seed}};
  root["objects"] = {object_json(1, scene.objects[0], error_m), object_json(2, scene.objects[1], error_m)};
  root["camera"] = {{"ape", pose_error(0.002, 0.001)}, {"rpe", pose_error(0.001, 0.001)}, {"coverage", 1}};
  root["alignment"] = {{"kind", "poses"}};
  root["tracking"] = {{"hota", 0.9}, {"mota", 0.95}, {"idf1", 0.97}};
  root["timing_ms"] = {{"frame", stats(12.5)}, {"features", stats(8)}, {"long_window", stats(9)}};
  root["timing_ms"]["long_window"]["n"] = 150;  // every other frame
  write(folder / "evaluation/evaluation.json", root.dump(1));
  write(folder / "evaluation/frames.csv", frames_csv(scene, error_m, seed, options.frames));
  write(folder / "evaluation/poses.csv", poses_csv(error_m, options.frames));
  for (int i = 0; i < options.overlays; ++i) {
    const int frame = i * (options.frames - 1) / std::max(1, options.overlays - 1);
    write_picture(folder / "overlays" / fmt::format("{:06}.jpg", frame), frame, options.image_width_px);
  }
}

}  // namespace

void fabricate_results(const fs::path& folder, const FabricatedOptions& options) {
  fs::create_directories(folder);
  std::string cells = "scene,variant,seed,status,folder,message\n";
  for (const FabricatedScene& scene : kScenes)
    for (const char* variant : kVariants)
      for (int seed = 1; seed <= options.seeds; ++seed) {
        const bool last = &scene == &kScenes[1] && variant == kVariants[1] && seed == options.seeds;
        const bool failed = last && options.with_failure;
        const std::string cell = fmt::format("cells/{}/{}/seed_{}", scene.name, variant, seed);
        cells += fmt::format("{},{},{},{},{},{}\n", scene.name, variant, seed, failed ? "failed" : "ok", cell,
                             failed ? "estimate: frame 12: depth is 640x480; camera says <1280x720>" : "");
        const double error_m = (variant == kVariants[0] ? 0.5 : 0.01) * seed;
        if (!failed) write_cell(folder / cell, scene, error_m, static_cast<std::uint64_t>(seed), options);
      }
  for (const FabricatedScene& scene : kScenes) write_scenery(folder / "scenery" / scene.name, options);
  write(folder / "cells.csv", cells);
  write(folder / "bench.yaml", "name: fabricated\nscenes: [cube_cuboid, skateboard_ball]\nseeds: [1, 2]\n");
  write(folder / "command.txt", "uniquadric bench configs/bench/fabricated.yaml out\n");
  write(folder / "hardware.txt", "Test processor, 2 threads\n");
  write(folder / "program.txt", "uniquadric 0.1.0, commit 0123abcd, changed since\n");
  write(
      folder / "variants.csv",
      "name,description\nsingle_frame_obb,Boxes\nrotbbox,\"Rotated rectangles, \"\"quoted\"\" & <kept>.\"\n");
  write(folder / "inputs.csv", "kind,name,hash\nbench,fabricated,00112233\nscene,cube_cuboid,44556677\n");
}

}  // namespace uniquadric
