#include "simulator/render/program.h"

#include <GL/glcorearb.h>
#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <string>

namespace uniquadric {
namespace {

const char* const kVersion = "#version 450 core\n";

const char* const kVertexShader = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 0) uniform mat4 camera_from_object;
layout(location = 1) uniform mat4 clip_from_camera;
layout(location = 9) uniform mat4 world_shadow_from_camera;
layout(location = 10) uniform mat4 objects_shadow_from_camera;
#ifdef ROLLING
layout(location = 11) uniform mat4 camera_from_object_at_top;
layout(location = 12) uniform mat4 camera_from_object_at_bottom;
layout(location = 13) uniform vec3 row;
layout(location = 14) uniform vec3 radial;
layout(location = 15) uniform vec3 tangential;
// Of a point in the camera frame, -1 to 1 in the image. Points behind the camera are taken for such beside it.
float row_of(vec3 point) {
  vec2 ray = point.xy / max(point.z, 1e-6);
  ray *= min(1, row.z / length(ray));
  float r2 = dot(ray, ray);
  float y = ray.y * (1 + r2 * (radial.x + r2 * (radial.y + r2 * radial.z))) +
            tangential.x * (r2 + 2 * ray.y * ray.y) + 2 * tangential.y * ray.x * ray.y;
  return clamp(row.x * y + row.y, -1.5, 1.5);
}
vec3 when_exposed(vec3 place) {
  vec3 top = (camera_from_object_at_top * vec4(position, 1)).xyz;
  vec3 bottom = (camera_from_object_at_bottom * vec4(position, 1)).xyz;
  vec3 half_way = 0.5 * (bottom - top), bend = 0.5 * (bottom + top) - place;
  vec3 seen = place;
  for (int i = 0; i < 3; ++i) {  // each time the row errs by less: by the share of it that the point moves
    float t = row_of(seen);
    seen = place + t * (half_way + t * bend);
  }
  return seen;
}
#endif
out vec3 normal_in_camera;
out vec2 texture_uv;
#ifdef SHINE
out vec3 position_in_camera;
#endif
#ifdef SHADOWS
out vec3 place_in_world_shadow, place_in_objects_shadow;
#endif
void main() {
  vec4 place = camera_from_object * vec4(position, 1);
  normal_in_camera = mat3(camera_from_object) * normal;
  texture_uv = uv;
#ifdef ROLLING
  gl_Position = clip_from_camera * vec4(when_exposed(place.xyz), 1);  // light stays that of the middle row
#else
  gl_Position = clip_from_camera * place;
#endif
#ifdef SHINE
  position_in_camera = place.xyz;
#endif
#ifdef SHADOWS
  place_in_world_shadow = (world_shadow_from_camera * place).xyz;
  place_in_objects_shadow = (objects_shadow_from_camera * place).xyz;
#endif
}
)";

// 1 / gl_FragCoord.w is clip w interpolated over the triangle with the right perspective: z in the camera
// frame. A highlight is as wide as Blinn's exponent 32 makes it: ours, semi-gloss paint.
// The map about the objects, a quarter of a layer wide, holds all that casts a shadow there: one lookup does,
// which is what shadows cost. Its last pixels are left to the world's map, for lookups reach one pixel
// further. What lies further from the sun than a map reaches is behind all that casts a shadow there: hence
// max(z, 0).
const char* const kFragmentShader = R"(
in vec3 normal_in_camera;
in vec2 texture_uv;
layout(location = 2) uniform uint instance_id;
layout(location = 3) uniform vec3 color;
layout(location = 4) uniform vec3 sun_direction;
layout(location = 5) uniform float ambient;
layout(location = 6) uniform float gain;
layout(location = 7) uniform float depth_return;
layout(location = 8) uniform float shine;
layout(binding = 0) uniform sampler2D surface;
layout(binding = 1) uniform sampler2DArrayShadow shadow_maps;
#ifdef SHINE
in vec3 position_in_camera;
#endif
#ifdef SHADOWS
in vec3 place_in_world_shadow, place_in_objects_shadow;
float sunlit() {
  vec2 from_middle = abs(place_in_objects_shadow.xy - 0.125);
  bool near_objects = max(from_middle.x, from_middle.y) < 0.1245;
  vec3 place = near_objects ? place_in_objects_shadow : place_in_world_shadow;
  return texture(shadow_maps, vec4(place.xy, near_objects ? 1 : 0, max(place.z, 0)));
}
#endif
#ifdef COLOR
layout(location = 0) out vec4 out_color;
#endif
#ifdef GEOMETRY
layout(location = 1) out uint out_id;
layout(location = 2) out float out_depth_m;
#endif
void main() {
#ifdef COLOR
  vec3 n = normalize(gl_FrontFacing ? normal_in_camera : -normal_in_camera);
  float sun = max(0, -dot(n, sun_direction));
  float highlight = 0;
#ifdef SHINE
  vec3 halfway = normalize(-sun_direction - normalize(position_in_camera));
  highlight = sun > 0 ? shine * pow(max(0, dot(n, halfway)), 32) : 0;
#endif
#ifdef SHADOWS
  float lit = sunlit();
  sun *= lit;
  highlight *= lit;
#endif
  float light = ambient + (1 - ambient) * sun;
  out_color = vec4(texture(surface, texture_uv).rgb * color * (gain * light) + gain * highlight,
                   depth_return * (1 - highlight));
#endif
#ifdef GEOMETRY
  out_id = instance_id;
  out_depth_m = 1 / gl_FragCoord.w;
#endif
}
)";

unsigned compile(const GlFunctions& gl, unsigned kind, const std::string& definitions, const char* source) {
  const unsigned shader = gl.CreateShader(kind);
  const std::array parts = {kVersion, definitions.c_str(), source};
  gl.ShaderSource(shader, parts.size(), parts.data(), nullptr);
  gl.CompileShader(shader);
  int done = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done) return shader;
  std::string log(4096, '\0');
  gl.GetShaderInfoLog(shader, static_cast<int>(log.size()), nullptr, log.data());
  throw std::runtime_error(fmt::format("shader does not compile: {}", log.c_str()));
}

}  // namespace

unsigned make_program(const GlFunctions& gl, ProgramOutput output, const ColorTerms& terms) {
  const unsigned program = gl.CreateProgram();
  const bool all = output == ProgramOutput::all, color = all || output == ProgramOutput::color;
  std::string definitions;
  if (color) definitions += "#define COLOR\n";
  if (all || output == ProgramOutput::geometry) definitions += "#define GEOMETRY\n";
  if (color && terms.shadows) definitions += "#define SHADOWS\n";
  if (color && terms.shine) definitions += "#define SHINE\n";
  if (terms.rolling_shutter) definitions += "#define ROLLING\n";
  gl.AttachShader(program, compile(gl, GL_VERTEX_SHADER, definitions, kVertexShader));
  gl.AttachShader(program, compile(gl, GL_FRAGMENT_SHADER, definitions, kFragmentShader));
  gl.LinkProgram(program);
  int done = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &done);
  if (done) return program;
  std::string log(4096, '\0');
  gl.GetProgramInfoLog(program, static_cast<int>(log.size()), nullptr, log.data());
  throw std::runtime_error(fmt::format("shader program does not link: {}", log.c_str()));
}

}  // namespace uniquadric
