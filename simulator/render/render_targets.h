#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "simulator/render/gl_functions.h"

namespace uniquadric {

/// The framebuffers of one image size; they live as long as their OpenGL context. Row 0 is the image's top.
struct RenderTargets {
  int width = 0, height = 0;  ///< [px]
  /// Draw buffers 0 colour (8 bits), 1 id (16 bits), 2 depth [m]; beside them reversed-Z depth and 8 bits of
  /// stencil.
  unsigned image = 0;
  unsigned depth = 0;     ///< draw buffer 2 alone, the image's; where `samples` has one sample a pixel, their
                          ///< depth buffer is one
  unsigned returned = 0;  ///< draw buffers 0 and 2, the image's, with the depth buffer of `depth`
  unsigned silhouettes = 0;  ///< 8 bits of stencil alone
  /// Draw buffer 0 colour, several samples a pixel, with reversed-Z depth.
  unsigned samples = 0;
  unsigned color = 0;  ///< the image's colour alone, which resolve_samples() writes
};

/// Throws std::runtime_error when the library refuses the size.
RenderTargets make_render_targets(const GlFunctions& gl, int width, int height, int samples);

/// The image's colour becomes the mean of each pixel's samples.
void resolve_samples(const GlFunctions& gl, const RenderTargets& targets);

/// Copies what was drawn; the images are kept when they have the right size and type already.
void read_color(const GlFunctions& gl, const RenderTargets& targets, cv::Mat& rgba);     ///< 8UC4
void read_ids(const GlFunctions& gl, const RenderTargets& targets, cv::Mat& ids);        ///< 16UC1
void read_depth(const GlFunctions& gl, const RenderTargets& targets, cv::Mat& depth_m);  ///< 32FC1
void read_stencil(const GlFunctions& gl, unsigned framebuffer, const cv::Rect& part,
                  cv::Mat& bits);  ///< 8UC1, of the part alone

}  // namespace uniquadric
