#include "core/sequence/tracks.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "core/base/files.h"
#include "core/sequence/calibration.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Tracks two_objects() {
  Tracks tracks;
  for (int i = 0; i < 4; ++i) tracks.camera.push_back({i * 100, {exp_so3({0.1 * i, 0, 0}), {0.1 * i, 0, 0}}});
  for (const int id : {3, 7}) {
    ObjectTrack track{id, "", {}};
    for (int i = id == 3 ? 0 : 2; i < 4; ++i) {
      ObjectState state;
      state.frame = i;
      state.stamp_ns = i * 100;
      state.ellipsoid = {{exp_so3({0, 0.1 * i, 0}), {1.0 / 3, 0, 0.1 * id}}, {0.1, 0.2, 1.0 / 7}};
      state.exponents = {1.5, 1.25, 2};
      state.profile_axis = 1;
      state.covariance_diagonal[0] = 1e-4;
      state.status = i == 3 ? ObjectStatus::occluded : ObjectStatus::active;
      state.motion = i == 0 ? ObjectMotion::unknown : i == 3 ? ObjectMotion::at_rest : ObjectMotion::moving;
      track.states.push_back(state);
    }
    tracks.objects.push_back(track);
  }
  return tracks;
}

TEST(Tracks, AnEstimateReadsBackAsItWasWritten) {
  const TempFolder temp;
  const Tracks written = two_objects();
  write_estimate(temp.path(), written);
  const Tracks read = read_tracks(temp.path());
  ASSERT_EQ(read.camera.size(), 4u);
  ASSERT_EQ(read.objects.size(), 2u);
  EXPECT_EQ(read.objects[1].id, 7);
  ASSERT_EQ(read.objects[1].states.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t i = 0; i < read.objects[k].states.size(); ++i) {
      const ObjectState &a = written.objects[k].states[i], &b = read.objects[k].states[i];
      EXPECT_EQ(a.frame, b.frame);
      EXPECT_EQ(a.stamp_ns, b.stamp_ns);
      EXPECT_EQ(a.ellipsoid.semi_axes_m, b.ellipsoid.semi_axes_m);
      EXPECT_EQ(a.ellipsoid.world_from_object.translation, b.ellipsoid.world_from_object.translation);
      EXPECT_EQ(a.ellipsoid.world_from_object.rotation.coeffs(),
                b.ellipsoid.world_from_object.rotation.coeffs());
      EXPECT_EQ(a.exponents, b.exponents);
      EXPECT_EQ(b.profile_axis, 1);
      EXPECT_EQ(a.status, b.status);
      EXPECT_EQ(a.motion, b.motion);
      EXPECT_EQ(b.covariance_diagonal[0], 1e-4);
      EXPECT_TRUE(std::isnan(b.covariance_diagonal[1]));
    }
}

TEST(Tracks, AVarianceThatIsNoneIsNotWritten) {
  const TempFolder temp;
  Tracks tracks = two_objects();
  Vector9d& variances = tracks.objects[0].states[1].covariance_diagonal;
  variances.setConstant(1e-6);
  variances[2] = std::numeric_limits<double>::infinity();
  variances[4] = -1e-150;
  variances[7] = 0;
  write_estimate(temp.path(), tracks);
  const Vector9d read = read_tracks(temp.path()).objects[0].states[1].covariance_diagonal;
  for (int i = 0; i < 9; ++i)
    if (i == 2 || i == 4)
      EXPECT_TRUE(std::isnan(read[i])) << i;
    else
      EXPECT_EQ(read[i], i == 7 ? 0 : 1e-6) << i;
}

// The table of an older program, which had fewer columns.
void keep_columns(const fs::path& csv, int columns) {
  std::string text;
  std::istringstream lines(read_text(csv));
  for (std::string line; std::getline(lines, line);) {
    std::size_t end = 0;
    for (int i = 0; i < columns; ++i) end = line.find(',', end + 1);
    text += line.substr(0, end) + "\n";
  }
  write_text(csv, text);
}

TEST(Tracks, AnEstimateWithoutTheColumnsOfProfilesHasOneExponent) {
  const TempFolder temp;
  write_estimate(temp.path(), two_objects());
  keep_columns(temp.path() / "objects.csv", 18);
  const Tracks read = read_tracks(temp.path());
  ASSERT_EQ(read.objects.size(), 2u);
  EXPECT_EQ(read.objects[1].states.back().motion, ObjectMotion::at_rest);
  for (const ObjectTrack& track : read.objects)
    for (const ObjectState& state : track.states) {
      EXPECT_EQ(state.exponents, (SuperExponents{1.5, 1.5, 1.5}));
      EXPECT_EQ(state.profile_axis, 2);
    }
}

TEST(Tracks, AnEstimateWithoutTheColumnOfMotionReadsAsUnknown) {
  const TempFolder temp;
  write_estimate(temp.path(), two_objects());
  keep_columns(temp.path() / "objects.csv", 17);
  const Tracks read = read_tracks(temp.path());
  ASSERT_EQ(read.objects.size(), 2u);
  EXPECT_EQ(read.objects[1].states.back().status, ObjectStatus::occluded);
  for (const ObjectTrack& track : read.objects)
    for (const ObjectState& state : track.states) EXPECT_EQ(state.motion, ObjectMotion::unknown);
}

TEST(Tracks, ATruthFolderIsTracksToo) {
  const TempFolder temp;
  const Tracks tracks = two_objects();
  fs::create_directories(temp.path() / "objects");
  write_tum(temp.path() / "camera.tum", tracks.camera);
  write_objects_yaml(temp.path() / "objects.yaml", {{7, "cube", {0.2, 0.2, 0.2}, "box", ""}});
  write_tum(temp.path() / "objects/7.tum", {{200, {}}, {300, {}}});
  write_camera_yaml(temp.path() / "camera.yaml", Camera{});
  const Tracks read = read_tracks(temp.path());
  ASSERT_EQ(read.objects.size(), 1u);
  EXPECT_EQ(read.objects[0].name, "cube");
  ASSERT_EQ(read.objects[0].states.size(), 2u);
  EXPECT_EQ(read.objects[0].states[1].frame, 3);
  EXPECT_EQ(read.objects[0].states[1].ellipsoid.semi_axes_m, Eigen::Vector3d::Constant(0.2));
  ASSERT_TRUE(read.calibration.has_value());
  EXPECT_EQ(read.calibration->fx, Camera{}.fx);
}

TEST(Tracks, BadFoldersAreRefusedByFileAndLine) {
  const TempFolder temp;
  write_estimate(temp.path(), two_objects());
  const fs::path csv = temp.path() / "objects.csv";
  const std::string good = read_text(csv);
  const auto message = [&](const std::string& find, const std::string& replacement) {
    std::string text = good;
    text.replace(text.find(find), find.size(), replacement);
    write_text(csv, text);
    return input_error([&] { read_tracks(temp.path()); }).substr(csv.string().size());
  };
  EXPECT_EQ(message("\n0,0,3,0.1", "\n0,0,3,nan"), ":2: column semi_axis_x_m: 'nan' is not a valid value");
  EXPECT_EQ(message("\n0,0,3,0.1", "\n0,0,3,-0.1"), ":2: column semi_axis_x_m: '-0.1' is not a valid value");
  EXPECT_EQ(message("\n0,0,3,0.1", "\n0,0,3,1e200"), ":2: semi-axes: expected at most 1000000 m");
  EXPECT_EQ(message("\n0,0,3,0.1", "\n0,0,3,1e-300"), ":2: semi-axes: expected at least 1e-09 m");
  EXPECT_EQ(message("\n0,0,3,0.1", "\n0,0,3,1e-8"), ":2: semi-axes: are more than 1000000 times apart");
  for (const char* q : {"0.999", "2.001", "100"})
    EXPECT_EQ(message(",1.5,", fmt::format(",{},", q)),
              fmt::format(":2: column exponent_q: '{}' is not from 1 (a box) to 2 (an ellipsoid)", q));
  EXPECT_EQ(message("\n0,0,3,", "\n0,0,0,"), ":2: column id: '0' is not a valid value");
  EXPECT_EQ(message("active,unknown", "asleep,unknown"), ":2: column state: 'asleep' is not a valid value");
  EXPECT_EQ(message("active,unknown", "active,idle"), ":2: column motion: 'idle' is not a valid value");
  EXPECT_EQ(message("active,unknown", "active"), ":2: expected 21 columns, found 20");
  EXPECT_EQ(message(",1.25,2,y", ",0.9,2,y"),
            ":2: column exponent_upper_q: '0.9' is not from 1 (a box) to 2 (an ellipsoid)");
  EXPECT_EQ(message(",1.25,2,y", ",1.25,2,xy"), ":2: column profile_axis: 'xy' is not a valid value");
  EXPECT_EQ(message("\n1,100,3", "\n1,0,3"), ":3: timestamp 0 of object 3 does not come after 0");
  EXPECT_EQ(message("\n1,100,3", "\n0,100,3"), ":3: frame 0 of object 3 does not come after 0");
  write_text(csv, good);
  write_text(temp.path() / "objects/9.tum", "");
  EXPECT_NO_THROW(read_tracks(temp.path()));  // nothing of it is left out
  fs::copy_file(temp.path() / "objects/7.tum", temp.path() / "objects/9.tum",
                fs::copy_options::overwrite_existing);
  EXPECT_EQ(input_error([&] { read_tracks(temp.path()); }),
            (temp.path() / "objects/9.tum").string() + ": objects.csv has no row of this object");
  fs::remove(temp.path() / "objects/9.tum");
  fs::remove(temp.path() / "objects/7.tum");
  EXPECT_NE(input_error([&] { read_tracks(temp.path()); }).find("7.tum: cannot be read"), std::string::npos);
  fs::remove(csv);
  EXPECT_NE(input_error([&] { read_tracks(temp.path()); }).find("objects.yaml has no size of object 3"),
            std::string::npos);
  fs::remove(temp.path() / "camera.tum");
  EXPECT_NE(input_error([&] { read_tracks(temp.path()); }).find("neither objects.yaml"), std::string::npos);
}

TEST(Tracks, AHeaderIsRefusedByTheColumnThatItLacksOrThatNobodyKnows) {
  const TempFolder temp;
  write_estimate(temp.path(), two_objects());
  const fs::path csv = temp.path() / "objects.csv";
  const std::string good = read_text(csv);
  const auto fault = [&](const std::string& find, const std::string& replacement) {
    std::string text = good;
    text.replace(text.find(find), find.size(), replacement);
    write_text(csv, text);
    return input_error([&] { read_tracks(temp.path()); }).substr(csv.string().size());
  };
  EXPECT_EQ(fault("frame,", "fraem,").find(":1: column 'fraem' is unknown; known are frame,timestamp_ns,id,"),
            0u);
  EXPECT_EQ(fault(",id,", ","), ":1: column 'id' is missing");
  EXPECT_EQ(fault("timestamp_ns,", ""), ":1: column 'timestamp_ns' is missing");
  EXPECT_EQ(fault("profile_axis", "id"), ":1: column 'id' stands twice");
  EXPECT_EQ(fault(",motion", ""), ":2: expected 20 columns, found 21");
}

// Columns in another order, and only those that a program has; what is left out has its default.
TEST(Tracks, AnEstimateMayHaveOnlyTheColumnsThatAProgramKnows) {
  const TempFolder temp;
  write_estimate(temp.path(), two_objects());
  write_text(temp.path() / "objects.csv",
             "id,timestamp_ns,semi_axis_z_m,semi_axis_y_m,semi_axis_x_m\n3,0,0.3,0.2,0.1\n3,100,0.3,0.2,0.1\n"
             "3,200,0.3,0.2,0.1\n3,300,0.3,0.2,0.1\n7,200,1,1,1\n7,300,1,1,1\n");
  const Tracks read = read_tracks(temp.path()), written = two_objects();
  ASSERT_EQ(read.objects.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(read.objects[i].states.size(), written.objects[i].states.size());
    for (std::size_t k = 0; k < read.objects[i].states.size(); ++k)
      EXPECT_EQ(read.objects[i].states[k].ellipsoid.world_from_object.translation,
                written.objects[i].states[k].ellipsoid.world_from_object.translation);
  }
  const ObjectState& state = read.objects[0].states[1];
  EXPECT_EQ(state.ellipsoid.semi_axes_m, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(state.frame, 1);  // the second stamp of the folder
  EXPECT_EQ(state.exponents, SuperExponents{});
  EXPECT_EQ(state.status, ObjectStatus::active);
  EXPECT_TRUE(state.covariance_diagonal.array().isNaN().all());
}

// objects/ID.tum and sizes are a whole result.
TEST(Tracks, AnEstimateMayBePosesAndSizesAlone) {
  const TempFolder temp;
  fs::create_directories(temp.path() / "objects");
  write_text(temp.path() / "objects/4.tum", "0.5 1 2 3 0 0 0 1\n0.6 1 2 4 0 0 0 1\n");
  write_text(temp.path() / "objects/5.tum", "0.6 1 2 4 0 0 0 1\n");
  write_text(temp.path() / "objects.yaml",
             "4: {size_m: [0.2, 0.4, 0.6]}\n"
             "5: {semi_axes_m: [1, 2, 3], shape: {superellipsoid: {q: [1.5, 1.25, 1], axis: x}}}\n");
  const Tracks read = read_tracks(temp.path());
  EXPECT_TRUE(read.camera.empty());
  ASSERT_EQ(read.objects.size(), 2u);
  ASSERT_EQ(read.objects[0].states.size(), 2u);
  EXPECT_EQ(read.objects[0].states[1].stamp_ns, 600'000'000);
  EXPECT_EQ(read.objects[0].states[1].ellipsoid.semi_axes_m, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(read.objects[0].states[1].ellipsoid.world_from_object.translation, Eigen::Vector3d(1, 2, 4));
  EXPECT_EQ(read.objects[0].states[1].exponents, (SuperExponents{1, 1, 1}));  // a size is a box's
  EXPECT_EQ(read.objects[1].states[0].exponents, (SuperExponents{1.5, 1.25, 1}));
  EXPECT_EQ(read.objects[1].states[0].profile_axis, 0);
  EXPECT_EQ(read.objects[1].states[0].frame, 1);
}

TEST(Tracks, ABadListOfSizesIsRefusedByTheObject) {
  const TempFolder temp;
  const fs::path sizes = temp.path() / "objects.yaml";
  fs::create_directories(temp.path() / "objects");
  write_text(temp.path() / "objects/4.tum", "0.5 1 2 3 0 0 0 1\n");
  const auto message = [&](const std::string& text) {
    write_text(sizes, text);
    return input_error([&] { read_tracks(temp.path()); });
  };
  const auto has = [&](const std::string& text, const std::string& what) {
    const std::string said = message(text);
    EXPECT_NE(said.find(what), std::string::npos) << said;
  };
  has("4: {size_m: [0.2, 0, 0.6]}\n", "objects.yaml:1: 4.size_m: expected numbers greater than 0");
  has("4: {size_m: [0.2, 0.2]}\n", "objects.yaml:1: 4.size_m");
  has("4: {size_m: [1, 1, 1], semi_axes_m: [1, 1, 1]}\n", "expected either size_m or semi_axes_m");
  has("4: {size_m: [1, 1, 1], colour: red}\n", "colour");
  has("four: {size_m: [1, 1, 1]}\n", "'four' is no id of an object");
  has("5: {size_m: [1, 1, 1]}\n", "objects.yaml has no size of object 4");
  has("4: {size_m: [1, 1, 1]}\n5: {size_m: [1, 1, 1]}\n", "object 5 has no poses: objects/5.tum is missing");
  has("4: {semi_axes_m: [1, 1, 1], shape: {superellipsoid: {q: [3, 1, 1]}}}\n", "from 1 (a box) to 2");
}

TEST(Tracks, DescriptionsWithBadAxesOrIdsAreRefused) {
  const TempFolder temp;
  const fs::path path = temp.path() / "objects.yaml";
  const auto message = [&](const std::string& item) {
    write_text(path, "schema: 1\nobjects:\n  - {id: 1, name: a, semi_axes_m: [1, 1, 1]}\n  - " + item + "\n");
    return input_error([&] { read_objects_yaml(path); }).substr(path.string().size());
  };
  EXPECT_EQ(message("{id: 1, name: b, semi_axes_m: [1, 1, 1]}"), ":4: objects[1].id: 1 stands twice");
  EXPECT_EQ(message("{id: 2, name: \"a,b\", semi_axes_m: [1, 1, 1]}"),
            ":4: objects[1].name: expected a name: not empty, no comma, quote, slash or control character, "
            "no = + - @ or dot first");
  EXPECT_EQ(message("{id: 2, name: b, semi_axes_m: [1, 0, 1]}"),
            ":4: objects[1].semi_axes_m: expected numbers greater than 0");
  EXPECT_EQ(message("{id: 2, name: b, semi_axes_m: [1, 1e300, 1]}"),
            ":4: objects[1].semi_axes_m: expected at most 1000000 m");
  EXPECT_EQ(message("{id: 2, name: b, semi_axes_m: [1, .nan, 1]}"),
            ":4: objects[1].semi_axes_m[1]: expected a finite number");
}

TEST(Tracks, ObjectDescriptionsReadBack) {
  const TempFolder temp;
  const std::vector<ObjectDescription> written = {
      {1, "can", {0.1, 0.1, 0.2}, "mesh", "a/can.obj", BodySymmetry::revolution},
      {2, "it's odd", {1.0 / 3, 0.1, 0.2}, "", "", std::nullopt, false}};
  write_objects_yaml(temp.path() / "objects.yaml", written);
  const auto read = read_objects_yaml(temp.path() / "objects.yaml");
  ASSERT_EQ(read.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read[i].id, written[i].id);
    EXPECT_EQ(read[i].semi_axes_m, written[i].semi_axes_m);
    EXPECT_EQ(read[i].mesh, written[i].mesh);
    EXPECT_EQ(read[i].symmetry, written[i].symmetry);
    EXPECT_EQ(read[i].is_scored, written[i].is_scored);
  }
}

// A file of objects that are all scored keeps its bytes, and so its hash.
TEST(Tracks, DescriptionsSayScoredOnlyWhereItIsFalse) {
  const TempFolder temp;
  const fs::path path = temp.path() / "objects.yaml";
  ObjectDescription hand{1, "hand", {0.1, 0.1, 0.2}, "box", ""};
  write_objects_yaml(path, {hand});
  EXPECT_EQ(read_text(path).find("scored"), std::string::npos);
  hand.is_scored = false;
  write_objects_yaml(path, {hand});
  EXPECT_NE(read_text(path).find(", scored: false}"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
