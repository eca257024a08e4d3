#include "evaluation/report/overlay.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/sequence/calibration.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "evaluation/report/drawing.h"
#include "evaluation/report/jpeg.h"
#include "evaluation/report/outline.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kFrames = 10;
constexpr int kColorMargin = 60;  // of 255: a line against its surroundings, after JPEG

bool is_green(const cv::Vec3b& p) {
  return p[1] > p[2] + kColorMargin && p[1] > p[0] + kColorMargin;
}
bool is_orange(const cv::Vec3b& p) {
  return p[2] > p[1] + kColorMargin && p[1] > p[0] + kColorMargin;
}
template <typename Is>
int count(const cv::Mat& image, Is is) {
  int n = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) n += is(image.at<cv::Vec3b>(y, x));
  return n;
}

// A grey sequence, a sphere of 0.5 m at `true_z_m` and its estimate at `estimated_z_m`, the camera at the
// origin.
struct GreyRecording {
  TempFolder folder;
  fs::path sequence = folder.path() / "sequence", truth = folder.path() / "truth",
           estimate = folder.path() / "estimate", out = folder.path() / "out";

  GreyRecording(double true_z_m, double estimated_z_m) {
    Sequence s;
    s.name = "grey", s.rate_hz = 10;
    fs::create_directories(sequence);
    write_png(sequence / "rgb.png", cv::Mat(480, 640, CV_8UC3, cv::Scalar(90, 90, 90)));
    cv::Mat masks(480, 640, CV_16UC1, cv::Scalar(0));
    masks(cv::Rect(0, 0, 40, 400)).setTo(3);
    write_png(sequence / "mask.png", masks);
    for (int i = 0; i < kFrames; ++i)
      s.frames.push_back({i, i * 100'000'000LL, "rgb.png", "", "mask.png", 0});
    write_sequence_index(sequence, s);
    write_truth(s, true_z_m);
    fs::create_directories(estimate);
    Tracks tracks;
    tracks.camera = camera(s);
    tracks.objects.push_back({7, "", {}});
    for (const auto& frame : s.frames) {
      ObjectState state;
      state.frame = frame.frame, state.stamp_ns = frame.stamp_ns;
      state.ellipsoid = {at(estimated_z_m), Eigen::Vector3d::Constant(0.5)};
      tracks.objects[0].states.push_back(state);
    }
    write_estimate(estimate, tracks);
  }

  static Pose at(double z_m) { return {Eigen::Quaterniond::Identity(), {0, 0, z_m}}; }
  static Trajectory camera(const Sequence& s) {
    Trajectory poses;
    for (const auto& frame : s.frames) poses.push_back({frame.stamp_ns, Pose{}});
    return poses;
  }
  void write_truth(const Sequence& s, double z_m) const {
    fs::create_directories(truth / "objects");
    write_tum(truth / "camera.tum", camera(s));
    ObjectDescription ball;
    ball.id = 1, ball.name = "ball", ball.semi_axes_m.setConstant(0.5), ball.shape = "ball";
    write_objects_yaml(truth / "objects.yaml", {ball});
    Trajectory poses = camera(s);
    for (auto& pose : poses) pose.pose = at(z_m);
    write_tum(truth / "objects/1.tum", poses);
  }
  cv::Mat first() const { return read_image(out / "000000.jpg"); }
};

TEST(Overlay, OutlinesStandWhereTheSpheresProject) {
  const GreyRecording recording(4, 3);
  write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, false);
  const cv::Mat image = recording.first();
  // A sphere on the axis projects to a circle of radius f a / sqrt(z^2 - a^2); row 239 is half a pixel off
  // its centre.
  const auto radius_px = [](double z_m) { return 525 * 0.5 / std::sqrt(z_m * z_m - 0.25); };
  const auto pixel = [&](double dx) {
    return image.at<cv::Vec3b>(239, static_cast<int>(std::lround(319.5 + dx)));
  };
  EXPECT_TRUE(is_green(pixel(radius_px(4))));
  EXPECT_TRUE(is_green(pixel(-radius_px(4))));
  EXPECT_TRUE(is_orange(pixel(radius_px(3))));
  EXPECT_TRUE(is_orange(pixel(-radius_px(3))));
  EXPECT_FALSE(is_green(pixel(radius_px(4) + 6)) ||
               is_orange(pixel(radius_px(4) + 6)));  // nothing between them
  EXPECT_FALSE(is_green(pixel(0)) || is_orange(pixel(0)));
}

// Only what says of two of the folders that they are of two scenes is refused.
TEST(Overlay, FoldersOfTwoScenesAreRefused) {
  const GreyRecording recording(4, 3);
  const auto draw_of = [&](const std::string& of_sequence, const std::string& of_truth,
                           const std::string& of_estimate) {
    Sequence sequence = open_sequence(recording.sequence);
    sequence.scene_hash = of_sequence;
    write_sequence_index(recording.sequence, sequence);
    const fs::path objects = recording.truth / "objects.yaml";
    write_objects_yaml(objects, read_objects_yaml(objects), of_truth);
    write_text(recording.estimate / "run.yaml",
               of_estimate.empty() ? "sequence: grey\n" : "scene_hash: \"" + of_estimate + "\"\n");
    write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, true);
  };
  const auto refusal = [&](const std::string& of_sequence, const std::string& of_truth,
                           const std::string& of_estimate) {
    return input_error([&] { draw_of(of_sequence, of_truth, of_estimate); });
  };
  const auto expected = [](const fs::path& other, const fs::path& one) {
    return other.string() + ": is of another scene: its scene_hash is b, that of " + one.string() + " is a";
  };
  EXPECT_EQ(refusal("a", "a", "b"), expected(recording.estimate, recording.sequence));
  EXPECT_EQ(refusal("a", "b", ""), expected(recording.truth, recording.sequence));
  EXPECT_EQ(refusal("", "a", "b"), expected(recording.estimate, recording.truth));
  EXPECT_FALSE(fs::exists(recording.out));
  EXPECT_NO_THROW(draw_of("a", "a", "a"));
  EXPECT_NO_THROW(draw_of("a", "", ""));
}

// What sticks out of the ellipsoid is the superellipsoid's.
TEST(Overlay, TheEstimatedSuperellipsoidHasItsOwnOutline) {
  const GreyRecording recording(4, 3);
  const auto at_diagonal = [&](double exponent) {
    Tracks tracks = read_tracks(recording.estimate);
    for (auto& state : tracks.objects[0].states) state.exponents = {exponent, exponent, exponent};
    write_estimate(recording.estimate, tracks);
    write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, true);
    // the cube's face is at 105 px, the sphere's circle at 63 px to each side; this one's outline between
    const Eigen::Vector3d axes_m = Eigen::Vector3d::Constant(0.5);
    double most_px = 0;
    for (const Eigen::Vector2d& p :
         superellipsoid_outline(Camera{}, GreyRecording::at(3), {axes_m, {1.2, 1.2, 1.2}}))
      most_px = std::max(most_px, (p.x() + p.y() - 319.5 - 239.5) / 2);
    EXPECT_GT(most_px, 75);
    EXPECT_LT(most_px, 100);
    return recording.first().at<cv::Vec3b>(static_cast<int>(std::lround(239.5 + most_px)),
                                           static_cast<int>(std::lround(319.5 + most_px)));
  };
  EXPECT_FALSE(is_orange(at_diagonal(2)));
  EXPECT_TRUE(is_orange(at_diagonal(1.2)));
}

// Beside ellipsoids the one within it is drawn too.
TEST(Overlay, ATrueBoxIsDrawnAsABox) {
  const GreyRecording recording(4, 2.6);  // no line of which is near those of the truth
  const auto objects = recording.truth / "objects.yaml";
  for (const std::string shape : {"box", "rounded_box", "car", ""}) {
    write_objects_yaml(objects, {{1, "box", Eigen::Vector3d::Constant(0.5), shape, ""}});
    const auto at = [&](double exponent, double side_px, double down_px) {
      Tracks tracks = read_tracks(recording.estimate);
      for (auto& state : tracks.objects[0].states) state.exponents = {exponent, exponent, exponent};
      write_estimate(recording.estimate, tracks);
      write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, true);
      return recording.first().at<cv::Vec3b>(static_cast<int>(std::lround(239.5 + down_px)),
                                             static_cast<int>(std::lround(319.5 + side_px)));
    };
    const double face_px = 525 * 0.5 / 3.5, circle_px = 525 * 0.5 / std::sqrt(16 - 0.25);
    EXPECT_TRUE(is_green(at(2, circle_px, 0)));
    EXPECT_TRUE(is_green(at(2, -face_px, 30))) << shape;
    EXPECT_TRUE(is_green(at(1.2, -face_px, 30))) << shape;
    EXPECT_FALSE(is_green(at(1.2, circle_px, 0))) << shape;
  }
}

// Along the optical axis: a cylinder's silhouette is its near rim, wider than the ellipsoid's.
TEST(Overlay, ATrueCylinderIsDrawnAsOne) {
  const GreyRecording recording(4, 2.6);
  write_objects_yaml(recording.truth / "objects.yaml",
                     {{1, "can", Eigen::Vector3d::Constant(0.5), "cylinder", ""}});
  const auto at = [&](double exponent, double side_px) {
    Tracks tracks = read_tracks(recording.estimate);
    for (auto& state : tracks.objects[0].states) state.exponents = {exponent, exponent, exponent};
    write_estimate(recording.estimate, tracks);
    write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, true);
    const double each_px = side_px / std::sqrt(2);  // a box has its edge further out on the diagonal
    return recording.first().at<cv::Vec3b>(static_cast<int>(std::lround(239.5 - each_px)),
                                           static_cast<int>(std::lround(319.5 - each_px)));
  };
  const double rim_px = 525 * 0.5 / 3.5;
  EXPECT_TRUE(is_green(at(1.2, rim_px)));
  EXPECT_TRUE(is_green(at(2, rim_px)));
  EXPECT_FALSE(is_green(at(2, rim_px + 12)));  // a box's corner is
}

TEST(Overlay, TheEstimatesWorldDoesNotMatter) {
  const GreyRecording recording(4, 3);
  Tracks tracks = read_tracks(recording.estimate);
  for (auto& state : tracks.objects[0].states)
    state.ellipsoid.semi_axes_m = {0.5, 0.3, 0.2};  // a circle's rectangle would turn with the rounding
  write_estimate(recording.estimate, tracks);
  write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, false);
  const cv::Mat before = recording.first();
  const Pose move = {exp_so3({0.4, -2.1, 0.9}), Eigen::Vector3d(5, -3, 2)};
  for (auto& pose : tracks.camera) pose.pose = move * pose.pose;
  for (auto& state : tracks.objects[0].states)
    state.ellipsoid.world_from_object = move * state.ellipsoid.world_from_object;
  write_estimate(recording.estimate, tracks);
  write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, true);
  EXPECT_LT(cv::norm(recording.first(), before, cv::NORM_INF), 40);  // rounding at the lines' edges
  EXPECT_GT(count(recording.first(), is_orange), 100);
}

TEST(Overlay, NoOutlineWithoutAnEllipse) {
  int cases = 0;
  for (const double z_m : {-4.0, 0.0, 0.3}) {  // behind; the camera inside; across the principal plane
    const GreyRecording recording(z_m, z_m);
    write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, false);
    EXPECT_EQ(count(recording.first(), is_green), 0) << z_m;
    EXPECT_EQ(count(recording.first(), is_orange), 0) << z_m;
    ++cases;
  }
  EXPECT_EQ(cases, 3);
}

TEST(Overlay, WithAColourTheTruthIsWhiteOnBlackAndTheEstimateHasIt) {
  const GreyRecording recording(4, 3);
  write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, false, "#0072b2");
  const cv::Mat image = recording.first();
  EXPECT_EQ(count(image, is_green), 0);
  EXPECT_EQ(count(image, is_orange), 0);
  EXPECT_GT(
      count(image, [](const cv::Vec3b& p) { return p[0] > 150 && p[1] > 90 && p[1] < 140 && p[2] < 40; }),
      100);
  EXPECT_GT(count(image, [](const cv::Vec3b& p) { return p[0] > 240 && p[1] > 240 && p[2] > 240; }), 200);
  for (const char* bad : {"blue", "#12345", "#12345g"})
    EXPECT_NE(input_error([&] {
                write_overlays(recording.sequence, "", recording.estimate, recording.out, 1, true, bad);
              }).find("is no colour such as #0072b2"),
              std::string::npos);
}

bool is_yellow(const cv::Vec3b& p) {
  return std::min(p[1], p[2]) > p[0] + kColorMargin && std::abs(p[1] - p[2]) < kColorMargin;
}

// The estimate's box is drawn where its corners project: 1 m before the camera's axis, its front a square of
// half a side f a / (z - a).
TEST(Overlay, TheEstimatedBoxHasItsEdges) {
  const GreyRecording recording(4, 3);
  write_overlays(recording.sequence, "", recording.estimate, recording.out, 1, false);
  const cv::Mat image = recording.first();
  for (const double z_m : {2.5, 3.5}) {  // front and back face
    const double half_px = 525 * 0.5 / z_m;
    for (const double side : {-1.0, 1.0}) {
      const int across = static_cast<int>(std::lround(319.5 + side * half_px)), off_corner = 239 + 25;
      EXPECT_TRUE(is_yellow(image.at<cv::Vec3b>(off_corner, across))) << z_m << " " << side;
    }
  }
}

TEST(Drawing, BoxesAreCutBeforeTheCamera) {
  Canvas canvas = make_canvas(cv::Mat(480, 640, CV_8UC3, cv::Scalar(0, 0, 0)), Camera{}, 640);
  const auto drawn = [&](double z_m) {
    canvas.image.setTo(cv::Scalar(0, 0, 0));
    draw_box(canvas, GreyRecording::at(z_m), {0.2, 0.2, 0.5}, {255, 255, 255}, 1);
    return count(canvas.image, [](const cv::Vec3b& p) { return p[0] > 100; });
  };
  EXPECT_GT(drawn(3), 400);
  EXPECT_GT(drawn(0.3), 100);  // the camera inside: what is in front of it
  EXPECT_EQ(drawn(-3), 0);
}

TEST(Overlay, RecordingsHaveNoTruth) {
  const GreyRecording recording(4, 4);
  write_overlays(recording.sequence, "", recording.estimate, recording.out, 1, false);
  EXPECT_EQ(count(recording.first(), is_green), 0);
  EXPECT_GT(count(recording.first(), is_orange), 100);
}

TEST(Overlay, TintsTheSequencesMasksOrTheEstimatesOwn) {
  const GreyRecording recording(4, 4);
  const auto is_tinted = [](const cv::Vec3b& p) { return std::abs(p[0] - p[2]) > 20; };
  write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, false);
  EXPECT_TRUE(is_tinted(recording.first().at<cv::Vec3b>(300, 20)));
  EXPECT_FALSE(is_tinted(recording.first().at<cv::Vec3b>(300, 620)));
  cv::Mat own(480, 640, CV_16UC1, cv::Scalar(0));
  own(cv::Rect(600, 0, 40, 400)).setTo(1);
  fs::create_directories(recording.estimate / "masks");
  write_png(recording.estimate / "masks/000000.png", own);
  write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, true);
  EXPECT_FALSE(is_tinted(recording.first().at<cv::Vec3b>(300, 20)));
  EXPECT_TRUE(is_tinted(recording.first().at<cv::Vec3b>(300, 620)));
  own.convertTo(own, CV_8UC1);
  write_png(recording.estimate / "masks/000000.png", own);
  const auto draw = [&] {
    write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, true);
  };
  EXPECT_NE(input_error(draw).find("000000.png: expected a 16-bit image"), std::string::npos);
}

TEST(Overlay, OfASequenceWithoutImagesIsRefused) {
  const GreyRecording recording(2, 2);
  const fs::path lidar = recording.folder.path() / "lidar";
  Sequence sequence;
  sequence.name = "lidar", sequence.rate_hz = 10;
  sequence.lidar = LidarCalibration{.pattern = "by_hand", .camera_from_lidar = {}};
  sequence.scans = {{0, "0.pcd"}};
  fs::create_directories(lidar);
  write_lidar_points(lidar / "0.pcd", {{1, 2, 3}});
  write_sequence_index(lidar, sequence);
  const std::string message =
      input_error([&] { write_overlays(lidar, "", recording.estimate, recording.out, 1, false); });
  EXPECT_NE(message.find("has no images to draw in"), std::string::npos) << message;
  EXPECT_FALSE(fs::exists(recording.out));
}

TEST(Overlay, EvenlySpacedFramesOneSheetAndNoOldOnes) {
  const GreyRecording recording(4, 4);
  write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 5, false);
  const auto again = [&] {
    write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 4, false);
  };
  EXPECT_NE(input_error(again).find("--force"), std::string::npos);
  write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 4, true);
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(recording.out))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{".uniquadric", "000000.jpg", "000003.jpg", "000006.jpg",
                                             "000009.jpg", "sheet.jpg"}));
  const cv::Mat sheet = read_image(recording.out / "sheet.jpg");
  EXPECT_EQ(sheet.size(), cv::Size(2 * 480 + 3 * 4, 2 * 360 + 3 * 4));  // two by two tiles and the gaps
}

TEST(Overlay, SheetOfNothingIsRefused) {
  const TempFolder folder;
  const auto make = [&] { write_contact_sheet(folder.path(), folder.path() / "sheet.jpg"); };
  EXPECT_NE(input_error(make).find("holds no frames"), std::string::npos);
}

TEST(Absence, StandsInThePicture) {
  const GreyRecording recording(4, 3);
  const auto corner = [&] {
    write_overlays(recording.sequence, recording.truth, recording.estimate, recording.out, 1, true);
    return recording.first()(cv::Rect(0, 20, 200, 18)).clone();
  };
  write_png(recording.sequence / "mask.png", cv::Mat(480, 640, CV_16UC1, cv::Scalar(0)));
  const cv::Mat without = corner();
  Tracks tracks = read_tracks(recording.estimate);
  tracks.objects[0].states[0].status = ObjectStatus::lost;
  write_estimate(recording.estimate, tracks);
  EXPECT_GT(cv::norm(corner(), without, cv::NORM_INF), 100);
}

TEST(Drawing, OutlineFollowsTheLens) {
  Camera camera;
  camera.distortion = {-0.3, 0.1, 0.001, -0.002, 0};
  Canvas canvas = make_canvas(cv::Mat(480, 640, CV_8UC3, cv::Scalar(0, 0, 0)), camera, 320);
  const Ellipse ellipse{{500, 380}, 100, 50, 0.5};
  draw_rectangle(canvas, ellipse, {255, 255, 255}, 1);  // touches the ellipse at its vertices
  const Eigen::Vector2d axis(std::cos(ellipse.angle_rad), std::sin(ellipse.angle_rad));
  int hits = 0;
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector2d vertex = ellipse.center + side * ellipse.semi_major * axis;
    const auto bent =
        camera.project({(vertex.x() - camera.cx) / camera.fx, (vertex.y() - camera.cy) / camera.fy, 1});
    const cv::Point at(static_cast<int>(std::lround((bent->x() + 0.5) / 2 - 0.5)),
                       static_cast<int>(std::lround((bent->y() + 0.5) / 2 - 0.5)));
    EXPECT_GT((vertex - *bent).norm(), 2);  // [px]: the lens does bend here
    hits += canvas.image.at<cv::Vec3b>(at)[0] > 60;
  }
  EXPECT_EQ(hits, 2);
}

}  // namespace
}  // namespace uniquadric
