#include "core/sequence/ply.h"

#include <gtest/gtest.h>

#include <algorithm>
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

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n", kEnd = "end_header\n",
                  kFaces = "property list uchar int vertex_indices\n";

// One tetrahedron with a quad cut off it, its bytes in both orders.
TEST_F(Ply, ReadsTextAndBothOrdersOfBytesAlike) {
  const std::string elements = "element vertex 5\n" + kXyz + "property ushort mark\nelement face 2\n" +
                               kFaces + kEnd,
                    ascii = "ply\nformat ascii 1.0\n" + elements;
  const std::string rows[] = {"0 0 0 1",           "1.5 0 0 2", "+1e0 -2.25 0 3", "0 1 0 4",
                              "\t0  0 1.0 65535 ", "4 3 2 1 0", "3 0 1 4"};
  std::string unix_lines = ascii, dos = ascii, mac = ascii,
              big = "ply\nformat binary_big_endian 1.0\n" + elements;
  for (const std::string& row : rows) {
    unix_lines += row + "\n";
    dos += row + "\n\n";
    mac += &row == &rows[6] ? row : row + "\n";  // the last line does not end
  }
  std::replace(mac.begin(), mac.end(), '\n', '\r');
  for (std::size_t i = 0; (i = dos.find('\n', i)) != dos.npos; i += 2) dos.insert(i, "\r");
  const auto put_big = [&big](auto value) {
    std::string bytes;
    put(bytes, value);
    big.append(bytes.rbegin(), bytes.rend());
  };
  const float numbers[5][3] = {{0, 0, 0}, {1.5F, 0, 0}, {1, -2.25F, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const auto& point : numbers) {
    for (const float x : point) put_big(x);
    put_big(std::uint16_t{258});
  }
  for (const auto& face : {std::vector<int>{3, 2, 1, 0}, {0, 1, 4}}) {
    put_big(static_cast<std::uint8_t>(face.size()));
    for (const int corner : face) put_big(corner);
  }
  for (const std::string& text : {unix_lines, dos, mac, big}) {
    const SurfaceFile mesh = read(text);
    EXPECT_EQ(mesh.points,
              (std::vector<Eigen::Vector3f>{{0, 0, 0}, {1.5F, 0, 0}, {1, -2.25F, 0}, {0, 1, 0}, {0, 0, 1}}));
    EXPECT_EQ(mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{3, 2, 1}, {3, 1, 0}, {0, 1, 4}}));
    EXPECT_TRUE(mesh.normals.empty() && mesh.uvs.empty() && mesh.texture_file.empty() && !mesh.color);
  }
}

// The corner at which a polygon turns inwards lies on the edge between its two triangles, wherever it is
// listed.
TEST_F(Ply, CutsConcaveFacesWithinThem) {
  const SurfaceFile mesh = read("ply\nformat ascii 1.0\nelement vertex 4\n" + kXyz + "element face 3\n" +
                                kFaces + kEnd + "0 0 0\n2 -2 0\n1 0 0\n2 2 0\n4 0 1 2 3\n2 0 1\n4 1 2 3 0\n");
  EXPECT_EQ(mesh.triangles,
            (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}, {2, 3, 0}, {1, 2, 0}}));
}

TEST_F(Ply, ReadsTheLook) {
  const std::string face = "element face 1\n" + kFaces, triangle = "3 2 1 0\n",
                    start =
                        "ply\nformat ascii 1.0\ncomment TextureFile old.png\ncomment TextureFile  two "
                        "words.png \nelement vertex 3\n";
  using Uvs = std::vector<std::array<Eigen::Vector2f, 3>>;
  const Uvs uvs = {{Eigen::Vector2f(0.5F, 1), Eigen::Vector2f(0.25F, 0), Eigen::Vector2f(0, 0)}};
  for (const auto& [u, v] : {std::pair{"u", "v"}, {"s", "t"}, {"tx", "ty"}, {"texture_u", "texture_v"}}) {
    const SurfaceFile mesh = read(start + kXyz + "property float " + u + "\nproperty float " + v + "\n" +
                                  face + kEnd + "0 0 0 0 0\n1 0 0 0.25 0\n0 1 0 0.5 1\n" + triangle);
    EXPECT_EQ(mesh.texture_file, "two words.png");
    EXPECT_EQ(mesh.uvs, uvs) << u;
  }
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(read(start + kXyz + face + "property list uchar float texcoord\n" + kEnd + points +
                 "3 2 1 0 6 0.5 1 0.25 0 0 0\n")
                .uvs,
            uvs);
  const std::string material =
      "element material 2\nproperty TYPE diffuse_red\nproperty TYPE diffuse_green\nproperty TYPE "
      "diffuse_blue\n";
  const auto color = [&](const std::string& type, const std::string& values) {
    std::string text = start + kXyz + face + material + kEnd + points + triangle + values + "\n0 0 0\n";
    for (std::size_t i = 0; (i = text.find("TYPE")) != text.npos;) text.replace(i, 4, type);
    return read(text).color;
  };
  EXPECT_EQ(color("float", "1 0.5 0"), Eigen::Vector3f(1, 0.5F, 0));
  EXPECT_EQ(color("uchar", "255 51 0"), Eigen::Vector3f(1, 0.2F, 0));
  EXPECT_NE(input_error([&] { color("uchar", "256 51 0"); }).find(":20: material 0: has a colour"),
            std::string::npos);
}

TEST_F(Ply, RefusesWhatIsNoSurfaceWithTheLine) {
  const std::string start = "ply\nformat binary_little_endian 1.0\n";
  std::string point;
  put(point, 1.F, 2.F, 3.F);
  expect_refused("", ":1: the header does not end");
  expect_refused("plyx\n", ":1: expected ply");
  expect_refused("ply\nformat binary_middle_endian 1.0\n" + kEnd,
                 ":2: expected format ascii, binary_little_endian or");
  expect_refused("ply\n" + kEnd, ":2: the header has no format");
  expect_refused(start + "element vertex -1\n" + kEnd, ":3: expected element NAME COUNT");
  expect_refused(start + "element vertex 0\nelement vertex 1\n" + kEnd,
                 ":4: element vertex stands on line 3");
  expect_refused(start + "element vertex 1\nproperty half x\n" + kEnd, ":4: a property of an unknown type");
  expect_refused(start + "property float x\n" + kEnd, ":3: expected property");
  expect_refused(start + "points 3\n" + kEnd, ":3: 'points' is no entry");
  expect_refused(start + kEnd, ": has no points");
  expect_refused(start + "element vertex 0\n" + kEnd, ":3: vertex has no properties");
  for (const char* count : {"2", "9000000000000000000"})
    expect_refused(start + "element vertex " + count + "\n" + kXyz + kEnd + point,
                   std::string(":3: announces ") + count + " vertex, for which the file is too short");
  expect_refused(start + "element vertex 1\nproperty float x\n" + kEnd + point, ":3: vertex has no x, y, z");
  expect_refused(start + "element vertex 1\n" + kXyz + kEnd + point + "x", ": 1 bytes after the last row");
  std::string lost;
  put(lost, 1.F, std::numeric_limits<float>::quiet_NaN(), 3.F);
  expect_refused(start + "element vertex 2\n" + kXyz + kEnd + point + lost, ": vertex 1: is not finite");
  const std::string face =
      start + "element vertex 1\n" + kXyz + "element face 2\n" + kFaces + kEnd + point + '\0';
  std::string wrong = face, endless = face;
  put(wrong, std::uint8_t{3}, 0, 0, 1);
  expect_refused(wrong, ": face 1: has corner 1 of 1 points");
  put(endless, std::uint8_t{200}, 0);
  expect_refused(endless, ": face 1: is cut short");
  std::string negative = start + "element vertex 1\n" + kXyz +
                         "element face 1\nproperty list char int vertex_index\n" + kEnd + point;
  expect_refused(negative + '\xff', ": face 0: vertex_index has -1 values");
  std::string many = start + "element vertex 1\n" + kXyz +
                     "element face 1\nproperty list short uchar vertex_index\n" + kEnd + point;
  put(many, std::int16_t{1001});
  expect_refused(many + std::string(1001, '\0'), ": face 0: has 1001 corners, at most 1000 are read");
}

TEST_F(Ply, RefusesDamagedText) {
  const std::string start = "ply\nformat ascii 1.0\nelement vertex 3\n" + kXyz + "element face 1\n" + kFaces +
                            kEnd,
                    points = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(read(start + "\n" + points + " \n3 0 1 2\n\n").triangles.size(), 1u);
  expect_refused(start + "0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n",
                 ":11: vertex 1: expected a number, found 'zero'");
  expect_refused(start + "0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n", ":11: vertex 1: expected a number, found 'nan'");
  expect_refused(start + "0 0 0\n1 0\n0 1 0\n3 0 1 2 3 4\n", ":11: vertex 1: has fewer numbers");
  expect_refused(start + "0 0 0\n\n1 0 0 5\n0 1 0\n3 0 1 2\n", ":12: vertex 1: has more numbers");
  expect_refused(start + points + "3 0 1\n", ":13: face 0: has fewer numbers");
  expect_refused(start + points + "3 0 1 3\n", ":13: face 0: has corner 3 of 3 points");
  expect_refused(start + points + "3 0 1 0.5\n", ":13: face 0: has corner 0.5 of 3 points");
  expect_refused(start + points + "2.5 0 1 2\n", ":13: face 0: vertex_indices has 2.5 values");
  expect_refused(start + points + "1e300 0 1 2\n", ":13: face 0: is cut short");
  expect_refused(start + "0 0 0\n1 0 0\n0 1.000000\n", ":12: vertex 2: has fewer numbers");
  expect_refused(start + "0 0 0\n1.00000000 0 0\n", ":3: announces 3 vertex, of which there are 2");
  expect_refused(start + points + "\n\n\n", ":7: announces 1 face, of which there are 0");
  expect_refused(start + points + "3 0 1 2\nend\n", ":14: 4 bytes after the last row");
  expect_refused(start + "2e9 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", ":10: vertex 0: is not finite, or lies beyond");
}

}  // namespace
}  // namespace uniquadric
