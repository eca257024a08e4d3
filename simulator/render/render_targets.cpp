#include "simulator/render/render_targets.h"

#include <GL/glcorearb.h>
#include <fmt/format.h>

#include <array>
#include <stdexcept>

#include "core/base/error.h"

namespace uniquadric {
namespace {

// `samples` 0: a buffer without multisampling. The new buffer's name.
unsigned attach(const GlFunctions& gl, const RenderTargets& targets, unsigned framebuffer, unsigned place,
                unsigned format, int samples = 0) {
  unsigned buffer = 0;
  gl.CreateRenderbuffers(1, &buffer);
  gl.NamedRenderbufferStorageMultisample(buffer, samples, format, targets.width, targets.height);
  gl.NamedFramebufferRenderbuffer(framebuffer, place, GL_RENDERBUFFER, buffer);
  return buffer;
}

void check_complete(const GlFunctions& gl, const RenderTargets& targets, unsigned framebuffer) {
  if (gl.CheckNamedFramebufferStatus(framebuffer, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw InputError(fmt::format("OpenGL cannot draw images of {}x{} px", targets.width, targets.height));
}

void read(const GlFunctions& gl, unsigned framebuffer, const cv::Rect& part, unsigned format, unsigned type,
          int mat_type, cv::Mat& image) {
  image.create(part.size(), mat_type);
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  gl.ReadPixels(part.x, part.y, part.width, part.height, format, type, image.data);
}

void read_image(const GlFunctions& gl, const RenderTargets& targets, unsigned draw_buffer, unsigned format,
                unsigned type, int mat_type, cv::Mat& image) {
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, targets.image);
  gl.ReadBuffer(GL_COLOR_ATTACHMENT0 + draw_buffer);
  read(gl, targets.image, {0, 0, targets.width, targets.height}, format, type, mat_type, image);
}

}  // namespace

RenderTargets make_render_targets(const GlFunctions& gl, int width, int height, int samples) {
  RenderTargets targets{width, height};
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.CreateFramebuffers(1, &targets.image);
  const unsigned color = attach(gl, targets, targets.image, GL_COLOR_ATTACHMENT0, GL_RGBA8);
  attach(gl, targets, targets.image, GL_COLOR_ATTACHMENT1, GL_R16UI);
  const unsigned depth = attach(gl, targets, targets.image, GL_COLOR_ATTACHMENT2, GL_R32F);
  attach(gl, targets, targets.image, GL_DEPTH_STENCIL_ATTACHMENT, GL_DEPTH32F_STENCIL8);
  constexpr std::array<unsigned, 3> buffers = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1,
                                               GL_COLOR_ATTACHMENT2};
  gl.NamedFramebufferDrawBuffers(targets.image, buffers.size(), buffers.data());
  gl.CreateFramebuffers(1, &targets.silhouettes);
  attach(gl, targets, targets.silhouettes, GL_STENCIL_ATTACHMENT, GL_STENCIL_INDEX8);
  gl.CreateFramebuffers(1, &targets.samples);
  attach(gl, targets, targets.samples, GL_COLOR_ATTACHMENT0, GL_RGBA8, samples);
  const unsigned reversed_z =
      attach(gl, targets, targets.samples, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, samples);
  gl.CreateFramebuffers(1, &targets.depth);
  gl.NamedFramebufferRenderbuffer(targets.depth, GL_COLOR_ATTACHMENT2, GL_RENDERBUFFER, depth);
  const unsigned depth_buffer =
      samples > 0 ? attach(gl, targets, targets.depth, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F)
                  : reversed_z;
  gl.NamedFramebufferRenderbuffer(targets.depth, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_buffer);
  constexpr std::array<unsigned, 3> third = {GL_NONE, GL_NONE, GL_COLOR_ATTACHMENT2};
  gl.NamedFramebufferDrawBuffers(targets.depth, third.size(), third.data());
  gl.CreateFramebuffers(1, &targets.returned);
  gl.NamedFramebufferRenderbuffer(targets.returned, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color);
  gl.NamedFramebufferRenderbuffer(targets.returned, GL_COLOR_ATTACHMENT2, GL_RENDERBUFFER, depth);
  gl.NamedFramebufferRenderbuffer(targets.returned, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_buffer);
  constexpr std::array<unsigned, 3> but_ids = {GL_COLOR_ATTACHMENT0, GL_NONE, GL_COLOR_ATTACHMENT2};
  gl.NamedFramebufferDrawBuffers(targets.returned, but_ids.size(), but_ids.data());
  gl.CreateFramebuffers(1, &targets.color);
  gl.NamedFramebufferRenderbuffer(targets.color, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color);
  for (const unsigned framebuffer :
       {targets.image, targets.depth, targets.returned, targets.silhouettes, targets.samples, targets.color})
    check_complete(gl, targets, framebuffer);
  return targets;
}

void resolve_samples(const GlFunctions& gl, const RenderTargets& targets) {
  const int width = targets.width, height = targets.height;
  gl.BlitNamedFramebuffer(targets.samples, targets.color, 0, 0, width, height, 0, 0, width, height,
                          GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void read_color(const GlFunctions& gl, const RenderTargets& targets, cv::Mat& rgba) {
  read_image(gl, targets, 0, GL_RGBA, GL_UNSIGNED_BYTE, CV_8UC4, rgba);
}

void read_ids(const GlFunctions& gl, const RenderTargets& targets, cv::Mat& ids) {
  read_image(gl, targets, 1, GL_RED_INTEGER, GL_UNSIGNED_SHORT, CV_16UC1, ids);
}

void read_depth(const GlFunctions& gl, const RenderTargets& targets, cv::Mat& depth_m) {
  read_image(gl, targets, 2, GL_RED, GL_FLOAT, CV_32FC1, depth_m);
}

void read_stencil(const GlFunctions& gl, unsigned framebuffer, const cv::Rect& part, cv::Mat& bits) {
  read(gl, framebuffer, part, GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, CV_8UC1, bits);
}

}  // namespace uniquadric
