#include "estimator/segmentation/segmentation.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <opencv2/core.hpp>

#include "box_scene.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "drawn_world.h"
#include "estimator/images/surface_normals.h"
#include "estimator/observation/outline.h"
#include "estimator/segmentation/depth_parts.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

const Camera kCamera{320, 240, 260, 260, 159.5, 119.5, {}};

SegmentationOptions from(const std::string& source) {
  SegmentationOptions options;
  options.source = source;
  return options;
}

TEST(SupportPlanes, AreFoundLargestFirst) {
  RandomStream random(4, "planes");
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 300; ++i)
    points.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), 0.003 * random.normal());
  for (int i = 0; i < 150; ++i) points.emplace_back(2, random.uniform(-1, 1), random.uniform(0.5, 2));
  for (int i = 0; i < 50; ++i)
    points.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(3, 5));
  const auto planes = find_planes(points, 0.02, 0.2, 3, random);
  ASSERT_EQ(planes.size(), 2u);
  EXPECT_GT(std::abs(planes[0].normal.z()), 0.9999);
  EXPECT_LT(planes[0].distance({0, 0, 0}), 0.001);  // m: 3 mm of noise over 300 points
  EXPECT_GT(std::abs(planes[1].normal.x()), 0.9999);
  EXPECT_LT(planes[1].distance({2, 0, 0}), 0.001);
}

// Of a slanted plane in closed form; beside a hole and at the image's border there is none.
TEST(SurfaceNormals, AreThoseOfThePlaneThatIsSeen) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.8, -0.5).normalized();
  cv::Mat depth(kCamera.height, kCamera.width, CV_32FC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u)
      depth.at<float>(v, u) = static_cast<float>(-1.2 / normal.dot(*kCamera.unproject({u, v})));
  depth(cv::Rect(100, 100, 40, 40)).setTo(0);
  const cv::Mat normals = surface_normals(depth, kCamera, {40, 40, 200, 160}, 4);
  const auto at = [&](int u, int v) { return Eigen::Vector3d(normals.at<cv::Vec3d>(v - 40, u - 40).val); };
  EXPECT_GT(std::abs(at(60, 150).dot(normal)), 1 - 1e-4);
  EXPECT_GT(std::abs(at(200, 60).dot(normal)), 1 - 1e-4);
  EXPECT_TRUE(at(120, 120).isZero());
  const cv::Mat small = surface_normals(depth(cv::Rect(0, 0, 10, 90)), kCamera, {0, 0, 10, 90}, 7);
  EXPECT_EQ(cv::countNonZero(small.reshape(1)), 0);  // narrower than what a normal needs
  const Plane floor;                                 // z = 0
  const auto tilted = [](double deg) {
    const double rad = deg * std::numbers::pi / 180;
    return cv::Vec3d(std::sin(rad), 0, -std::cos(rad));
  };
  EXPECT_TRUE(faces_as(floor, tilted(44)));
  EXPECT_FALSE(faces_as(floor, tilted(46)));
  EXPECT_TRUE(faces_as(floor, {0, 0, 0}));
}

// A floor seen at a slant, its noise a thousandth of the depth: what stands 1 cm above it at 1 m is no part
// of it, though the plane was looked for within 2 cm.
TEST(SupportPlanes, WhatLiesOnThemIsToldByTheirSpread) {
  RandomStream random(4, "planes");
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 2000; ++i) {
    const double z = random.uniform(0.8, 2);
    points.emplace_back(random.uniform(-1, 1), 0.5 + 0.001 * z * random.normal(), z);
  }
  const auto planes = find_planes(points, 0.02, 0.5, 1, random);
  ASSERT_EQ(planes.size(), 1u);
  EXPECT_NEAR(planes[0].spread, 0.001, 0.0001);
  EXPECT_TRUE(lies_on(planes[0], {0, 0.503, 1}, 0.02));
  EXPECT_FALSE(lies_on(planes[0], {0, 0.490, 1}, 0.02));
  EXPECT_TRUE(lies_on(planes[0], {0, 0.490, 4}, 0.02));
  EXPECT_FALSE(lies_on(planes[0], {0, 0.490, 4}, 0.008));
}

TEST(Segmentation, PromptsSelectAmongTheSequencesMasks) {
  const TempFolder temp;
  const fs::path& folder = temp.path();
  Sequence sequence = write_box_sequence(folder, 1, false);
  cv::Mat masks = read_masks(sequence, sequence.frames[0]).clone();
  masks(cv::Rect(5, 5, 30, 20)).setTo(4);
  write_png(folder / sequence.frames[0].masks, masks);
  const auto ids = [&](const std::string& prompt) {
    write_text(folder / "prompt.txt", prompt);
    const PromptedSegmenter segmenter =
        make_segmenter(sequence, {}, prompt.empty() ? fs::path() : folder / "prompt.txt");
    const cv::Mat found = segment(segmenter, sequence, sequence.frames[0], {}, 0);
    return std::pair(cv::countNonZero(found == 1) > 0, cv::countNonZero(found == 4) > 0);
  };
  EXPECT_EQ(ids(""), std::pair(true, true));
  EXPECT_EQ(ids("1.0 3 4 30 20\n"), std::pair(false, true));
  EXPECT_THROW(ids("1.0 280 4 20 20\n"), InputError);
}

TEST(Segmentation, PointsSelectAmongTheSequencesMasks) {
  const TempFolder temp;
  const fs::path& folder = temp.path();
  Sequence sequence = write_box_sequence(folder, 1, false);
  cv::Mat masks = read_masks(sequence, sequence.frames[0]).clone();
  masks(cv::Rect(5, 5, 30, 20)).setTo(4);
  write_png(folder / sequence.frames[0].masks, masks);
  write_text(folder / "points.txt", "1.0 20 15\n");
  const Prompts points(PromptKind::points, folder / "points.txt");
  EXPECT_EQ(make_segmenter(sequence, {}, points).selected, std::set<int>{4});
  write_text(folder / "points.txt", "1.0 3 3\n");
  EXPECT_NE(input_error([&] { make_segmenter(sequence, {}, points); }).find("no point fits a mask"),
            std::string::npos);
}

// A prompt beside all bodies gives no mask, beside one that does; of an object with an id all of its prompts
// count.
TEST(Segmentation, PromptsWithoutAMaskAreNamed) {
  const TempFolder temp;
  const fs::path file = temp.path() / "prompts.txt";
  const Sequence sequence = write_box_sequence(temp.path(), 2, false);
  const auto [id, box] = *id_boxes(read_masks(sequence, sequence.frames[0])).begin();
  const int u = box.x + box.width / 2, v = box.y + box.height / 2;
  const std::string first = format_stamp(sequence.frames[0].stamp_ns),
                    second = format_stamp(sequence.frames[1].stamp_ns);
  const auto faults = [&](const std::string& source, PromptKind kind, const std::string& prompts) {
    write_text(file, prompts);
    const PromptedSegmenter segmenter = make_segmenter(sequence, from(source), {kind, file});
    for (const SequenceFrame& frame : sequence.frames)
      segment(segmenter, sequence, frame, read_depth(sequence, frame), 0);
    return segmenter.watch->faults();
  };
  using Lines = std::vector<std::string>;
  const std::string on = fmt::format("{} {} {}", first, u, v);
  for (const char* const source : {"sequence", "depth_motion"}) {
    EXPECT_EQ(faults(source, PromptKind::points, on + "\n" + first + " 2 3\n"),
              Lines{file.string() + ": the point (2, 3) at " + first + " s gave no mask"});
    EXPECT_EQ(faults(source, PromptKind::points, on + " 1\n" + second + " 2 3 1\n"), Lines{});
    EXPECT_EQ(faults(source, PromptKind::points, on + " 1\n" + first + " 2 3 8\n" + second + " 2 3 8\n"),
              Lines{file.string() +
                    ": object 8: none of its 2 prompts gave a mask, the first being the point (2, 3) at " +
                    first + " s"});
  }
  const std::string boxes =
      fmt::format("{} {} {} {} {} 1\n{} 1 1 4 4 2\n", first, box.x, box.y, box.width, box.height, first);
  EXPECT_EQ(faults("sequence", PromptKind::boxes, boxes),
            Lines{file.string() + ": object 2: the box (1, 1, 4, 4) at " + first + " s gave no mask"});
  std::string many = on + "\n";
  for (int i = 0; i < 7; ++i) many += fmt::format("{} {} 3\n", first, 2 + i);
  const Lines lines = faults("sequence", PromptKind::points, many);
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines.back(), file.string() + ": 2 more prompts gave no mask");
}

// One of two prompts finds nothing where both lie on one mask: that is said, naming both.
TEST(Segmentation, PointsOfTwoObjectsOnOneMaskAreSaid) {
  const TempFolder temp;
  const fs::path& folder = temp.path();
  const Sequence sequence = write_box_sequence(folder, 2, false);
  const cv::Mat masks = read_masks(sequence, sequence.frames[0]);
  const auto [id, box] = *id_boxes(masks).begin();
  const int u = box.x + box.width / 2, v = box.y + box.height / 2;
  const auto said = [&](const std::string& source, const std::string& points) {
    write_text(folder / "points.txt", points);
    testing::internal::CaptureStderr();
    const PromptedSegmenter segmenter =
        make_segmenter(sequence, from(source), {PromptKind::points, folder / "points.txt"});
    for (const SequenceFrame& frame : sequence.frames)
      segment(segmenter, sequence, frame, read_depth(sequence, frame), 0);
    return testing::internal::GetCapturedStderr();
  };
  const std::string first = fmt::format("({}, {}) at {} s", u, v, format_stamp(sequence.frames[0].stamp_ns));
  const auto line = [&](std::size_t frame, int du, const char* id_text) {
    return fmt::format("{} {} {}{}\n", format_stamp(sequence.frames[frame].stamp_ns), u + du, v, id_text);
  };
  for (const char* const source : {"sequence", "depth_motion"}) {
    const std::string unnamed = said(source, line(0, 0, "") + line(0, 2, ""));
    EXPECT_NE(unnamed.find(fmt::format("points.txt: the points {} and ({}, {}) at", first, u + 2, v)),
              std::string::npos)
        << unnamed;
    const std::string named =
        said(source, line(0, 0, " 7") + line(0, 2, " 9") + line(1, 0, " 7") + line(1, 2, " 9"));
    EXPECT_NE(named.find(first + " of object 7 and "), std::string::npos) << named;
    EXPECT_EQ(std::count(named.begin(), named.end(), '\n'), 1) << named;  // once a pair
    EXPECT_EQ(said(source, line(0, 0, " 7") + line(0, 2, " 7")), "");
    EXPECT_EQ(said(source, line(0, 0, "") + line(1, 0, "")), "");  // each frame's may be the same object
  }
  // over the frames too, where ids say who is who
  EXPECT_NE(said("sequence", line(0, 0, " 7") + line(1, 2, " 9")).find("of object 9"), std::string::npos);
}

TEST(Segmentation, SourcesThatAreNotThereAreRefused) {
  const TempFolder temp;
  const fs::path& folder = temp.path();
  Sequence sequence = write_box_sequence(folder, 1, false);
  EXPECT_THROW(make_segmenter(sequence, from("grabcut_depth"), {}), InputError);  // no prompts
  EXPECT_EQ(make_segmenter(sequence, {}, {}).source, "sequence");
  sequence.frames[0].masks.clear();
  EXPECT_THROW(make_segmenter(sequence, from("sequence"), {}), InputError);
  EXPECT_THROW(make_segmenter(sequence, from("sam"), {}), InputError);  // no networks
  write_text(folder / "points.txt", "1.0 20 15\n");
  const Prompts points(PromptKind::points, folder / "points.txt");
  for (const char* const source : {"grabcut_depth", "detector"})
    EXPECT_THROW(make_segmenter(sequence, from(source), points), InputError);
  write_text(folder / "boxes.txt", "1.0 20 15 30 30\n");
  EXPECT_THROW(make_segmenter(sequence, from("depth_motion"), folder / "boxes.txt"), InputError);
}

TEST(Segmentation, WithoutMasksThePromptsSayWhatSegments) {
  const TempFolder temp;
  const fs::path& folder = temp.path();
  Sequence sequence = write_box_sequence(folder, 1, false);
  sequence.frames[0].masks.clear();
  write_text(folder / "points.txt", "1.0 20 15\n");
  write_text(folder / "boxes.txt", "1.0 20 15 30 30\n");
  EXPECT_EQ(make_segmenter(sequence, {}, {}).source, "depth_motion");
  EXPECT_EQ(make_segmenter(sequence, {}, folder / "boxes.txt").source, "grabcut_depth");
  EXPECT_EQ(make_segmenter(sequence, {}, {PromptKind::points, folder / "points.txt"}).source, "depth_motion");
}

const Sprite kLeft{1, 41, {50, 60, 180}, {60, 60}, 2, [](std::int64_t) { return Eigen::Vector2d(60, 90); }};
const Sprite kRight{2, 42, {190, 90, 40}, {60, 60}, 2, [](std::int64_t) { return Eigen::Vector2d(120, 90); }};
const Sprite kFar{3, 43, {60, 190, 90}, {50, 40}, 2.6, [](std::int64_t) { return Eigen::Vector2d(230, 40); }};

TEST(DepthParts, AreTheBodiesBeforeAWall) {
  const DrawnFrame drawn = draw_world({kLeft, kFar}, 0);
  RandomStream random(1, "parts");
  DepthPartsOptions options;
  options.plane_share = 0.2;
  const cv::Mat parts = depth_parts(drawn.depth, drawn_camera(), options, random);
  EXPECT_EQ(cv::countNonZero((parts == 1) != (drawn.masks == 1)), 0);  // the largest first
  EXPECT_EQ(cv::countNonZero((parts == 2) != (drawn.masks == 3)), 0);
  options.min_pixels = 2500;
  EXPECT_EQ(cv::countNonZero((depth_parts(drawn.depth, drawn_camera(), options, random) != 0) !=
                             (drawn.masks == 1)),
            0);
  const cv::Mat meant = parts_at_points(parts, {{8, 250, 60}, {9, 10, 10}, {5, 57, 100}});
  EXPECT_EQ(cv::countNonZero((meant == 8) != (drawn.masks == 3)), 0);
  EXPECT_EQ(cv::countNonZero((meant == 5) != (drawn.masks == 1)), 0);  // 3 px beside it
  EXPECT_EQ(cv::countNonZero(meant == 9), 0);
  EXPECT_EQ(
      cv::countNonZero(depth_parts(cv::Mat::zeros(240, 320, CV_32FC1), drawn_camera(), options, random)), 0);
}

// A face that fills a twelfth of the image is a plane, but neither floor nor wall.
TEST(DepthParts, ANearBodysFaceIsNoWall) {
  Sprite near = kLeft;
  near.size = {90, 70};
  const DrawnFrame drawn = draw_world({near}, 0);
  RandomStream random(3, "parts");
  EXPECT_EQ(
      cv::countNonZero((depth_parts(drawn.depth, drawn_camera(), {}, random) == 1) != (drawn.masks != 0)), 0);
}

// A box on a floor whose depth is noisy: what is near the floor and faces elsewhere is the box's own.
TEST(DepthParts, KeepTheFootOfWhatStandsOnAFloor) {
  RandomStream random(3, "parts");
  const BoxImage image = render_box(kCamera, scene_camera(0), scene_box(0), random);
  cv::Mat depth;
  image.depth.convertTo(depth, CV_32F, 1 / 5000.0);
  for (auto& z_m : cv::Mat_<float>(depth)) z_m *= 1 + 0.012F * static_cast<float>(random.normal());
  const cv::Mat parts = depth_parts(depth, kCamera, {}, random);
  EXPECT_GT(mask_iou(parts == 1, image.mask == 1), 0.94);
}

TEST(Segmentation, BodiesThatAreTrackedArePromptsWhereNoneAreGiven) {
  const TempFolder temp;
  const fs::path& folder = temp.path();
  const Sequence sequence = write_box_sequence(folder, 3, false);
  const cv::Mat truth = read_masks(sequence, sequence.frames[2]);
  write_text(folder / "points.txt", "1.0 20 15\n");  // of the first frame alone, and beside the box
  SegmentationOptions options;
  options.source = "depth_motion";
  const PromptedSegmenter segmenter =
      make_segmenter(sequence, options, {PromptKind::points, folder / "points.txt"});
  const SequenceFrame& frame = sequence.frames[2];
  const cv::Mat rgb = read_rgb(sequence, frame), depth = read_depth(sequence, frame);
  EXPECT_EQ(cv::countNonZero(segment(segmenter, sequence, {frame, rgb, depth, {}}, 0)), 0);
  const cv::Mat found = segment(segmenter, sequence, {frame, rgb, depth, truth}, 0);
  EXPECT_GT(mask_iou(found != 0, truth != 0), 0.75);  // what touches the floor is lost
}

}  // namespace
}  // namespace uniquadric
