#pragma once

#include "core/geometry/camera.h"
#include "simulator/render/gl_functions.h"
#include "simulator/render/lens.h"
#include "simulator/render/program.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// What is nearer is not drawn [m]. Ours: nearer than any sensor focuses; with reversed Z it costs no
/// precision.
inline constexpr float kNear_m = 0.01f;

/// What light surfaces are drawn in; by default all of them in the same, so that their own colour is left.
struct Light {
  bool shadows = false;
  double ambient = 1, gain = 1;
};

/// The programs that draw, each for meshes of its kind, and whether they know a rolling shutter.
struct Pass {
  unsigned matte = 0, shiny = 0;
  bool rolls = false;
};

/// Programs with all that stays the same from frame to frame. `drawn`: the camera that is drawn, the ideal
/// one where there is a lens; null: none. Throws as make_program() does.
Pass make_pass(const GlFunctions& gl, const Scene& scene, const Camera& drawn, const Lens* lens,
               ProgramOutput output, const Light& light);

}  // namespace uniquadric
