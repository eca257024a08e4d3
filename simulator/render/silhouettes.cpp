#include "simulator/render/silhouettes.h"

#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace uniquadric {
namespace {

constexpr std::size_t kBits = 8;  // of the stencil buffer

// Draws the objects from `first` on, as many as there are bits, into the buffer that has nothing but them.
void draw_pass(const GlFunctions& gl, const RenderTargets& targets, std::size_t first, std::size_t last,
               const std::function<void(std::size_t)>& draw) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, targets.silhouettes);
  gl.Disable(GL_DEPTH_TEST);
  constexpr int kNoBit = 0;
  gl.StencilMask(0xff);
  gl.ClearBufferiv(GL_STENCIL, 0, &kNoBit);
  begin_silhouettes(gl);
  for (std::size_t i = first; i < last; ++i) {
    gl.StencilMask(silhouette_bit(i - first));
    draw(i);
  }
  gl.Disable(GL_STENCIL_TEST);
}

// Whether the eight bytes from here on are all zero: most pixels are none of an object's.
bool are_zero(const void* bytes) {
  std::uint64_t eight = 0;
  std::memcpy(&eight, bytes, sizeof eight);
  return eight == 0;
}

// Pixels of each bit in a row of the image, and whether the row has any.
std::array<std::int64_t, kBits> count_bits(const unsigned char* pixels, int count, int step) {
  std::array<std::int64_t, 256> histogram{};
  for (int i = 0; i < count; ++i) {
    if (step == 1 && i + 8 <= count && are_zero(pixels + i))
      i += 7;
    else
      ++histogram[pixels[i * step]];
  }
  std::array<std::int64_t, kBits> counts{};
  for (std::size_t value = 1; value < histogram.size(); ++value)
    for (std::size_t bit = 0; bit < kBits; ++bit)
      if (value >> bit & 1) counts[bit] += histogram[value];
  return counts;
}

// `bits` are those of a part of an image of that size.
void count_pass(const cv::Mat& bits, const cv::Rect& part, const cv::Size& image, std::size_t first,
                std::size_t last, std::vector<ObjectView>& views) {
  const int rows = bits.rows, columns = bits.cols;
  const auto all = count_bits(bits.data, rows * columns, 1);
  std::array<std::int64_t, kBits> border{};
  const auto add = [&](bool is_border, const unsigned char* pixels, int count, int step) {
    const auto counts = count_bits(pixels, is_border ? count : 0, step);
    for (std::size_t bit = 0; bit < kBits; ++bit) border[bit] += counts[bit];
  };
  add(part.y == 0, bits.ptr(0), columns, 1);
  add(part.y + rows == image.height, bits.ptr(rows - 1), columns, 1);
  add(part.x == 0, bits.data, rows, columns);
  add(part.x + columns == image.width, bits.data + columns - 1, rows, columns);
  for (std::size_t i = first; i < last; ++i) {
    views[i].silhouette_px = all[i - first];
    views[i].touches_border = border[i - first] > 0;
  }
}

}  // namespace

void begin_silhouettes(const GlFunctions& gl) {
  gl.Enable(GL_STENCIL_TEST);
  gl.StencilFunc(GL_ALWAYS, 0xff, 0xff);
  gl.StencilOp(GL_KEEP, GL_REPLACE, GL_REPLACE);
}

unsigned silhouette_bit(std::size_t object) {
  return object < kBits ? 1u << object : 0;
}

void view_silhouettes(const GlFunctions& gl, const RenderTargets& targets, const cv::Rect& part,
                      const std::function<void(std::size_t)>& draw, const Lens* lens, cv::Mat& bits,
                      std::vector<ObjectView>& views) {
  if (part.empty()) return;
  const auto count = [&](unsigned framebuffer, std::size_t first, std::size_t last) {
    read_stencil(gl, framebuffer, part, bits);
    if (lens)
      count_pass(see_bits(*lens, bits, part), {{0, 0}, lens->places.size()}, lens->places.size(), first, last,
                 views);
    else
      count_pass(bits, part, {targets.width, targets.height}, first, last, views);
  };
  count(targets.image, 0, std::min(kBits, views.size()));
  for (std::size_t first = kBits; first < views.size(); first += kBits) {
    const std::size_t last = std::min(first + kBits, views.size());
    draw_pass(gl, targets, first, last, draw);
    count(targets.silhouettes, first, last);
  }
  check_gl(gl, "drawing silhouettes");
}

void count_visible(const cv::Mat& ids, std::vector<ObjectView>& views) {
  std::vector<std::int64_t> pixels(65536);
  for (int v = 0; v < ids.rows; ++v) {
    const auto* row = ids.ptr<std::uint16_t>(v);
    for (int u = 0; u < ids.cols;) {  // a run of one id at a time
      if (u + 4 <= ids.cols && are_zero(row + u)) {
        u += 4;
        continue;
      }
      const int begin = u;
      while (u < ids.cols && row[u] == row[begin]) ++u;
      pixels[row[begin]] += u - begin;
    }
  }
  for (ObjectView& view : views) view.visible_px = pixels[static_cast<std::size_t>(view.id)];
}

}  // namespace uniquadric
