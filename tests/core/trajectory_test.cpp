#include "core/sequence/trajectory.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "core/base/random.h"
#include "core/sequence/stamps.h"
#include "core/sequence/tum_as_written.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

TEST(Stamps, SecondsBecomeNanosecondsExactly) {
  EXPECT_EQ(parse_stamp_ns("1341841278.8427"), 1341841278842700000);
  EXPECT_EQ(parse_stamp_ns("0"), 0);
  EXPECT_EQ(parse_stamp_ns("-1.5"), -1500000000);
  EXPECT_EQ(parse_stamp_ns(".25"), 250000000);
  EXPECT_EQ(parse_stamp_ns("0.1234567894"), 123456789);
  EXPECT_EQ(parse_stamp_ns("0.12345678951"), 123456790);
  EXPECT_EQ(parse_stamp_ns("1.5e3"), 1500000000000);
  for (const char* bad : {"", ".", "abc", "1.2.3", "nan", "inf", "-", "1s", "99999999999", "4500000000.1",
                          "-4500000001", "4.6e9"})
    EXPECT_THROW(parse_stamp_ns(bad), std::invalid_argument) << bad;
  EXPECT_EQ(parse_stamp_of_ns("-4500000000000000000"), -kMostStamp_ns);
  for (const char* bad : {"4500000000000000001", "1.5", "", "9223372036854775807"})
    EXPECT_FALSE(parse_stamp_of_ns(bad)) << bad;
  for (const std::int64_t ns :
       {std::int64_t{0}, std::int64_t{-1}, std::int64_t{33333333}, std::int64_t{1341841278842700001}})
    EXPECT_EQ(parse_stamp_ns(format_stamp(ns)), ns);
}

TEST(TumText, ReadsBackTheSameDoubles) {
  RandomStream random(1, "poses");
  Trajectory written;
  for (int i = 0; i < 50; ++i)
    written.push_back({i * 33'333'333LL,
                       {exp_so3({random.normal(), random.normal(), random.normal()}),
                        {random.normal(), 1e-9 * random.normal(), 1e6 * random.normal()}}});
  const TempFolder temp;
  write_tum(temp.path() / "t.tum", written);
  const Trajectory read = read_tum(temp.path() / "t.tum");
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].stamp_ns, written[i].stamp_ns);
    EXPECT_EQ(read[i].pose.translation, written[i].pose.translation);
    EXPECT_EQ(read[i].pose.rotation.coeffs(), written[i].pose.rotation.coeffs());
  }
}

TEST(TumText, RefusesBadLinesByNumber) {
  const TempFolder temp;
  const auto message = [&](const std::string& second_line) {
    const auto path = temp.path() / "t.tum";
    write_text(path, "# stamp tx ty tz qx qy qz qw\n1.0 0 0 0 0 0 0 1\n" + second_line + "\n");
    const std::string text = input_error([&] { read_tum(path); });
    EXPECT_TRUE(text.starts_with(path.string() + ":3: ")) << text;
    return text.substr(std::min(text.size(), path.string().size() + 4));
  };
  EXPECT_EQ(message("2.0 0 0 0 0 0 1"), "expected 8 numbers (timestamp tx ty tz qx qy qz qw), found 7");
  EXPECT_EQ(message("2.0 nan 0 0 0 0 0 1"), "'nan' is not a finite number");
  EXPECT_EQ(message("2.0 0 0 0 0 0 inf 1"), "'inf' is not a finite number");
  EXPECT_EQ(message("2.0 0 -1e308 0 0 0 0 1"), "'-1e308' is further than 1000000000 m from the origin");
  EXPECT_EQ(message("0.5 0 0 0 0 0 0 1"), "timestamp 0.5 comes before 1.000000000");
  EXPECT_EQ(message("2.0 0 0 0 0 0 0 1.1"), "quaternion has norm 1.1, not 1");
  EXPECT_EQ(message("2.0 0 0 0 0 0 0 0"), "quaternion has norm 0, not 1");
  EXPECT_EQ(message("x 0 0 0 0 0 0 1"), "'x' is not a timestamp in seconds");
}

TEST(TumText, KeepsTheFirstOfEqualStampsAndCountsTheRest) {
  const TempFolder temp;
  const auto path = temp.path() / "t.tum";
  write_text(path,
             "1.0 1 0 0 0 0 0 1\n1.000 2 0 0 0 0 0 1\n2 3 0 0 0 0 0 1\n2.0 4 0 0 0 0 0 1\n"
             "2.0 5 0 0 0 0 0 1\n3 6 0 0 0 0 0 1\n");
  testing::internal::CaptureStderr();
  const Trajectory read = read_tum(path);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "warning: " + path.string() +
                ": 3 of 6 poses repeat the timestamp before them: the first of each is kept\n");
  ASSERT_EQ(read.size(), 3u);
  const std::vector<double> first_x = {1, 3, 6};
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].stamp_ns, static_cast<std::int64_t>(i + 1) * 1'000'000'000);
    EXPECT_EQ(read[i].pose.translation.x(), first_x[i]);
  }
}

TEST(TumText, NamesAFileThatMayBeCut) {
  const TempFolder temp;
  const auto path = temp.path() / "t.tum";
  const auto said = [&](const std::string& text) {
    write_text(path, text);
    testing::internal::CaptureStderr();
    read_tum(path);
    return testing::internal::GetCapturedStderr();
  };
  const std::string whole = "1 0 0 0 0 0 0.6 0.8000\n2 0 0 0 0 0 0.6 0.8000\n";
  EXPECT_EQ(said(whole), "");
  EXPECT_EQ(said(whole.substr(0, whole.size() - 1)), "") << "many files have no last line end";
  EXPECT_NE(said(whole.substr(0, whole.size() - 3)).find("the file may be cut"), std::string::npos);
}

TEST(TumText, AsWrittenKeepsEveryPoseInTheFilesOrder) {
  const TempFolder temp;
  const auto path = temp.path() / "t.tum";
  write_text(path, "2.5 1 0 0 0 0 0 1\n2.5 2 0 0 0 0 0 1\n1.3e0 3 0 0 0 0 0 1\n");
  testing::internal::CaptureStderr();
  const WrittenPoses read = read_tum_as_written(path);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(read.stamps_s, (std::vector<double>{2.5, 2.5, 1.3}));
  ASSERT_EQ(read.poses.size(), 3u);
  EXPECT_EQ(read.poses[1].pose.translation.x(), 2);
  EXPECT_EQ(read.poses[2].stamp_ns, 1'300'000'000);
}

TEST(TumText, NormalisesNearlyUnitQuaternions) {
  const TempFolder temp;
  write_text(temp.path() / "t.tum", "1 0 0 0 0 0 0 1.0009\r\n2\t0  0 0 0 0 0 1 \n\n");
  const Trajectory read = read_tum(temp.path() / "t.tum");
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].pose.rotation.w(), 1.0);
}

}  // namespace
}  // namespace uniquadric
