#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/sequence/sequence.h"
#include "simulator/scene/mesh_building.h"
#include "simulator/scene/mesh_import.h"
#include "tests/simulator/scene_support.h"

namespace uniquadric {
namespace {

using scene_test::ScratchFolder;

// A 2 x 1 sheet; its left edge shows the texture's left, its bottom the texture's bottom (v counts upwards in
// files).
const std::string kSheet =
    "mtllib sheet.mtl\nusemtl paint\nv 0 0 5\nv 2 0 5\nv 2 1 5\nv 0 1 5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "f 1/1 2/2 3/3 4/4\n";
const std::string kPaint = "newmtl paint\nKd 0.1 0.1 0.1\nmap_Kd sheet.png\n";

cv::Mat two_rows() {  // red above blue
  cv::Mat image(2, 2, CV_8UC3, cv::Scalar(255, 0, 0));
  image.row(0) = cv::Scalar(0, 0, 255);
  return image;
}

std::string refusal(const std::filesystem::path& path) {
  try {
    import_mesh(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MeshImport, ReadsObjWithMaterialAndTexture) {
  const ScratchFolder folder("import_obj");
  folder.write("sheet.mtl", kPaint);
  write_png(folder.path() / "sheet.png", two_rows());
  const ImportedMesh imported = import_mesh(folder.write("sheet.obj", kSheet));
  ASSERT_EQ(imported.meshes.size(), 1u);
  const Mesh& mesh = imported.meshes[0];
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.color, Eigen::Vector3f(1, 1, 1));  // the texture holds the look
  ASSERT_EQ(mesh.texture.size(), cv::Size(2, 2));
  int lower = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_EQ(mesh.normals[i], Eigen::Vector3f(0, 0, 1));
    EXPECT_EQ(mesh.uvs[i].y(), mesh.positions[i].y() == 0 ? 1 : 0);  // the image's first row is on top
    lower += mesh.positions[i].y() == 0;
  }
  EXPECT_EQ(lower, 2);
  const Eigen::AlignedBox3d box = tight_box(imported.meshes);
  EXPECT_EQ(box.min(), Eigen::Vector3d(0, 0, 5));
  EXPECT_EQ(box.max(), Eigen::Vector3d(2, 1, 5));
  EXPECT_EQ(imported.files.size(), 3u);  // mesh, material, texture
}

// Whether a mesh is one, or names one: none of them is opened, where a pipe would wait and /dev/zero never
// end.
TEST(MeshImport, RefusesPipesDevicesAndFilesTooLong) {
  const ScratchFolder folder("import_pipe");
  const std::filesystem::path pipe = folder.path() / "pipe", large = folder.path() / "large.mtl";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(refusal(pipe), pipe.string() + ": is not a regular file");
  const auto with_material = [&](const std::string& name) {
    std::string text = kSheet;
    return refusal(folder.write("sheet.obj", text.replace(text.find("sheet.mtl"), 9, name)));
  };
  // assimp seeks every name below the mesh's folder
  for (const std::string name : {"../../../../../../../dev/zero", "pipe"}) {
    const std::string said = with_material(name);
    EXPECT_TRUE(said.ends_with("/" + name + ": is not a regular file")) << said;
  }
  folder.write("large.mtl", "");
  std::filesystem::resize_file(large, (std::uintmax_t{1} << 30) + 1);  // holes
  const std::string said = with_material("large.mtl");
  EXPECT_TRUE(said.ends_with("is longer than 1024 MiB, the most of a mesh file")) << said;
  for (const std::string name : {"/dev/zero", "pipe"}) {
    std::string paint = kPaint;
    folder.write("sheet.mtl", paint.replace(paint.find("sheet.png"), 9, name));
    const std::string refused = refusal(folder.write("sheet.obj", kSheet));
    EXPECT_TRUE(refused.ends_with(name + ": is not a regular file")) << refused;
  }
}

TEST(MeshImport, ReadsPly) {
  const ScratchFolder folder("import_ply");
  const auto path =
      folder.write("sheet.ply",
                   "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                   "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                   "0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 0 1 2 3\n");
  const ImportedMesh imported = import_mesh(path);
  ASSERT_EQ(imported.meshes.size(), 1u);
  EXPECT_EQ(imported.meshes[0].triangles.size(), 2u);
  EXPECT_EQ(imported.meshes[0].normals[0], Eigen::Vector3f(0, 0, 1));
  EXPECT_EQ(imported.meshes[0].color, Eigen::Vector3f(1, 1, 1));
  EXPECT_EQ(imported.files, std::vector{path});
}

// A pyramid without its floor, a point that no face has, texture coordinates that differ at the sides'
// corners.
TEST(MeshImport, ReadsPlyWithTextureAndCornersOfTheirOwn) {
  const ScratchFolder folder("import_ply_look");
  write_png(folder.path() / "sheet.png", two_rows());
  const auto file = [&](const std::string& normals, const std::string& coordinates,
                        const std::string& normal) {
    std::string text =
        "ply\nformat ascii 1.0\ncomment TextureFile sheet.png\nelement vertex 6\nproperty float x\n"
        "property float y\nproperty float z\n" +
        normals +
        "element face 4\n"
        "property list uchar int vertex_indices\n" +
        coordinates + "end_header\n";
    for (const char* point : {"-1 -1 0", "9 9 9", "1 -1 0", "1 1 0", "-1 1 0", "0 0 1"})
      text += point + normal + "\n";
    for (const char* face : {"3 0 2 5", "3 2 3 5", "3 3 4 5", "3 4 0 5"})
      text += std::string(face) + (coordinates.empty() ? "" : " 6 0 0 1 0 0.5 0.75") + "\n";
    return folder.write("pyramid.ply", text);
  };
  const ImportedMesh imported = import_mesh(file("", "property list uchar float texcoord\n", ""));
  ASSERT_EQ(imported.meshes.size(), 1u);
  const Mesh& mesh = imported.meshes[0];
  EXPECT_EQ(mesh.texture.size(), cv::Size(2, 2));
  EXPECT_EQ(imported.files.size(), 2u);
  EXPECT_EQ(mesh.positions.size(), 9u);  // twice the floor's corners, the tip
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(tight_box(imported.meshes).max(), Eigen::Vector3d(1, 1, 1));
  for (const auto& triangle : mesh.triangles) {
    EXPECT_EQ(mesh.uvs[triangle[0]], Eigen::Vector2f(0, 1));
    EXPECT_EQ(mesh.uvs[triangle[1]], Eigen::Vector2f(1, 1));
    EXPECT_EQ(mesh.uvs[triangle[2]], Eigen::Vector2f(0.5F, 0.25F));
    EXPECT_EQ(mesh.positions[triangle[2]], Eigen::Vector3f(0, 0, 1));
    EXPECT_LT((mesh.normals[triangle[2]] - Eigen::Vector3f(0, 0, 1)).norm(), 1e-6F);  // the four sides' mean
    // Of two sides (1, 0, 1) and (0, 1, 1), as far outwards as upwards.
    const Eigen::Vector3f corner = mesh.positions[triangle[0]], normal = mesh.normals[triangle[0]];
    EXPECT_LT((normal - Eigen::Vector3f(corner.x(), corner.y(), 2).normalized()).norm(), 1e-6F);
  }
  const ImportedMesh given =
      import_mesh(file("property float nx\nproperty float ny\nproperty float nz\n", "", " 0 -3 0"));
  EXPECT_EQ(given.meshes[0].positions.size(), 5u);
  for (const Eigen::Vector3f& normal : given.meshes[0].normals) EXPECT_EQ(normal, Eigen::Vector3f(0, -1, 0));
  std::filesystem::remove(folder.path() / "sheet.png");
  EXPECT_NE(refusal(folder.path() / "pyramid.ply").find("sheet.png: cannot be read"), std::string::npos);
}

// What a header announces is not there: 4e9 vertices or faces in a file of a few hundred bytes.
TEST(MeshImport, RefusesPlyFilesThatAnnounceMoreThanTheyHold) {
  const ScratchFolder folder("import_ply_claims");
  const auto ply = [](const std::string& format, const std::string& vertices, const std::string& faces,
                      const std::string& body) {
    return "ply\nformat " + format + " 1.0\ncomment made up\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list uchar int vertex_indices\nend_header\n" + body;
  };
  const std::string body = "0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 0 1 2 3";
  const std::string big = "4000000000", larger = "99999999999999999999";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {ply("ascii", big, "1", ""), ":4: announces 4000000000 vertex, for which the file is too short"},
      {ply("ascii", "4", big, body), ":8: announces 4000000000 face, for which the file is too short"},
      {ply("ascii", "4", "6", body),
       ":8: announces 6 face"},  // 4 lines of 6 bytes, 6 of 2 in 34 and a line end
      {ply("binary_little_endian", big, "0", std::string(48, '\0')), ":4: announces 4000000000 vertex"},
      {ply("binary_big_endian", "4", "45", std::string(48, '\0')), ":8: announces 45 face"},
      {ply("ascii", larger, "1", body), ":4: expected element NAME COUNT"},
      {ply("ascii", "-4", "1", body), ":4: expected element NAME COUNT"},
      {"ply\rformat ascii 1.0\relement vertex 4000000000\rproperty int x\rend_header\r",
       ":3: announces 4000000000 v"},
      {"ply\nformat ascii 1.0\nelement vertex 4000000000\n", ":4: the header does not end"},
  };
  int refused = 0;
  for (const auto& [text, what] : cases)
    for (const std::string name : {"sheet.ply", "sheet.mesh"}) {  // told by its content, whatever the name
      const std::string message = refusal(folder.write(name, text));
      EXPECT_NE(message.find(name + what), message.npos) << what << ": " << message;
      ++refused;
    }
  EXPECT_EQ(refused, 18);
  EXPECT_NE(refusal(folder.write("sheet.PLY", "\nply\n")).find("sheet.PLY:1: expected ply"),
            std::string::npos);
  EXPECT_NE(refusal(folder.write("sheet.mesh", "\n" + ply("ascii", "4", "1", body)))
                .find("cannot be read as a mesh"),
            std::string::npos);
  EXPECT_EQ(import_mesh(folder.write("sheet.ply", ply("ascii", "4", "1", body))).meshes.size(), 1u);
}

void append_word(std::string& bytes, std::uint32_t word) {
  char raw[4];
  std::memcpy(raw, &word, 4);  // little endian, as the format and every machine this builds on
  bytes.append(raw, 4);
}

std::string glb(const std::string& json, std::string binary) {
  std::string text = json;
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string bytes = "glTF";
  append_word(bytes, 2);
  append_word(bytes, static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + binary.size()));
  append_word(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += "JSON" + text;
  append_word(bytes, static_cast<std::uint32_t>(binary.size()));
  return bytes + std::string("BIN\0", 4) + binary;
}

TEST(MeshImport, ReadsGlbWithEmbeddedTextureAndNodeTransform) {
  std::vector<unsigned char> png;
  ASSERT_TRUE(cv::imencode(".png", two_rows(), png));
  const float data[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, /*uv*/ 0, 0, 1, 0, 0, 1};
  std::string binary(reinterpret_cast<const char*>(data), sizeof data);
  binary.append(png.begin(), png.end());
  const std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[10,0,0]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
      R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],)"
      R"("materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],)"
      R"("images":[{"bufferView":2,"mimeType":"image/png"}],"bufferViews":[{"buffer":0,"byteLength":36},)"
      R"({"buffer":0,"byteOffset":36,"byteLength":24},{"buffer":0,"byteOffset":60,"byteLength":)" +
      std::to_string(png.size()) + R"(}],"buffers":[{"byteLength":)" + std::to_string(binary.size()) + "}]}";
  const ScratchFolder folder("import_glb");
  const ImportedMesh imported = import_mesh(folder.write("sheet.glb", glb(json, binary)));
  ASSERT_EQ(imported.meshes.size(), 1u);
  EXPECT_EQ(imported.meshes[0].texture.size(), cv::Size(2, 2));
  EXPECT_EQ(tight_box(imported.meshes).min(), Eigen::Vector3d(10, 0, 0));
  for (std::size_t i = 0; i < 3; ++i)  // in this format v counts downwards already
    EXPECT_EQ(imported.meshes[0].uvs[i].y(), imported.meshes[0].positions[i].y());
  EXPECT_EQ(imported.files.size(), 1u);
}

TEST(MeshImport, RefusesWhatCannotBeRendered) {
  const ScratchFolder folder("import_faults");
  EXPECT_NE(refusal(folder.path() / "absent.obj").find("absent.obj: no such mesh file"), std::string::npos);
  EXPECT_NE(refusal(folder.write("text.obj", "hello\n")).find("text.obj: "), std::string::npos);
  EXPECT_NE(refusal(folder.write("points.obj", "v 0 0 0\nv 1 0 0\n")).find("points.obj: "),
            std::string::npos);
  EXPECT_NE(refusal(folder.write("sheet.xyz", "0 0 0\n")).find("sheet.xyz: cannot be read as a mesh"),
            std::string::npos);
  const std::string bad = "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n";
  EXPECT_NE(refusal(folder.write("nan.obj", bad)).find("is not finite"), std::string::npos);

  folder.write("sheet.mtl", kPaint);
  const auto sheet = folder.write("sheet.obj", kSheet);
  EXPECT_NE(refusal(sheet).find("sheet.png: cannot be read"), std::string::npos);
  write_png(folder.path() / "sheet.png", two_rows());
  const std::string whole = read_text(folder.path() / "sheet.png");
  folder.write("sheet.png", whole.substr(0, whole.size() - 20));
  EXPECT_NE(refusal(sheet).find("sheet.png: is a truncated image"), std::string::npos);
  folder.write("sheet.png", "no image");
  EXPECT_NE(refusal(sheet).find("sheet.png: is not an image"), std::string::npos);
}

std::string big_endian(std::uint32_t value, int bytes) {
  std::string text;
  for (int k = bytes - 1; k >= 0; --k) text += static_cast<char>(value >> 8 * k & 0xff);
  return text;
}

// A header is enough: what it announces must not be decoded.
std::string png_of(std::uint32_t width, std::uint32_t height) {
  return "\x89PNG\r\n\x1a\n" + big_endian(13, 4) + "IHDR" + big_endian(width, 4) + big_endian(height, 4) +
         std::string("\x08\x02\0\0\0", 5) + "crc!" + big_endian(0, 4) + "IEND" + "crc!";
}

std::string jpeg_of(std::uint32_t width, std::uint32_t height) {
  return std::string("\xff\xd8\xff\xe0") + big_endian(4, 2) + "JF" + "\xff\xc4" + big_endian(3, 2) + "h" +
         "\xff\xc2" + big_endian(11, 2) + "\x08" + big_endian(height, 2) + big_endian(width, 2) +
         "\x01"
         "abc" +
         "\xff\xd9";
}

TEST(MeshImport, RefusesTexturesOfAGigapixelByTheirHeader) {
  const ScratchFolder folder("import_gigapixel");
  folder.write("sheet.mtl", kPaint);
  const auto sheet = folder.write("sheet.obj", kSheet);
  folder.write("sheet.png", png_of(40'000, 30'000));
  EXPECT_NE(refusal(sheet).find("sheet.png: has 40000x30000 px, at most 8192"), std::string::npos);
  folder.write("sheet.png", jpeg_of(32'000, 65'000));  // told by its content, whatever the name
  EXPECT_NE(refusal(sheet).find("sheet.png: has 32000x65000 px, at most 8192"), std::string::npos);
  folder.write("sheet.png", jpeg_of(8192, 8192));  // the size would do, the rest is no image
  EXPECT_NE(refusal(sheet).find("sheet.png: is not an image"), std::string::npos);
  write_png(folder.path() / "sheet.png", cv::Mat(1, 8200, CV_8UC3, cv::Scalar(0, 0, 0)));
  EXPECT_NE(refusal(sheet).find("sheet.png: has 8200x1 px"), std::string::npos);
}

const std::string kBar =
    "v 0 0 0\nv 4 0 0\nv 4 2 0\nv 0 2 0\nv 0 0 1\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";

TEST(MeshImport, ObjectIsCentredScaledAndTurned) {
  const ScratchFolder folder("import_object");
  folder.write("bar.obj", kBar);
  const auto path = folder.write("scene.yaml",
                                 "camera: {motion: {kind: static, look_at_m: [1, 0, 0]}}\nobjects:\n"
                                 "  - {id: 1, name: bar, mesh: ./bar.obj, scale: 0.1, mesh_rpy_deg: [0, 0, "
                                 "90], motion: {kind: static}}\n");
  const Scene scene = load_scene(path);
  const Body& bar = scene.objects.at(0);
  EXPECT_EQ(bar.shape, "mesh");
  EXPECT_EQ(bar.mesh_file, "./bar.obj");  // as the scene gives it
  constexpr double kSingle_m = 1e-7;      // single precision of 0.2 m, a few operations
  EXPECT_LT((bar.semi_axes_m - Eigen::Vector3d(0.1, 0.2, 0.05)).norm(), kSingle_m);
  const Eigen::AlignedBox3d box = tight_box(bar.meshes);
  EXPECT_LT((box.min() + bar.semi_axes_m).norm(), kSingle_m);
  EXPECT_LT((box.max() - bar.semi_axes_m).norm(), kSingle_m);
}

TEST(MeshImport, RefusesExtentsThatNoSceneHolds) {
  const ScratchFolder folder("import_huge");
  const auto message = [&](const std::string& body) {
    const auto path = folder.write("scene.yaml",
                                   "camera: {motion: {kind: static, look_at_m: [1, 0, 0]}}\nobjects:\n"
                                   "  - {id: 1, name: bar, mesh: ./bar.obj, motion: {kind: static}" +
                                       body + "}\n");
    try {
      load_scene(path);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  folder.write("bar.obj", kBar);
  EXPECT_EQ(message(", scale: 2500"), "");
  EXPECT_NE(message(", scale: 2501")
                .find("scene.yaml:3: objects[0].scale: extents must be at most 10000 m, found 10004"),
            std::string::npos);
  EXPECT_NE(message(", scale: 1e300").find("objects[0].scale: extents"), std::string::npos);
  folder.write("bar.obj", "v 0 0 0\nv 4e8 0 0\nv 0 2 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n");
  EXPECT_NE(message("").find("objects[0].mesh: extents"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
