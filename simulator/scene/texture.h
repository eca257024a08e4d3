#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string_view>

namespace uniquadric {

/// How a surface is painted. Every style carries marks with sharp corners at several scales, so that corner
/// trackers find features wherever the camera looks.
enum class TextureStyle { panels, checks, speckle, strokes, planks, bricks };
inline constexpr std::array<std::string_view, 6> kTextureStyleNames = {"panels",  "checks", "speckle",
                                                                       "strokes", "planks", "bricks"};

/// How many marks with corners a surface carries: as many as its style has and more, an eighth of its own,
/// or none at all, just its tone.
enum class TextureAmount { rich, sparse, none };

struct Material {
  TextureAmount amount = TextureAmount::rich;
  TextureStyle style = TextureStyle::panels;
  Eigen::Vector3d color = {0.6, 0.55, 0.5};  ///< (red, green, blue) in [0, 1], the surface's mean tone
  Eigen::Vector3d accent = {0.2, 0.3, 0.5};  ///< second colour, of marks and every other field
  double contrast = 0.6;    ///< in [0, 1]: spread of the tones; seams and marks in the accent remain at 0
  std::uint64_t seed = 0;   ///< other seeds, other marks
  int size_px = 512;        ///< longer side of a texture
  int marks = 10;           ///< medium marks along the longer side; small ones are a tenth, large ones twice
  double shine = 0;         ///< as Mesh has it
  double depth_return = 1;  ///< as Mesh has it
  bool is_painted = true;   ///< else its textures have their size and one tone: for who looks at none
};

/// Paints the texture of one part (face, wall) of a body, CV_8UC3 (blue, green, red); the shorter side
/// follows the surface's extents [m]. A pure function of its arguments: parts of one material differ from
/// each other.
cv::Mat paint_texture(const Material& material, std::uint32_t part, double width_m, double height_m);

}  // namespace uniquadric
