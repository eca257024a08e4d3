#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <set>

#include "simulator/scene/mesh_building.h"
#include "simulator/scene/shapes.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kSingle = 1.2e-7;  // relative: one step of single precision

struct Case {
  std::string name;
  Vector3d size_m;
  std::vector<Mesh> meshes;
};

std::vector<Case> closed_bodies() {
  const Material material{.size_px = 32};
  std::vector<Case> cases;
  const auto add = [&](const std::string& name, const Vector3d& size_m, std::vector<Mesh> meshes) {
    cases.push_back({name, size_m, std::move(meshes)});
  };
  const Vector3d odd(0.61, 0.43, 0.29), board(0.8, 0.2, 0.14), saloon(4.4, 1.8, 1.5), train(12, 2.8, 3.4);
  add("box", odd, rounded_box(odd, {.radius_m = 0}, material));
  add("rounded_box", odd, rounded_box(odd, {.radius_m = 0.05}, material));
  add("fully_rounded_box", odd, rounded_box(odd, {.radius_m = 0.145}, material));
  add("recessed_box", odd, rounded_box(odd, {.radius_m = 0.03, .recess_depth_m = 0.02}, material));
  add("recessed_sharp_box", odd, rounded_box(odd, {.radius_m = 0, .recess_depth_m = 0.02}, material));
  add("ball", {0.27, 0.27, 0.27}, ellipsoid({0.27, 0.27, 0.27}, 20, material));
  add("ellipsoid", odd, ellipsoid(odd, 12, material));
  add("cylinder", odd, cylinder(odd, 40, material));
  add("skateboard", board, skateboard(board, material));
  add("car", saloon, car(saloon, material));
  add("carriage", train, carriage(train, material));
  return cases;
}

double signed_volume(const std::vector<Mesh>& meshes) {
  double volume = 0;
  for (const Mesh& mesh : meshes)
    for (const auto& t : mesh.triangles) {
      const Vector3d a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                     c = mesh.positions[t[2]].cast<double>();
      volume += a.dot(b.cross(c)) / 6;
    }
  return volume;
}

using Point = std::array<float, 3>;
Point key(const Eigen::Vector3f& p) {
  return {p.x() + 0.0f, p.y() + 0.0f, p.z() + 0.0f};  // -0 and 0 are one place
}

TEST(GeneratedMeshes, HaveExactExtentsAboutTheirCentre) {
  int cases = 0;
  for (const Case& c : closed_bodies()) {
    SCOPED_TRACE(c.name);
    const Eigen::AlignedBox3d box = tight_box(c.meshes);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(box.min()[k], -c.size_m[k] / 2, kSingle * c.size_m[k]);
      EXPECT_NEAR(box.max()[k], c.size_m[k] / 2, kSingle * c.size_m[k]);
    }
    ++cases;
  }
  EXPECT_EQ(cases, 11);
}

// Each directed edge is matched by its opposite: no hole, no flipped triangle. Positions are compared bit for
// bit.
TEST(GeneratedMeshes, AreClosedAndWoundOutwards) {
  for (const Case& c : closed_bodies()) {
    SCOPED_TRACE(c.name);
    std::map<std::pair<Point, Point>, int> balance;
    for (const Mesh& mesh : c.meshes)
      for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
          const Point a = key(mesh.positions[t[k]]), b = key(mesh.positions[t[(k + 1) % 3]]);
          ASSERT_NE(a, b) << "degenerate triangle";
          ++balance[{a, b}];
          --balance[{b, a}];
        }
    for (const auto& [edge, sum] : balance) ASSERT_EQ(sum, 0);
    EXPECT_GT(signed_volume(c.meshes), 0);
  }
}

TEST(GeneratedMeshes, HaveUnitNormalsOnTheOuterSide) {
  for (const Case& c : closed_bodies()) {
    SCOPED_TRACE(c.name);
    for (const Mesh& mesh : c.meshes) {
      ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
      ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
      for (const auto& t : mesh.triangles) {
        const Eigen::Vector3f &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &d = mesh.positions[t[2]];
        const Eigen::Vector3f face = (b - a).cross(d - a).normalized();
        for (const auto i : t) {
          ASSERT_NEAR(mesh.normals[i].norm(), 1, 1e-5);
          ASSERT_GT(mesh.normals[i].dot(face), 0.3) << mesh.positions[i].transpose();
        }
      }
    }
  }
}

TEST(GeneratedMeshes, HaveTheVolumesOfTheirFormulas) {
  const Material material{.size_px = 32};
  const double a = 0.6, b = 0.4, c = 0.3, r = 0.05;
  const Vector3d size(a, b, c);
  EXPECT_NEAR(signed_volume(rounded_box(size, {.radius_m = 0}, material)), a * b * c, 1e-8);
  const double p = a - 2 * r, q = b - 2 * r, s = c - 2 * r;
  const double rounded =
      p * q * s + 2 * r * (p * q + q * s + s * p) + kPi * r * r * (p + q + s) + 4 * kPi / 3 * r * r * r;
  const double facets = 1e-3;  // relative: chords of 3.75 degrees lie inside the rounding
  const double found = signed_volume(rounded_box(size, {.radius_m = r, .segments = 12}, material));
  EXPECT_LT(found, rounded);
  EXPECT_NEAR(found, rounded, facets * rounded);
  const double recesses = 2 * 0.01 * 0.5 * 0.5 * (p * q + q * s + s * p);
  EXPECT_NEAR(found - signed_volume(rounded_box(size, {r, 0.01, 0.5, 12}, material)), recesses, 1e-7);
  EXPECT_NEAR(signed_volume(ellipsoid(size, 40, material)), kPi / 6 * a * b * c, facets * a * b * c);
  EXPECT_NEAR(signed_volume(cylinder(size, 96, material)), kPi / 4 * a * b * c, facets * a * b * c);
  EXPECT_NEAR(signed_volume(room({6, 5, 3}, 0, material)), -90, 1e-5);  // its surfaces face inwards
}

TEST(GeneratedMeshes, EllipsoidLiesOnItsSurfaceWithTheGradientAsNormal) {
  const Vector3d half(0.3, 0.2, 0.15);
  int vertices = 0;
  for (const Mesh& mesh : ellipsoid(2 * half, 10, Material{.size_px = 32}))
    for (std::size_t i = 0; i < mesh.positions.size(); ++i, ++vertices) {
      const Vector3d p = mesh.positions[i].cast<double>();
      ASSERT_NEAR(p.cwiseQuotient(half).norm(), 1, 4 * kSingle);
      const Vector3d gradient = p.cwiseQuotient(half.cwiseAbs2()).normalized();
      ASSERT_LT((mesh.normals[i].cast<double>() - gradient).norm(), 1e-5);
    }
  EXPECT_EQ(vertices, 6 * 21 * 21);
}

// The least, over the cells of a raster, of each cell's strongest corner (smaller eigenvalue of the gradient
// matrix).
double weakest_cell(const cv::Mat& texture, const cv::Size& shown, const cv::Size& raster) {
  cv::Mat image, grey;
  cv::resize(texture, image, shown, 0, 0, cv::INTER_AREA);
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  const cv::Size cell(shown.width / raster.width, shown.height / raster.height);
  double weakest = 1e9;
  for (int i = 0; i < raster.height; ++i)
    for (int j = 0; j < raster.width; ++j) {
      cv::Mat eigenvalues;
      cv::cornerMinEigenVal(grey(cv::Rect({j * cell.width, i * cell.height}, cell)), eigenvalues, 5);
      double strongest;
      cv::minMaxLoc(eigenvalues, nullptr, &strongest);
      weakest = std::min(weakest, strongest);
    }
  return weakest;
}

// Surfaces are shown at the scale they have in an image: a 6 m wall 4 m from a camera of f = 525 px, a 0.4 m
// face at 2.5 m.
TEST(Textures, CarryCornersOnEverySurface) {
  // OpenCV's scale. Weakest cells measure 1.3e-2 and more, those of blurred walls 6e-5 and less.
  constexpr double kCorner = 4e-3;
  const cv::Size wall_px(788, 394), wall_cells(8, 4), face_px(84, 84), face_cells(2, 2);
  int textures = 0;
  for (int style = 0; style < static_cast<int>(kTextureStyleNames.size()); ++style, ++textures) {
    SCOPED_TRACE(std::string(kTextureStyleNames[style]));
    const Material wall{.style = static_cast<TextureStyle>(style), .seed = 3, .size_px = 1024, .marks = 24};
    const cv::Mat painted = paint_texture(wall, 0, 6, 3);
    EXPECT_GT(weakest_cell(painted, wall_px, wall_cells), kCorner);
    Material face = wall;
    face.size_px = 512;
    face.marks = 10;
    EXPECT_GT(weakest_cell(paint_texture(face, 1, 0.4, 0.4), face_px, face_cells), kCorner);
    cv::Mat smooth;
    cv::GaussianBlur(painted, smooth, {}, 10);
    EXPECT_LT(weakest_cell(smooth, wall_px, wall_cells), kCorner / 10)
        << "the measure takes shading for corners";
  }
  EXPECT_EQ(textures, 6);
}

TEST(Textures, NoneIsAPlainTone) {
  const Material material{.amount = TextureAmount::none, .seed = 5, .size_px = 64};
  const cv::Mat painted = paint_texture(material, 0, 1, 1);
  EXPECT_EQ(cv::norm(painted, cv::Mat(painted.size(), painted.type(), cv::mean(painted)), cv::NORM_INF), 0);
}

TEST(Textures, DependOnSeedAndPartAlone) {
  const Material material{.seed = 5, .size_px = 64};
  Material other = material;
  other.seed = 6;
  const auto differ = [](const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) > 0; };
  const cv::Mat first = paint_texture(material, 0, 1, 1);
  EXPECT_FALSE(differ(first, paint_texture(material, 0, 1, 1)));
  EXPECT_TRUE(differ(first, paint_texture(material, 1, 1, 1)));
  EXPECT_TRUE(differ(first, paint_texture(other, 0, 1, 1)));
  EXPECT_EQ(paint_texture(material, 0, 2, 1).size(), cv::Size(64, 32));
}

TEST(Room, FurnitureStaysInsideAndApart) {
  const Vector3d size(6, 5, 3);
  for (const int count : {1, 6, 12}) {
    const auto meshes = room(size, count, Material{.size_px = 32});
    ASSERT_EQ(meshes.size(), 6u + 6u * static_cast<std::size_t>(count));  // six surfaces, six faces a piece
    std::vector<Eigen::AlignedBox3d> pieces;
    for (int k = 0; k < count; ++k)
      pieces.push_back(tight_box({meshes.begin() + 6 + 6 * k, meshes.begin() + 12 + 6 * k}));
    for (std::size_t a = 0; a < pieces.size(); ++a) {
      EXPECT_NEAR(pieces[a].min().z(), -1.5, 1e-6);
      EXPECT_TRUE((pieces[a].max().array() <= size.array() / 2).all());
      EXPECT_TRUE((pieces[a].min().head<2>().array() >= -size.head<2>().array() / 2).all());
      for (std::size_t b = 0; b < a; ++b) EXPECT_FALSE(pieces[a].intersects(pieces[b]));
    }
  }
}

double area_facing(const std::vector<Mesh>& meshes, const Vector3d& direction) {
  constexpr double kWithin = 0.99;  // cosine
  double area = 0;
  for (const Mesh& mesh : meshes)
    for (const auto& t : mesh.triangles) {
      const Vector3d a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                     c = mesh.positions[t[2]].cast<double>();
      const Vector3d twice = (b - a).cross(c - a);
      if (twice.dot(direction) > kWithin * twice.norm()) area += twice.norm() / 2;
    }
  return area;
}

void expect_normals_outside(const std::vector<Mesh>& meshes) {
  for (const Mesh& mesh : meshes)
    for (const auto& t : mesh.triangles) {
      const Eigen::Vector3f &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
      for (const auto i : t) {
        ASSERT_NEAR(mesh.normals[i].norm(), 1, 1e-5);
        ASSERT_GT(mesh.normals[i].dot((b - a).cross(c - a).normalized()), 0.3);
      }
    }
}

TEST(Street, KeepsItsMiddleFreeAndShowsSurfacesInEveryDirection) {
  const Vector3d size(90, 40, 12);
  const auto meshes = street(size, true, Material{.seed = 3, .size_px = 32});
  const Eigen::AlignedBox3d box = tight_box(meshes);
  EXPECT_LT((box.sizes() - size).norm(), 1e-4);  // single precision at 45 m
  EXPECT_LT(box.center().norm(), 1e-4);
  expect_normals_outside(meshes);
  for (const Mesh& mesh : meshes)
    for (const auto& p : mesh.positions)
      if (p.z() > -size.z() / 2 + 0.3) {
        ASSERT_TRUE(std::abs(p.y()) > size.y() / 2 - 10 || std::abs(p.x()) > size.x() / 2 - 5)
            << p.transpose();
      }
  const Vector3d up = Vector3d::UnitZ(), x = Vector3d::UnitX(), y = Vector3d::UnitY();
  EXPECT_GT(area_facing(meshes, up), size.x() * size.y());  // ground and roofs
  for (const Vector3d& direction : {x, y, Vector3d(-x), Vector3d(-y)})
    EXPECT_GT(area_facing(meshes, direction), 150) << direction.transpose();
}

TEST(Track, FollowsItsCircleAtItsGauge) {
  const TrackOptions options{.radius_m = 40, .from_rad = -2, .to_rad = -1.4, .gauge_m = 1.2};
  const auto meshes = track(options, Material{.size_px = 32});
  ASSERT_EQ(meshes.size(), 2u);
  expect_normals_outside(meshes);
  // Facets of one sleeper's distance are chords: 1.4 mm inside the circle.
  constexpr double kChord_m = 2e-3;
  std::set<int> rails;
  for (const auto& p : meshes[0].positions) {
    const double from_middle = p.head<2>().cast<double>().norm() - 40;
    ASSERT_NEAR(std::abs(from_middle), 0.6, 0.04 + kChord_m);
    rails.insert(from_middle > 0);
    const double angle = std::atan2(p.y(), p.x());
    ASSERT_GE(angle, -2 - 1e-6);
    ASSERT_LE(angle, -1.4 + 1e-6);
  }
  EXPECT_EQ(rails.size(), 2u);
  const double length = 40 * 0.6;
  EXPECT_NEAR(area_facing({meshes[0]}, Vector3d::UnitZ()), 2 * 0.08 * length, 0.01 * length);
}

}  // namespace
}  // namespace uniquadric
