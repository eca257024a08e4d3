#include "simulator/render/pass.h"

#include <GL/glcorearb.h>

#include <Eigen/Core>
#include <limits>

#include "simulator/scene/any_mesh.h"

namespace uniquadric {
namespace {

// Depth runs from 1 at kNear_m to 0 at infinity. OpenGL's row 0 is our top row, and pixel (u, v) lies at
// (u + 0.5, v + 0.5) of its window: hence c + 0.5.
Eigen::Matrix4f clip_from_camera(const Camera& camera) {
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = 2 * camera.fx / camera.width;
  clip(0, 2) = 2 * (camera.cx + 0.5) / camera.width - 1;
  clip(1, 1) = 2 * camera.fy / camera.height;
  clip(1, 2) = 2 * (camera.cy + 0.5) / camera.height - 1;
  clip(2, 3) = kNear_m;
  clip(3, 2) = 1;
  return clip.cast<float>();
}

// Ids and depth are those of one time, and so what draws them.
bool rolls_in(const Scene& scene, ProgramOutput output) {
  const bool apart = output == ProgramOutput::color || output == ProgramOutput::none;
  return apart && scene.imaging.rolling_shutter_s > 0;
}

bool has_shine(const Scene& scene) {
  return any_mesh(scene, [](const Mesh& mesh) { return mesh.shine > 0; });
}

// Where rows are in the image that the sensor exposes, behind its lens.
void set_rows(const GlFunctions& gl, const Camera& seen, const Lens* lens) {
  const double steepest = lens ? lens->steepest : std::numeric_limits<float>::max();
  const auto& [k1, k2, p1, p2, k3] = seen.distortion;
  const Eigen::Vector3f row = Eigen::Vector3d(2 * seen.fy / seen.height,
                                              2 * (seen.cy + 0.5) / seen.height - 1, steepest)
                                  .cast<float>(),
                        radial = Eigen::Vector3d(k1, k2, k3).cast<float>(),
                        tangential = Eigen::Vector3d(p1, p2, 0).cast<float>();
  gl.Uniform3fv(uniform_row, 1, row.data());
  gl.Uniform3fv(uniform_lens_radial, 1, radial.data());
  gl.Uniform3fv(uniform_lens_tangential, 1, tangential.data());
}

unsigned make_program_for(const GlFunctions& gl, const Scene& scene, const Camera& drawn, const Lens* lens,
                          ProgramOutput output, const Light& light, bool shine) {
  const bool rolls = rolls_in(scene, output);
  const unsigned program = make_program(gl, output, {light.shadows, shine, rolls});
  gl.UseProgram(program);
  const Eigen::Matrix4f clip = clip_from_camera(drawn);
  gl.UniformMatrix4fv(uniform_clip_from_camera, 1, GL_FALSE, clip.data());
  gl.Uniform1f(uniform_ambient, static_cast<float>(light.ambient));
  gl.Uniform1f(uniform_gain, static_cast<float>(light.gain));
  if (rolls) set_rows(gl, scene.camera, lens);
  return program;
}

}  // namespace

// Highlights cost a fifth of all that makes colour: where there are none, a program without them draws.
Pass make_pass(const GlFunctions& gl, const Scene& scene, const Camera& drawn, const Lens* lens,
               ProgramOutput output, const Light& light) {
  const auto program = [&](bool shine) {
    return make_program_for(gl, scene, drawn, lens, output, light, shine);
  };
  const bool lit = output == ProgramOutput::all || output == ProgramOutput::color;
  const unsigned matte = program(false);
  return {matte, lit && has_shine(scene) ? program(true) : matte, rolls_in(scene, output)};
}

}  // namespace uniquadric
