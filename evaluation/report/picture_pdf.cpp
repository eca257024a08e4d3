#include <cairo-pdf.h>

#include <memory>
#include <stdexcept>

#include "evaluation/report/picture.h"
#include "evaluation/report/svg_colours.h"

namespace uniquadric {
namespace {

constexpr double kUnit_pt = 0.75;  // a pixel of CSS
constexpr double kPlain = 12, kTick = 11;

void set_colour(cairo_t* page, const std::string& hex) {
  const Rgb rgb = rgb_of(hex).value();
  cairo_set_source_rgb(page, rgb.red / 255.0, rgb.green / 255.0, rgb.blue / 255.0);
}

// Colour, width and dashes as the SVG has them.
void set_pen(cairo_t* page, const PictureLine& line) {
  constexpr double kDashes[] = {5, 3};
  const bool is_dashed = line.kind == LineKind::reference;
  cairo_set_dash(page, kDashes, is_dashed ? 2 : 0, 0);
  cairo_set_line_cap(page, line.kind == LineKind::coloured ? CAIRO_LINE_CAP_ROUND : CAIRO_LINE_CAP_BUTT);
  cairo_set_line_join(page, line.kind == LineKind::coloured ? CAIRO_LINE_JOIN_ROUND : CAIRO_LINE_JOIN_MITER);
  switch (line.kind) {
    case LineKind::grid:
      set_colour(page, kLightSvg.grid);
      return cairo_set_line_width(page, 1);
    case LineKind::reference:
      set_colour(page, kLightSvg.quiet);
      return cairo_set_line_width(page, 1.2);
    case LineKind::estimate:
      set_colour(page, kLightSvg.variant[0]);
      return cairo_set_line_width(page, 1.6);
    case LineKind::coloured:
      set_colour(page, line.colour);
      return cairo_set_line_width(page, 2.2);
  }
}

void draw(cairo_t* page, const PictureLine& line) {
  if (line.points.empty()) return;
  set_pen(page, line);
  cairo_new_path(page);                                              // a text leaves the pen at its end
  for (const auto& [x, y] : line.points) cairo_line_to(page, x, y);  // the first one begins
  cairo_stroke(page);
}

void draw(cairo_t* page, const PictureText& text) {
  const bool is_tick = text.kind == TextKind::tick;
  const bool is_heavy = text.kind == TextKind::name || text.kind == TextKind::title;
  cairo_select_font_face(page, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                         is_heavy ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(page, is_tick ? kTick : kPlain);
  cairo_text_extents_t extents;
  cairo_text_extents(page, text.text.c_str(), &extents);
  const double left = text.anchor == TextAnchor::start    ? 0
                      : text.anchor == TextAnchor::middle ? extents.x_advance / 2
                                                          : extents.x_advance;
  set_colour(page, is_tick ? kLightSvg.quiet : kLightSvg.text);
  cairo_move_to(page, text.at.x - left, text.at.y);
  cairo_show_text(page, text.text.c_str());
}

void draw(cairo_t* page, const PictureBox& box) {
  set_colour(page, box.colour);
  cairo_rectangle(page, box.corner.x, box.corner.y, box.width, box.height);
  cairo_fill(page);
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned length) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

std::string picture_pdf(const Picture& picture) {
  std::string bytes;
  const std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface(
      cairo_pdf_surface_create_for_stream(append, &bytes, kUnit_pt * picture.width,
                                          kUnit_pt * picture.height),
      cairo_surface_destroy);
  cairo_pdf_surface_restrict_to_version(surface.get(), CAIRO_PDF_VERSION_1_4);  // LaTeX warns of later ones
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE, picture.label.c_str());
  // else it would be now, and the same call would not give the same bytes
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
  {
    const std::unique_ptr<cairo_t, void (*)(cairo_t*)> page(cairo_create(surface.get()), cairo_destroy);
    cairo_scale(page.get(), kUnit_pt, kUnit_pt);
    for (const auto& part : picture.parts) std::visit([&](const auto& p) { draw(page.get(), p); }, part);
  }
  cairo_surface_finish(surface.get());
  if (const cairo_status_t status = cairo_surface_status(surface.get()); status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(std::string("a PDF picture cannot be made: ") + cairo_status_to_string(status));
  return bytes;
}

}  // namespace uniquadric
