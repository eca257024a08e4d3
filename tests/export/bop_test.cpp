#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "harness/export/run_length.h"
#include "tests/export/exported_scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kRounding = 1e-9;   // [mm, px] of double products
constexpr double kMaskRimPx = 1.01;  // a mask's outermost pixel centres lie up to a pixel inside the outline

json read_json(const fs::path& path) {
  std::ifstream in(path);
  EXPECT_TRUE(in) << path;
  return json::parse(in);
}

Eigen::Matrix3d matrix33(const json& values) {
  const auto v = values.get<std::vector<double>>();
  EXPECT_EQ(v.size(), 9u);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v.data());
}

Eigen::Vector3d vector3(const json& values) {
  const auto v = values.get<std::vector<double>>();
  return Eigen::Map<const Eigen::Vector3d>(v.data());
}

// The projection of a model's corners, as its sizes and pose have it: [u_min, v_min, u_max, v_max].
Eigen::Array4d projected_box(const json& model, const json& pose, const json& camera) {
  const auto value = [&](const char* key) { return model.at(key).get<double>(); };
  const Eigen::Vector3d low(value("min_x"), value("min_y"), value("min_z"));
  const Eigen::Vector3d size(value("size_x"), value("size_y"), value("size_z"));
  Eigen::Array4d box(INFINITY, INFINITY, -INFINITY, -INFINITY);
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner = low + size.cwiseProduct(Eigen::Vector3d(i & 1, i >> 1 & 1, i >> 2));
    const Eigen::Vector3d p =
        matrix33(camera["cam_K"]) * (matrix33(pose["cam_R_m2c"]) * corner + vector3(pose["cam_t_m2c"]));
    box.head<2>() = box.head<2>().min(p.head<2>().array() / p.z());
    box.tail<2>() = box.tail<2>().max(p.head<2>().array() / p.z());
  }
  return box;
}

class BopExport : public Export {
 protected:
  fs::path out = run("bop"), scene = out / "test/000000";
  json cameras = read_json(scene / "scene_camera.json"), poses = read_json(scene / "scene_gt.json"),
       infos = read_json(scene / "scene_gt_info.json"), models = read_json(out / "models/models_info.json");
};

TEST_F(BopExport, PosesAreInMillimetresOfTheBoxsCentre) {
  int objects = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    const json& camera = cameras[std::to_string(frame)];
    for (const json& pose : poses[std::to_string(frame)]) {
      const Ellipsoid& object = truth_of(pose["obj_id"], frame).ellipsoid;
      const Eigen::Vector3d corner_world = object.world_from_object * object.semi_axes_m;
      const Eigen::Vector3d by_model =
          matrix33(pose["cam_R_m2c"]) * (1000 * object.semi_axes_m) + vector3(pose["cam_t_m2c"]);
      const Eigen::Vector3d by_world =
          matrix33(camera["cam_R_w2c"]) * (1000 * corner_world) + vector3(camera["cam_t_w2c"]);
      EXPECT_LT((by_model - by_world).norm(), kRounding);
      ++objects;
    }
  }
  EXPECT_EQ(objects, 2 * kFrames);
  EXPECT_NEAR(models["1"]["size_x"].get<double>(), 400, 1e-4);  // sizes of meshes are met to single precision
  EXPECT_NEAR(models["1"]["min_y"].get<double>(), -150, 1e-4);
  EXPECT_NEAR(models["1"]["diameter"].get<double>(), std::hypot(400, 300, 200), 1e-4);
  EXPECT_NEAR(models["2"]["diameter"].get<double>(), 300, 1e-3);
}

TEST_F(BopExport, ModelsProjectOntoTheirMasks) {
  int whole = 0, hidden = 0;
  for (int frame = 0; frame < kFrames; ++frame)
    for (std::size_t i = 0; i < poses[std::to_string(frame)].size(); ++i) {
      const json &pose = poses[std::to_string(frame)][i], &info = infos[std::to_string(frame)][i];
      const std::string file = fmt::format("{:06}_{:06}.png", frame, i);
      const cv::Mat mask = cv::imread((scene / "mask_visib" / file).string(), cv::IMREAD_UNCHANGED);
      EXPECT_EQ(cv::norm(mask, instances(frame) == pose["obj_id"].get<int>()), 0);
      EXPECT_EQ(info["px_count_visib"], cv::countNonZero(mask));
      const cv::Rect box = cv::boundingRect(mask);
      EXPECT_EQ(info["bbox_visib"], json({box.x, box.y, box.width, box.height}));
      const Eigen::Array4d outline = projected_box(models[std::to_string(pose["obj_id"].get<int>())], pose,
                                                   cameras[std::to_string(frame)]);
      EXPECT_GT(box.x, outline(0) - kRounding);
      EXPECT_GT(box.y, outline(1) - kRounding);
      EXPECT_LT(box.x + box.width - 1, outline(2) + kRounding);
      EXPECT_LT(box.y + box.height - 1, outline(3) + kRounding);
      const bool is_whole = info["visib_fract"] == 1.0;
      EXPECT_EQ(fs::exists(scene / "mask" / file), is_whole);
      (is_whole ? whole : hidden) += 1;
      if (pose["obj_id"] != kBox || !is_whole) continue;
      // all of the box is seen: its corners are the mask's extremes
      EXPECT_LT((outline - Eigen::Array4d(box.x, box.y, box.x + box.width - 1, box.y + box.height - 1))
                    .abs()
                    .maxCoeff(),
                kMaskRimPx);
      EXPECT_EQ(info["bbox_obj"], info["bbox_visib"]);
    }
  EXPECT_EQ(whole + hidden, 2 * kFrames);
  EXPECT_GE(whole, kFrames);
}

TEST_F(BopExport, BallsCentreProjectsToItsMasksCentre) {
  // the outline of a sphere is an ellipse about a point a little further out than the centre's image:
  // tan(angle off the axis) (r / z)^2 of the focal length, here at most 130 * 0.5 * (0.15 / 1.2)^2 = 1 px
  constexpr double kCenterTolerancePx = 1.5;
  int balls = 0;
  for (int frame = 0; frame < kFrames; ++frame)
    for (std::size_t i = 0; i < poses[std::to_string(frame)].size(); ++i) {
      const json &pose = poses[std::to_string(frame)][i], &info = infos[std::to_string(frame)][i];
      if (pose["obj_id"] != kBall || info["visib_fract"] != 1.0) continue;
      const Eigen::Vector3d p =
          matrix33(cameras[std::to_string(frame)]["cam_K"]) * vector3(pose["cam_t_m2c"]);
      const auto box = info["bbox_visib"].get<std::vector<int>>();
      EXPECT_NEAR(p.x() / p.z(), box[0] + (box[2] - 1) / 2.0, kCenterTolerancePx);
      EXPECT_NEAR(p.y() / p.z(), box[1] + (box[3] - 1) / 2.0, kCenterTolerancePx);
      ++balls;
    }
  EXPECT_GE(balls, 2);
}

TEST_F(BopExport, DepthScaleGivesMillimetres) {
  for (int frame = 0; frame < kFrames; ++frame) {
    const std::string name = fmt::format("{:06}.png", frame);
    cv::Mat depth, original;
    cv::imread((scene / "depth" / name).string(), cv::IMREAD_UNCHANGED).convertTo(depth, CV_64F);
    sequence_image(sequence_.frames[static_cast<std::size_t>(frame)].depth).convertTo(original, CV_64F);
    const double scale = cameras[std::to_string(frame)]["depth_scale"];
    EXPECT_LT(cv::norm(depth * scale, original * (1000 / sequence_.depth_units_per_m), cv::NORM_INF),
              kRounding);
    EXPECT_EQ(bytes_of(scene / "rgb" / name), bytes_of(sequence_.folder / "rgb" / name));
    for (const json& info : infos[std::to_string(frame)])
      EXPECT_LE(info["px_count_valid"], info["px_count_visib"]);
  }
}

TEST_F(BopExport, CocoRunsDecodeToTheMasks) {
  const json coco = read_json(scene / "scene_gt_coco.json");
  EXPECT_EQ(coco["images"].size(), 4u);
  EXPECT_EQ(coco["categories"].size(), 2u);
  int decoded = 0;
  for (const json& annotation : coco["annotations"]) {
    const auto size = annotation["segmentation"]["size"].get<std::vector<int>>();
    cv::Mat mask = cv::Mat::zeros(size[0], size[1], CV_8U);
    int at = 0;
    bool inside = false;  // zeros come first
    for (const int run : annotation["segmentation"]["counts"]) {
      for (int end = at + run; at < end; ++at)
        mask.at<unsigned char>(at % size[0], at / size[0]) = inside ? 255 : 0;  // column by column
      inside = !inside;
    }
    EXPECT_EQ(at, size[0] * size[1]);
    EXPECT_EQ(cv::norm(mask, instances(annotation["image_id"]) == annotation["category_id"].get<int>()), 0);
    ++decoded;
  }
  EXPECT_EQ(decoded, 2 * kFrames);
}

TEST(RunLengths, AreColumnMajorAndBeginWithZeros) {
  cv::Mat ids = (cv::Mat_<std::uint16_t>(2, 3) << 5, 0, 5, 5, 5, 7);
  EXPECT_EQ(run_lengths(ids, 5), (std::vector<std::int64_t>{0, 2, 1, 2, 1}));
  EXPECT_EQ(run_lengths(ids, 7), (std::vector<std::int64_t>{5, 1}));
  EXPECT_EQ(run_lengths(ids, 9), (std::vector<std::int64_t>{6}));
}

}  // namespace
}  // namespace uniquadric
