#include "simulator/render/gpu_mesh.h"

#include <GL/glcorearb.h>

#include <algorithm>
#include <bit>
#include <cassert>

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

// Trilinear filtering: textures shrink without flicker, which would make false corners.
unsigned upload_texture(const GlFunctions& gl, const cv::Mat& given) {
  const cv::Mat white(1, 1, CV_8UC3, cv::Scalar::all(255));
  const cv::Mat image = given.empty() ? white : given.isContinuous() ? given : given.clone();
  assert(image.type() == CV_8UC3);
  unsigned texture = 0;
  gl.CreateTextures(GL_TEXTURE_2D, 1, &texture);
  const int levels = std::bit_width(static_cast<unsigned>(std::max(image.cols, image.rows)));
  gl.TextureStorage2D(texture, levels, GL_RGBA8, image.cols, image.rows);
  gl.TextureSubImage2D(texture, 0, 0, 0, image.cols, image.rows, GL_BGR, GL_UNSIGNED_BYTE, image.data);
  gl.GenerateTextureMipmap(texture);
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
  check_gl(gl, "copying a mesh");
  return gpu;
}

}  // namespace uniquadric
