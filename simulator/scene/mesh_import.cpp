#include "simulator/scene/mesh_import.h"

#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/BaseImporter.h>
#include <assimp/DefaultIOSystem.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/sequence/image_file.h"
#include "simulator/scene/mesh_building.h"
#include "simulator/scene/ply_mesh.h"

// Debian builds assimp with its assertions, which end the program where a damaged file breaks one. The
// library's calls find this function before its own; it makes of them errors of the file, as assimp's other
// ones.
namespace Assimp {
void aiAssertViolation(const char* expression, const char* file, int line);
void aiAssertViolation(const char* expression, const char* /*file*/, int /*line*/) {
  throw std::runtime_error(fmt::format("assimp expected {}", expression));
}
}  // namespace Assimp

namespace uniquadric {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxSide_px = 8192;  // of a texture; ours: 200 MB of colour; scans come with 4096

/// Remembers what assimp opens (an OBJ names its material file), so that a scene's hash covers it.
class RecordingFiles final : public Assimp::DefaultIOSystem {
 public:
  explicit RecordingFiles(std::vector<fs::path>& opened) : opened_(opened) {}
  bool Exists(const char* file) const override {  // assimp's own opens it, and waits for ever at a pipe
    std::error_code error;
    return fs::exists(file, error);
  }
  Assimp::IOStream* Open(const char* file, const char* mode = "rb") override {
    std::error_code error;
    if (fs::exists(file, error)) require_file(file, kMeshFile);  // what is not there, assimp may do without
    Assimp::IOStream* stream = DefaultIOSystem::Open(file, mode);
    if (stream && std::find(opened_.begin(), opened_.end(), fs::path(file)) == opened_.end())
      opened_.emplace_back(file);
    return stream;
  }

 private:
  std::vector<fs::path>& opened_;
};

cv::Mat to_bgr(const cv::Mat& image, const fs::path& path) {
  if (image.depth() != CV_8U) throw InputError(path, "texture has more than 8 bits a channel");
  cv::Mat bgr;
  if (image.channels() == 1)
    cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  else if (image.channels() == 4)
    cv::cvtColor(image, bgr, cv::COLOR_BGRA2BGR);
  else
    bgr = image;
  return bgr;
}

cv::Mat embedded_texture(const aiTexture& texture, const fs::path& path) {
  cv::Mat image;
  if (texture.mHeight == 0) {  // a compressed file of mWidth bytes
    image = decode_image({reinterpret_cast<const char*>(texture.pcData), texture.mWidth}, kMaxSide_px, path);
  } else {
    if (std::max(texture.mWidth, texture.mHeight) > static_cast<unsigned>(kMaxSide_px))
      throw InputError(path, "embedded texture is too large");
    image =
        cv::Mat(static_cast<int>(texture.mHeight), static_cast<int>(texture.mWidth), CV_8UC4, texture.pcData)
            .clone();
  }
  return to_bgr(image, path);
}

void read_texture(std::string name, const fs::path& path, Mesh& mesh, std::vector<fs::path>& files) {
  std::replace(name.begin(), name.end(), '\\', '/');
  name.erase(name.find_last_not_of(" \t\r") + 1);  // material files end lines with blanks
  const fs::path texture = path.parent_path() / name;
  mesh.texture = to_bgr(decode_image(read_file(texture, kImageFile), kMaxSide_px, texture), texture);
  if (std::find(files.begin(), files.end(), texture) == files.end()) files.push_back(texture);
}

void read_material(const aiScene& scene, const aiMaterial& material, const fs::path& path, Mesh& mesh,
                   std::vector<fs::path>& files) {
  aiColor3D diffuse(1, 1, 1);
  aiString name;
  const bool textured = material.GetTexture(aiTextureType_DIFFUSE, 0, &name) == AI_SUCCESS;
  // Files often leave a dark or black diffuse colour beside a texture that holds the whole look.
  if (!textured && material.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse) == AI_SUCCESS)
    mesh.color = {diffuse.r, diffuse.g, diffuse.b};
  if (!textured) return;
  if (const aiTexture* embedded = scene.GetEmbeddedTexture(name.C_Str())) {
    mesh.texture = embedded_texture(*embedded, path);
    return;
  }
  read_texture(name.C_Str(), path, mesh, files);
}

Mesh convert(const aiMesh& source, const fs::path& path) {
  Mesh mesh;
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    const aiVector3D &p = source.mVertices[i], &n = source.mNormals[i];
    const aiVector3D uv = source.HasTextureCoords(0) ? source.mTextureCoords[0][i] : aiVector3D();
    mesh.positions.emplace_back(p.x, p.y, p.z);
    mesh.normals.emplace_back(n.x, n.y, n.z);
    mesh.uvs.emplace_back(uv.x, uv.y);
    if (!mesh.positions.back().allFinite()) throw InputError(path, fmt::format("vertex {} is not finite", i));
    if (!mesh.uvs.back().allFinite())
      throw InputError(path, fmt::format("texture coordinate {} is not finite", i));
    mesh.normals.back() = unit_normal(mesh.normals.back());
  }
  for (unsigned i = 0; i < source.mNumFaces; ++i) {
    const aiFace& face = source.mFaces[i];
    // Faces of one vertex or two that come with triangles, as of a damaged file, pass assimp's sorting.
    if (face.mNumIndices != 3) throw InputError(path, fmt::format("face {} has less than 3 vertices", i));
    mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
  }
  return mesh;
}

ImportedMesh import_ply(const fs::path& path) {
  const SurfaceFile surface = read_surface_ply(path);
  if (surface.triangles.empty()) throw InputError(path, "has no faces");
  ImportedMesh result{{mesh_of(surface)}, {path}};
  Mesh& mesh = result.meshes[0];
  if (!surface.texture_file.empty())
    read_texture(surface.texture_file, path, mesh, result.files);
  else if (surface.color)
    mesh.color = *surface.color;
  return result;
}

bool is_ply(const fs::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return extension == ".ply" || read_file(path, kMeshFile).starts_with("ply");
}

}  // namespace

ImportedMesh import_mesh(const fs::path& path) {
  if (!fs::exists(path)) throw InputError(path, "no such mesh file");
  require_file(path, kMeshFile);
  if (is_ply(path)) return import_ply(path);
  ImportedMesh result;
  Assimp::Importer importer;
  // Of damaged files its reader of PLY, which looks for one in files of any name, makes faces from anywhere.
  const std::unique_ptr<Assimp::BaseImporter> ply(importer.GetImporter("ply"));
  importer.UnregisterLoader(ply.get());
  importer.SetIOHandler(new RecordingFiles(result.files));  // the importer owns it
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(
      path.string(), aiProcess_ValidateDataStructure | aiProcess_Triangulate |
                         aiProcess_PreTransformVertices | aiProcess_GenSmoothNormals |
                         aiProcess_JoinIdenticalVertices | aiProcess_SortByPType | aiProcess_FlipUVs);
  const std::string said = importer.GetErrorString();
  for (const char* points_alone : {"contains no faces", "orphaned"})  // how its steps say it
    if (!scene && said.find(points_alone) != said.npos) throw InputError(path, "has no faces");
  if (!scene) throw InputError(path, fmt::format("cannot be read as a mesh: {}", said));
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
    const aiMesh& source = *scene->mMeshes[i];
    if (source.mNumFaces == 0) continue;
    result.meshes.push_back(convert(source, path));
    read_material(*scene, *scene->mMaterials[source.mMaterialIndex], path, result.meshes.back(),
                  result.files);
  }
  if (result.meshes.empty()) throw InputError(path, "has no faces");
  return result;
}

}  // namespace uniquadric
