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
};

/// Compiles the one shader program: colour, instance id and metric depth to draw buffers 0, 1, 2. Throws
/// std::runtime_error with the compiler's log.
unsigned make_program(const GlFunctions& gl);

}  // namespace uniquadric
