#include "simulator/render/gpu_mesh.h"

#include <GL/glcorearb.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <opencv2/imgproc.hpp>

#include "simulator/render/short_edges.h"

namespace uniquadric {
namespace {

template <typename T>
unsigned upload_buffer(const GlFunctions& gl, const std::vector<T>& values) {
  unsigned buffer = 0;
  gl.CreateBuffers(1, &buffer);
  gl.NamedBufferStorage(buffer, static_cast<std::ptrdiff_t>(values.size() * sizeof(T)), values.data(), 0);
  return buffer;
}

// The vertex attribute `place` reads tightly packed vectors of floats.
template <typename Vector>
void attach_attribute(const GlFunctions& gl, unsigned vertex_array, unsigned place,
                      const std::vector<Vector>& values) {
  gl.VertexArrayVertexBuffer(vertex_array, place, upload_buffer(gl, values), 0, sizeof(Vector));
  gl.VertexArrayAttribFormat(vertex_array, place, Vector::RowsAtCompileTime, GL_FLOAT, GL_FALSE, 0);
  gl.VertexArrayAttribBinding(vertex_array, place, place);
  gl.EnableVertexArrayAttrib(vertex_array, place);
}

// Trilinear filtering: textures shrink without flicker, which would make false corners. The levels are made
// here: llvmpipe would compile shaders for it and take five times as long.
unsigned upload_texture(const GlFunctions& gl, const cv::Mat& image) {
  assert(image.empty() || image.type() == CV_8UC3);
  cv::Mat level(1, 1, CV_8UC4, cv::Scalar::all(255));
  if (!image.empty()) cv::cvtColor(image, level, cv::COLOR_BGR2RGBA);
  const int levels = std::bit_width(static_cast<unsigned>(std::max(level.cols, level.rows)));
  unsigned texture = 0;
  gl.CreateTextures(GL_TEXTURE_2D, 1, &texture);
  gl.TextureStorage2D(texture, levels, GL_RGBA8, level.cols, level.rows);
  for (int i = 0; i < levels; ++i) {
    gl.TextureSubImage2D(texture, i, 0, 0, level.cols, level.rows, GL_RGBA, GL_UNSIGNED_BYTE, level.data);
    cv::Mat smaller;
    cv::resize(level, smaller, {std::max(1, level.cols / 2), std::max(1, level.rows / 2)}, 0, 0,
               cv::INTER_AREA);
    level = smaller;
  }
  gl.TextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl.TextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_REPEAT);
  gl.TextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_REPEAT);
  return texture;
}

}  // namespace

GpuMesh upload_mesh(const GlFunctions& gl, const Mesh& mesh) {
  assert(mesh.normals.size() == mesh.positions.size() && mesh.uvs.size() == mesh.positions.size());
  GpuMesh gpu;
  gl.CreateVertexArrays(1, &gpu.vertex_array);
  attach_attribute(gl, gpu.vertex_array, 0, mesh.positions);
  attach_attribute(gl, gpu.vertex_array, 1, mesh.normals);
  attach_attribute(gl, gpu.vertex_array, 2, mesh.uvs);
  gl.VertexArrayElementBuffer(gpu.vertex_array, upload_buffer(gl, mesh.triangles));
  gpu.texture = upload_texture(gl, mesh.texture);
  gpu.index_count = static_cast<int>(3 * mesh.triangles.size());
  gpu.color = mesh.color;
  gpu.shine = mesh.shine;
  gpu.depth_return = mesh.depth_return;
  for (const Eigen::Vector3f& p : mesh.positions) gpu.box.extend(p);
  check_gl(gl, "copying a mesh");
  return gpu;
}

GpuBody upload_body(const GlFunctions& gl, const Body& body, const std::vector<Eigen::Vector3f>& cameras_m) {
  GpuBody gpu{static_cast<unsigned>(body.id), {}, {}};
  for (const Mesh& mesh : body.meshes) {
    gpu.meshes.push_back(upload_mesh(gl, cameras_m.empty() ? mesh : with_short_edges(mesh, cameras_m)));
    gpu.box.extend(gpu.meshes.back().box);
  }
  return gpu;
}

}  // namespace uniquadric
