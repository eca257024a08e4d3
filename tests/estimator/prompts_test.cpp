#include "estimator/segmentation/prompts.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/files.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Sequence three_frames() {
  Sequence sequence;
  for (int i = 0; i < 3; ++i) {
    SequenceFrame frame;
    frame.frame = i;
    frame.stamp_ns = 10'000'000'000 + 100'000'000LL * i;
    sequence.frames.push_back(frame);
  }
  return sequence;
}

std::vector<std::vector<BoxPrompt>> read_text_as_prompts(const std::string& text) {
  const TempFolder temp;
  write_text(temp.path() / "prompts.txt", text);
  return read_box_prompts(temp.path() / "prompts.txt", three_frames());
}

TEST(Prompts, AFolderNamesFramesByItsFilesAndObjectsByOverlap) {
  const TempFolder temp;
  const fs::path& folder = temp.path();
  write_text(folder / "10.000.txt", "100\t50\t80\t60\t0.9\n300 50 80 60 0.5\n");
  write_text(folder / "10.104.txt", "310 55 80 60\n\n110 50 80 60\n");  // 4 ms off its frame, the other order
  write_text(folder / "10.200.txt", "\n");
  const auto frames = read_box_prompts(folder, three_frames());
  ASSERT_EQ(frames.size(), 3u);
  ASSERT_EQ(frames[1].size(), 2u);
  EXPECT_EQ(frames[0][0].id, 1);
  EXPECT_EQ(frames[0][1].id, 2);
  EXPECT_EQ(frames[1][0].id, 2);
  EXPECT_EQ(frames[1][1].id, 1);
  EXPECT_EQ(frames[1][0].x, 310);
  EXPECT_TRUE(frames[2].empty());
}

TEST(Prompts, AFileGivesIdsOrHasThemFound) {
  auto frames = read_text_as_prompts("10.0 1 2 30 40 7\n10.1 1 2 30 40 9\n");
  EXPECT_EQ(frames[0].at(0).id, 7);
  EXPECT_EQ(frames[1].at(0).id, 9);
  frames = read_text_as_prompts("# stamp x y w h\n10.0 1 2 30 40\n10.1 1 2 30 40\n");
  EXPECT_EQ(frames[1].at(0).id, 1);
}

TEST(Prompts, ALoneBoxThatJumpsKeepsItsIdUnlessItJumpsTooFar) {
  std::vector<std::vector<BoxPrompt>> frames = {
      {{0, 0, 0, 50, 50}}, {{0, 100, 0, 50, 50}}, {{0, 500, 0, 50, 50}}};
  associate_boxes(frames, 640);
  EXPECT_EQ(frames[1][0].id, 1);  // no overlap, 100 px away
  EXPECT_EQ(frames[2][0].id, 2);  // 400 px: more than half the image
}

TEST(Prompts, BoxIou) {
  EXPECT_DOUBLE_EQ(box_iou({0, 0, 0, 2, 2}, {0, 1, 1, 2, 2}), 1.0 / 7);
  EXPECT_EQ(box_iou({0, 0, 0, 2, 2}, {0, 3, 0, 2, 2}), 0);
}

TEST(Prompts, BadFilesAreRefusedByLine) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"10.0 1 2 30\n", ":1: expected in every line"},
      {"10.0 1 2 30 40\n10.1 1 2 30 40 5\n", ":2: expected in every line"},
      {"10.0 1 2 x 40\n", ":1: 'x' is not a finite number"},
      {"10.0 1 2 nan 40\n", ":1: 'nan' is not a finite number"},
      {"10.0 1 2 0 40\n", ":1: a box needs a width and a height greater than 0"},
      {"10.0 700 2 10 40\n", ":1: the box lies outside the 640x480 image"},
      {"10.05 1 2 30 40\n", ":1: 10.05 is the stamp of no frame"},
      {"10.0 1 2 30 40 0\n", ":1: id '0' is not an integer from 1 to 65535"},
      {"10.0 1 2 30 40 3\n10.0 9 2 30 40 3\n", ":2: a second box of object 3 in one frame"},
      {"# nothing\n", ": holds no prompts"},
  };
  int refused = 0;
  for (const auto& [text, what] : cases) {
    try {
      read_text_as_prompts(text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("prompts.txt" + what), std::string::npos) << e.what();
      ++refused;
    }
  }
  EXPECT_EQ(refused, 10);
  EXPECT_THROW(read_box_prompts("no/such/file", three_frames()), InputError);
}

TEST(Prompts, TheCommandLineSaysTheirKind) {
  EXPECT_TRUE(parse_prompts("everything").empty());
  EXPECT_TRUE(parse_prompts("").empty());
  EXPECT_EQ(parse_prompts("points:a/b.txt").kind, PromptKind::points);
  EXPECT_EQ(parse_prompts("points:a/b.txt").path, "a/b.txt");
  EXPECT_EQ(parse_prompts("boxes:a").kind, PromptKind::boxes);
  EXPECT_EQ(parse_prompts("boxes:a").path, "a");
  EXPECT_EQ(parse_prompts("a/b").kind, PromptKind::boxes);
  EXPECT_EQ(parse_prompts("a/b").path, "a/b");
}

std::vector<std::vector<PointPrompt>> read_points(const std::string& text) {
  const TempFolder temp;
  write_text(temp.path() / "points.txt", text);
  return read_point_prompts(temp.path() / "points.txt", three_frames());
}

TEST(Prompts, PointsAreObjectsOfTheirOwnUnlessTheyHaveIds) {
  auto frames = read_points("# stamp u v\n10.0 5 6.5\n10.0 50 60\n10.2 7 8\n");
  ASSERT_EQ(frames.size(), 3u);
  ASSERT_EQ(frames[0].size(), 2u);
  EXPECT_EQ(frames[0][0].id, 1);
  EXPECT_EQ(frames[0][0].v, 6.5);
  EXPECT_EQ(frames[0][1].id, 2);
  EXPECT_TRUE(frames[1].empty());
  EXPECT_EQ(frames[2][0].id, 1);
  frames = read_points("10.0 5 6 4\n10.0 50 60 4\n");
  EXPECT_EQ(frames[0][0].id, 4);
  EXPECT_EQ(frames[0][1].id, 4);
}

TEST(Prompts, AFileSaysWhetherItNamesTheObjects) {
  const TempFolder temp;
  const auto names = [&](PromptKind kind, const std::string& text) {
    write_text(temp.path() / "prompts.txt", text);
    return have_ids({kind, temp.path() / "prompts.txt"});
  };
  EXPECT_TRUE(names(PromptKind::points, "# stamp u v id\n10.0 5 6 4\n"));
  EXPECT_FALSE(names(PromptKind::points, "10.0 5 6\n"));
  EXPECT_TRUE(names(PromptKind::boxes, "10.0 5 6 20 20 4\n"));
  EXPECT_TRUE(names(PromptKind::boxes, "10.0 5 6 20 20\n"));  // as they were associated
  EXPECT_FALSE(have_ids({}));
}

// The border pixels reach half a pixel beyond their centres; what is there must still index a pixel.
TEST(Prompts, PointsOnTheImagesRimBelongToItsPixels) {
  const auto frames = read_points("10.0 -0.5 -0.5\n10.0 639.5 479.5\n");
  EXPECT_EQ(frames[0][0].u, 0);
  EXPECT_EQ(frames[0][0].v, 0);
  EXPECT_EQ(frames[0][1].u, 639);
  EXPECT_EQ(frames[0][1].v, 479);
}

TEST(Prompts, AreOfAsManyObjectsAsMasksCanName) {
  std::string points, boxes;
  for (int i = 0; i < kMostIds; ++i) points += "10.0 5 6\n", boxes += "10.0 5 6 20 20\n";
  EXPECT_EQ(read_points(points)[0].size(), static_cast<std::size_t>(kMostIds));
  EXPECT_NE(input_error([&] { read_points(points + "10.0 5 6\n"); }).find(":257: more than 256 objects"),
            std::string::npos);
  const TempFolder temp;
  write_text(temp.path() / "boxes.txt", boxes + "10.0 5 6 20 20\n");
  EXPECT_NE(
      input_error([&] { read_box_prompts(temp.path() / "boxes.txt", three_frames()); }).find(":257: more"),
      std::string::npos);
}

TEST(Prompts, OfASequenceWithoutImagesAreOfNoFrame) {
  const TempFolder temp;
  write_text(temp.path() / "boxes.txt", "10.0 5 6 20 20\n");
  EXPECT_NE(input_error([&] { read_box_prompts(temp.path() / "boxes.txt", {}); }).find("stamp of no frame"),
            std::string::npos);
}

TEST(Prompts, BadPointsAreRefusedByLine) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"10.0 5\n", ":1: expected in every line: stamp u v"},
      {"10.0 5 6\n10.0 5 6 7\n", ":2: expected in every line"},
      {"10.0 5 x\n", ":1: 'x' is not a finite number"},
      {"10.0 5 6 0\n", ":1: id '0' is not an integer from 1 to 65535"},
      {"11.0 5 6\n", ":1: 11.0 is the stamp of no frame"},
      {"10.0 -3 6\n", ":1: the point lies outside the 640x480 image"},
      {"# nothing\n", "holds no prompts"}};
  int refused = 0;
  for (const auto& [text, what] : cases) {
    const std::string message = input_error([&] { read_points(text); });
    EXPECT_NE(message.find(what), std::string::npos) << message;
    ++refused;
  }
  EXPECT_EQ(refused, 7);
}

}  // namespace
}  // namespace uniquadric
