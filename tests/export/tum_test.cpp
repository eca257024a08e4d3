#include <opencv2/core.hpp>

#include "core/import/tum.h"
#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kDepthTolerance_m = 1e-6;  // a whole number of either unit, divided in single precision

TEST_F(Export, TumImportsAsTheSameSequence) {
  const fs::path out = run("tum"), imported_folder = folder() / "imported";
  ImportTumOptions options;
  options.quiet = true;
  import_tum(out, options, imported_folder);
  const Sequence imported = open_sequence(imported_folder);
  ASSERT_EQ(imported.frames.size(), sequence_.frames.size());
  EXPECT_EQ(imported.camera.matrix(), sequence_.camera.matrix());
  ASSERT_TRUE(imported.given_camera);
  ASSERT_EQ(imported.given_camera->size(), truth_.camera.size());
  for (std::size_t i = 0; i < imported.frames.size(); ++i) {
    EXPECT_EQ(imported.frames[i].stamp_ns, sequence_.frames[i].stamp_ns);
    EXPECT_EQ(cv::norm(read_rgb(imported, imported.frames[i]), read_rgb(sequence_, sequence_.frames[i])), 0);
    EXPECT_LT(cv::norm(read_depth(imported, imported.frames[i]), read_depth(sequence_, sequence_.frames[i]),
                       cv::NORM_INF),
              kDepthTolerance_m);
    EXPECT_TRUE((*imported.given_camera)[i].pose.matrix() == truth_.camera[i].pose.matrix());
  }
}

TEST_F(Export, TumWritesWorldFromCameraInSecondsAndMetres) {
  const fs::path out = run("tum");
  const auto poses = table(out / "groundtruth.txt", ' '), rgb = table(out / "rgb.txt", ' ');
  ASSERT_EQ(poses.size(), 4u);
  ASSERT_EQ(rgb.size(), 4u);
  EXPECT_EQ(rgb[2], (std::vector<std::string>{"0.200000000", "rgb/0.200000000.png"}));
  const auto p = numbers(poses[2]);
  ASSERT_EQ(p.size(), 8u);
  EXPECT_DOUBLE_EQ(p[0], 0.2);
  const Pose& pose = truth_.camera[2].pose;
  EXPECT_TRUE(Eigen::Vector3d(p[1], p[2], p[3]) == pose.translation);
  EXPECT_TRUE(Eigen::Vector4d(p[4], p[5], p[6], p[7]) == pose.rotation.coeffs());  // x y z w
}

TEST_F(Export, TumScalesDepthTo5000AMetreAndDropsWhatDoesNotFit) {
  const fs::path file = sequence_.frames[0].depth;
  cv::Mat depth(sequence_.camera.height, sequence_.camera.width, CV_16U, cv::Scalar(0));
  depth.at<std::uint16_t>(3, 5) = 2500;   // 2.5 m
  depth.at<std::uint16_t>(4, 5) = 13107;  // the last millimetre that fits
  depth.at<std::uint16_t>(5, 5) = 13108;
  write_png(sequence_.folder / file, depth);
  sequence_.depth_units_per_m = 1000;
  rewrite_index();
  const cv::Mat exported = read_image(run("tum") / "depth/0.000000000.png");
  EXPECT_EQ(exported.at<std::uint16_t>(3, 5), 12500);
  EXPECT_EQ(exported.at<std::uint16_t>(4, 5), 65535);
  EXPECT_EQ(cv::countNonZero(exported), 2);
}

TEST_F(Export, RefusesUnknownFormatsAndBrokenInput) {
  const fs::path out = folder() / "out";
  const auto refused = [&](const std::string& format, const fs::path& sequence, ExportOptions options) {
    options.quiet = true;
    const std::string what = input_error([&] { export_sequence(format, sequence, out, options); });
    EXPECT_FALSE(fs::exists(out));
    EXPECT_FALSE(fs::exists(folder() / "out.partial"));
    return what;
  };
  EXPECT_NE(
      refused("tumm", sequence_.folder, {}).find("'tumm' is none of tum, kitti-tracking, bop, euroc, rosbag"),
      std::string::npos);
  ExportOptions no_truth;
  no_truth.truth = folder() / "none";
  EXPECT_NE(refused("tum", sequence_.folder, no_truth).find("none: is not a folder"), std::string::npos);
  fs::resize_file(sequence_.folder / sequence_.frames[2].rgb, 1000);
  int formats = 0;
  for (const std::string& format : export_formats()) {
    ExportOptions options;
    options.frame_stride = 1;
    EXPECT_NE(refused(format, sequence_.folder, options).find("truncated"), std::string::npos) << format;
    ++formats;
  }
  EXPECT_EQ(formats, 8);
}

TEST_F(Export, EveryFormatIsTheSameBytesTwiceAndWorksWithoutTruth) {
  ExportOptions options;
  options.quiet = true;
  int formats = 0;
  for (const std::string& format : export_formats()) {
    export_sequence(format, sequence_.folder, folder() / "a", options);
    export_sequence(format, sequence_.folder, folder() / "b", options);
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder() / "a"))
      if (entry.is_regular_file()) {
        EXPECT_EQ(bytes_of(entry.path()),
                  bytes_of(folder() / "b" / fs::relative(entry.path(), folder() / "a")));
        ++files;
      }
    EXPECT_GT(files, 0) << format;
    fs::remove_all(folder() / "a");
    fs::remove_all(folder() / "b");
    ++formats;
  }
  EXPECT_EQ(formats, 8);
  fs::remove_all(data() / "truth");
  for (const std::string& format : export_formats()) {
    export_sequence(format, sequence_.folder, folder() / "c" / format, options);
    EXPECT_FALSE(fs::is_empty(folder() / "c" / format));
  }
}

}  // namespace
}  // namespace uniquadric
