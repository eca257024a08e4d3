#pragma once

#include "simulator/render/gl_functions.h"

namespace uniquadric {

/// Locations of the program's uniforms.
enum Uniform : int {
  uniform_camera_from_object = 0,
  uniform_clip_from_camera = 1,
  uniform_instance_id = 2,
  uniform_color = 3,
  uniform_sun_direction = 4,  ///< in the camera frame
  uniform_ambient = 5,
  uniform_gain = 6,
  uniform_depth_return = 7,
  uniform_shine = 8,
  uniform_world_shadow_from_camera = 9,  ///< to coordinates in the shadow maps at texture unit 1, its layer 0
  uniform_objects_shadow_from_camera = 10,    ///< the same, layer 1
  uniform_camera_from_object_at_top = 11,     ///< when a rolling shutter exposes the image's upper edge,
  uniform_camera_from_object_at_bottom = 12,  ///< and its lower edge
  uniform_row = 13,  ///< a row is x y + y of the distorted ray's y, from -1 at the top to 1; z: widest ray
  uniform_lens_radial = 14,      ///< k1 k2 k3
  uniform_lens_tangential = 15,  ///< p1 p2 and 0
};

/// What a program draws: colour to draw buffer 0, instance id and metric depth to 1 and 2; `none`: the depth
/// buffer alone.
enum class ProgramOutput { all, color, geometry, none };

/// What colour takes account of, beyond light and texture: what a scene does not need shall cost no time.
struct ColorTerms {
  bool shadows = false, shine = false;
  /// Each vertex lies where it is when its row is exposed. The pose in between follows a parabola through
  /// those of the top, the middle and the bottom row. Of ProgramOutput::none too.
  bool rolling_shutter = false;
};

/// Compiles a shader program; all have the same uniforms. Throws std::runtime_error with the compiler's log.
unsigned make_program(const GlFunctions& gl, ProgramOutput output, const ColorTerms& terms);

}  // namespace uniquadric
