#include "core/sequence/ply.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/base/files.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

template <typename... T>
void put(std::string& text, T... values) {
  (text.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
}

class Ply : public testing::Test {
 protected:
  std::filesystem::path file() const { return temp_.path() / "surface.ply"; }
  SurfaceFile read(const std::string& text) {
    write_text(file(), text);
    return read_surface_ply(file());
  }
  void expect_refused(const std::string& text, const std::string& why) {
    EXPECT_NE(input_error([&] { read(text); }).find("surface.ply" + why), std::string::npos) << why;
  }
  TempFolder temp_;
};

TEST_F(Ply, ReadsBackWhatWasWritten) {
  const SurfaceFile mesh{{{0, 0, 0}, {1.5F, 0, -2}, {0, 1e-7F, 3}}, {}, {{0, 1, 2}, {2, 1, 0}}};
  write_surface_ply(file(), mesh, "a mesh");
  const SurfaceFile again = read_surface_ply(file());
  EXPECT_EQ(again.points, mesh.points);
  EXPECT_EQ(again.triangles, mesh.triangles);
  EXPECT_TRUE(again.normals.empty());
  const SurfaceFile cloud{{{1, 2, 3}, {4, 5, 6}}, {{0, 0, 1}, {0, -1, 0}}};
  write_surface_ply(file(), cloud, "points");
  EXPECT_EQ(read_surface_ply(file()).points, cloud.points);
  EXPECT_EQ(read_surface_ply(file()).normals, cloud.normals);
  EXPECT_TRUE(read_surface_ply(file()).triangles.empty());
}

// Doubles, colours between them, another element, a quad, line ends of another system.
TEST_F(Ply, ReadsOtherProgramsFiles) {
  std::string text =
      "ply\r\nformat binary_little_endian 1.0\r\ncomment x\r\nelement vertex 4\r\nproperty double x\r\n"
      "property uchar red\r\nproperty double y\r\nproperty double z\r\nelement edge 1\r\n"
      "property int vertex1\r\nelement face 1\r\nproperty list uint8 uint32 vertex_index\r\n"
      "property float quality\r\nend_header\r\n";
  for (int i = 0; i < 4; ++i) put(text, double(i), std::uint8_t{255}, 0.5 * i, -1.0 * i);
  put(text, std::int32_t{7});
  put(text, std::uint8_t{4}, std::uint32_t{3}, std::uint32_t{0}, std::uint32_t{1}, std::uint32_t{2}, 0.25F);
  const SurfaceFile mesh = read(text);
  ASSERT_EQ(mesh.points.size(), 4u);
  EXPECT_EQ(mesh.points[3], Eigen::Vector3f(3, 1.5, -3));
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{3, 0, 1}, {3, 1, 2}}));
}

TEST_F(Ply, RefusesWhatIsNoSurfaceWithTheLine) {
  const std::string start = "ply\nformat binary_little_endian 1.0\n",
                    xyz = "property float x\nproperty float y\nproperty float z\n", end = "end_header\n";
  std::string point;
  put(point, 1.F, 2.F, 3.F);
  expect_refused("", ":1: the header does not end");
  expect_refused("plyx\n", ":1: expected ply");
  expect_refused("ply\nformat ascii 1.0\n" + end, ":2: only the format binary_little_endian");
  expect_refused("ply\n" + end, ":2: the header has no format");
  expect_refused(start + "element vertex -1\n" + end, ":3: expected element NAME COUNT");
  expect_refused(start + "element vertex 1\nproperty half x\n" + end, ":4: a property of an unknown type");
  expect_refused(start + "property float x\n" + end, ":3: expected property");
  expect_refused(start + "points 3\n" + end, ":3: 'points' is no entry");
  expect_refused(start + end, ": has no points");
  expect_refused(start + "element vertex 1\n" + end, ": vertex: without properties");
  expect_refused(start + "element vertex 2\n" + xyz + end + point, ": its data are cut short");
  expect_refused(start + "element vertex 9000000000000000000\n" + xyz + end + point,
                 ": its data are cut short");
  expect_refused(start + "element vertex 1\nproperty float x\n" + end + point,
                 ": its vertices have no x, y, z");
  expect_refused(start + "element vertex 1\n" + xyz + end + point + "x", ": 1 bytes after its data");
  std::string lost;
  put(lost, 1.F, std::numeric_limits<float>::quiet_NaN(), 3.F);
  expect_refused(start + "element vertex 1\n" + xyz + end + lost, ": point 0 is not finite");
  std::string face = start + "element vertex 1\n" + xyz +
                     "element face 1\nproperty list uchar int vertex_indices\n" + end + point;
  std::string wrong = face, endless = face;
  put(wrong, std::uint8_t{3}, 0, 0, 1);
  expect_refused(wrong, ": a face has point 1 of 1");
  put(endless, std::uint8_t{200}, 0);
  expect_refused(endless, ": its data are cut short");
}

}  // namespace
}  // namespace uniquadric
