#include <CLI/CLI.hpp>
#include <memory>

#include "core/base/apart.h"
#include "core/base/text.h"
#include "core/import/bop.h"
#include "core/import/euroc.h"
#include "core/import/kitti.h"
#include "core/import/omd.h"
#include "core/import/tum.h"
#include "harness/commands/commands.h"
#include "harness/commands/options.h"
#include "harness/rosbag/import_rosbag.h"

namespace uniquadric {
namespace {

constexpr double kMostOffset_s = 4e9;

// A number of seconds between two clocks that both count from 1970 or from their start.
const CLI::Validator kOffset(
    [](const std::string& text) {
      const auto value = parse_double(text);
      return value && *value >= -kMostOffset_s && *value <= kMostOffset_s
                 ? std::string()
                 : "'" + text + "' is no number of seconds from -4e9 to 4e9";
    },
    "");

// What all have: SRC, OUT, --force. `run` is called with them once they are known to lie apart.
template <typename Options, typename Run>
CLI::App* layout(CLI::App& app, const char* name, const char* what, const char* source_holds,
                 const char* out_is, Options& options, Common& common, const Run& run) {
  auto* sub = subcommand(app, name, what, common);
  struct Paths {
    std::string source, out;
  };
  auto paths = std::make_shared<Paths>();
  sub->add_option("SRC", paths->source, source_holds)->required();
  sub->add_option("OUT", paths->out, out_is)->required();
  add_force(sub, common);
  sub->callback([paths, run, &options, &common] {
    options.quiet = common.quiet;
    options.force = common.force;
    require_apart(paths->out, {paths->source});
    run(paths->source, paths->out);
  });
  return sub;
}

void add_tum(CLI::App& app, Common& common) {
  static ImportTumOptions options;
  static std::string camera;
  layout(app, "tum", "a TUM RGB-D recording", "folder with rgb.txt, depth.txt", "sequence folder", options,
         common,
         [](const std::string& source, const std::string& out) {
           options.camera = camera;
           require_apart(out, {camera});
           import_tum(source, options, out);
         })
      ->add_option("--camera", camera, "calibration; default: SRC/camera.yaml");
}

void add_kitti(CLI::App& app, Common& common) {
  static ImportKittiOptions options;
  layout(
      app, "kitti-tracking", "a recording of KITTI's tracking benchmark",
      "folder with image_02/ or velodyne/, calib/, ...", "folder for sequence/ and, of poses, truth/",
      options, common,
      [](const std::string& source, const std::string& out) { import_kitti_tracking(source, options, out); })
      ->add_option("--drive", options.drive, "which recording (0000); default: the only one");
}

void add_euroc(CLI::App& app, Common& common) {
  static ImportEurocOptions options;
  static std::string depth = "stereo";
  layout(app, "euroc", "a recording of the EuRoC MAV datasets", "folder with mav0/",
         "folder for sequence/ and, of its states, truth/", options, common,
         [](const std::string& source, const std::string& out) {
           options.stereo_depth = depth == "stereo";
           import_euroc(source, options, out);
         })
      ->add_option("--depth", depth,
                   "stereo: of cam0 and cam1, images rectified; none: cam0's as they are; default: stereo")
      ->check(CLI::IsMember({"stereo", "none"}));
}

void add_omd(CLI::App& app, Common& common) {
  static ImportOmdOptions options;
  static std::string calibration, objects, depth = "disparity";
  auto* sub =
      layout(app, "omd", "a recording of the Oxford Multimotion Dataset",
             "folder with rgbd/ (raw) or image_0/ (processed)", "folder for sequence/ and, of poses, truth/",
             options, common, [](const std::string& source, const std::string& out) {
               options.calibration = calibration;
               options.objects = objects;
               options.metric_depth = depth == "metric";
               require_apart(out, {calibration, objects});
               import_omd(source, options, out);
             });
  sub->add_option(
      "--calibration", calibration,
      "raw: folder of kalibr*.yaml, vicon*.yaml; processed: settings; default: beside the images");
  sub->add_option("--objects", objects, "sizes of the bodies, an objects.yaml; default: no objects' truth");
  sub->add_option("--vicon-offset", options.vicon_offset_s, "raw: added to the Vicon's stamps [s]")
      ->check(kOffset);
  sub->add_option("--depth", depth, "processed: what depth/ holds; default: disparity")
      ->check(CLI::IsMember({"disparity", "metric"}));
}

void add_bop(CLI::App& app, Common& common) {
  static ImportBopOptions options;
  static std::string models;
  auto* sub = layout(app, "bop", "a scene of the BOP challenge",
                     "folder with scene_camera.json, rgb/ or gray/, scene_gt.json, ...",
                     "folder for sequence/ and, of poses, truth/", options, common,
                     [](const std::string& source, const std::string& out) {
                       options.models = models;
                       require_apart(out, {models});
                       import_bop(source, options, out);
                     });
  sub->add_option("--models", models,
                  "folder with models_info.json; default: models/ or models_eval/ of the dataset");
  sub->add_option("--rate", options.rate_hz, "images a second, by their numbers [Hz]; default: 30")
      ->check(CLI::Range(1e-3, 1e4));
}

void add_rosbag(CLI::App& app, Common& common) {
  static ImportRosbagOptions options;
  static std::string objects;
  auto* sub = layout(app, "rosbag", "a ROS 1 bag", "file .bag", "folder for sequence/ and, of poses, truth/",
                     options, common, [](const std::string& source, const std::string& out) {
                       options.objects = objects;
                       require_apart(out, {objects});
                       import_rosbag(source, options, out);
                     });
  const auto add_topic = [&](const char* option, std::string& topic, const char* what) {
    sub->add_option(option, topic, std::string(what) + "; default: the only topic of its type");
  };
  add_topic("--rgb-topic", options.topics.rgb, "colour, Image or CompressedImage");
  add_topic("--depth-topic", options.topics.depth, "depth, Image of 16UC1 (mm) or 32FC1 (m)");
  sub->add_option("--camera-info-topic", options.topics.camera_info,
                  "calibration, CameraInfo; default: camera_info beside the colour topic, else the only one");
  add_topic("--imu-topic", options.topics.imu, "Imu");
  add_topic("--lidar-topic", options.topics.lidar, "scans, PointCloud2 or Livox CustomMsg");
  sub->add_option("--objects", objects,
                  "sizes of the objects of /truth/object_ID, an objects.yaml; default: no objects' truth");
}

}  // namespace

void add_import(CLI::App& app, Common& common) {
  auto* sub = app.add_subcommand("import", "a real recording -> sequence");
  sub->require_subcommand(1);
  for (const auto add : {add_kitti, add_tum, add_omd, add_euroc, add_bop, add_rosbag}) add(*sub, common);
}

}  // namespace uniquadric
