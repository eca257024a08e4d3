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
};

/// What a program draws: colour to draw buffer 0, instance id and metric depth to 1 and 2.
enum class ProgramOutput { all, color, geometry };

/// Compiles a shader program; all have the same uniforms. Throws std::runtime_error with the compiler's log.
unsigned make_program(const GlFunctions& gl, ProgramOutput output);

}  // namespace uniquadric
