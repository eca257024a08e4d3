#include "simulator/render/shadow_maps.h"

#include <GL/glcorearb.h>

#include <algorithm>
#include <stdexcept>

#include "simulator/render/program.h"

namespace uniquadric {
namespace {

constexpr int kWorld_px = 2048;             // ours: 4 mm in a room of 6 m
constexpr int kObjects_px = kWorld_px / 4;  // ours: 2 mm about a tabletop; the shader knows the share
constexpr double kReach_m = 60;             // ours: of a street; what is further from the camera's way is lit
constexpr double kMargin = 0.01;            // share of a map beyond what it is fitted to
constexpr double kLeastMargin_m = 0.01;     // so that no map is flat
constexpr int kRim_px = 1;  // stays clear, so that lookups beside the map, which find its rim, are lit
// A lookup compares depths of up to one pixel away in both directions, where a plane's own depth differs by
// its slope, and OpenGL takes the larger of the two for the slope: 2, and a little for rounding.
constexpr float kSlopeBias = 2.25f, kLeastBias = 16;

unsigned make_layers(const GlFunctions& gl) {
  unsigned texture = 0;
  gl.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture);
  gl.TextureStorage3D(texture, 1, GL_DEPTH_COMPONENT32F, kWorld_px, kWorld_px, 2);
  gl.TextureParameteri(texture, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TextureParameteri(texture, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
  gl.TextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);  // the mean of 2 x 2 comparisons
  gl.TextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

ShadowMap make_map(const GlFunctions& gl, unsigned texture, int layer, int size_px) {
  ShadowMap map{size_px};
  gl.CreateFramebuffers(1, &map.framebuffer);
  gl.NamedFramebufferTextureLayer(map.framebuffer, GL_DEPTH_ATTACHMENT, texture, 0, layer);
  constexpr unsigned kNone = GL_NONE;
  gl.NamedFramebufferDrawBuffers(map.framebuffer, 1, &kNone);
  if (gl.CheckNamedFramebufferStatus(map.framebuffer, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw std::runtime_error("OpenGL cannot draw shadow maps");
  return map;
}

Eigen::AlignedBox3d transformed(const Eigen::Matrix4d& to_from_box, const Eigen::AlignedBox3f& box) {
  Eigen::AlignedBox3d result;
  for (int i = 0; i < 8 && !box.isEmpty(); ++i) {
    const Eigen::Vector3f corner = box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i));
    result.extend((to_from_box * corner.cast<double>().homogeneous()).head<3>());
  }
  return result;
}

Eigen::Matrix4d light_matrix(const ShadowMaps& maps) {
  return Pose{maps.light_from_world, Eigen::Vector3d::Zero()}.matrix();
}

Eigen::AlignedBox3d box_in_light(const ShadowMaps& maps, const PlacedBodies& placed) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < placed.bodies.size(); ++i)
    box.extend(transformed(light_matrix(maps) * placed.world_from_body[i].matrix(), placed.bodies[i].box));
  return box;
}

// The part of the world beside which the camera passes. In depth all of it counts: a tower's top casts its
// shadow far away.
void clip_to_reach(const Scene& scene, const ShadowMaps& maps, Eigen::AlignedBox3d& box) {
  Eigen::AlignedBox3d way;
  for (std::int64_t frame = 0; frame < scene.frames; ++frame)
    way.extend(maps.light_from_world *
               scene.camera_motion.at(static_cast<double>(frame) / scene.rate_hz).translation);
  for (int k = 0; k < 2; ++k) {
    box.min()[k] = std::max(box.min()[k], way.min()[k] - kReach_m);
    box.max()[k] = std::min(box.max()[k], way.max()[k] + kReach_m);
  }
}

// Lets the map show what the box in the light's frame holds. Rows run down, as they do in the image, so that
// outer sides wind the same way.
void fit(ShadowMap& map, const ShadowMaps& maps, Eigen::AlignedBox3d box) {
  if (box.isEmpty()) box = Eigen::AlignedBox3d(Eigen::Vector3d::Zero());
  const Eigen::Vector3d margin = (kMargin * box.sizes()).cwiseMax(kLeastMargin_m);
  const Eigen::Vector3d low = box.min() - margin, high = box.max() + margin;
  map.texel_m = (high - low).head<2>().maxCoeff() / map.size_px;
  const double share = static_cast<double>(map.size_px) / kWorld_px;  // of the layer
  const Eigen::Vector3d scale = (high - low).cwiseInverse().cwiseProduct(Eigen::Vector3d(share, share, 1));
  Eigen::Matrix4d map_from_light = Eigen::Matrix4d::Identity();
  map_from_light.diagonal().head<3>() = scale.cwiseProduct(Eigen::Vector3d(1, -1, 1));
  map_from_light.col(3).head<3>() = scale.cwiseProduct(Eigen::Vector3d(-low.x(), high.y(), -low.z()));
  map.map_from_world = map_from_light * light_matrix(maps);
}

void begin_map(const GlFunctions& gl, const ShadowMaps& maps, const ShadowMap& map) {
  constexpr float kFarthest = 0;
  gl.BindFramebuffer(GL_FRAMEBUFFER, map.framebuffer);
  gl.Enable(GL_SCISSOR_TEST);
  gl.Scissor(0, 0, map.size_px, map.size_px);
  gl.ClearBufferfv(GL_DEPTH, 0, &kFarthest);
  gl.Scissor(kRim_px, kRim_px, map.size_px - 2 * kRim_px, map.size_px - 2 * kRim_px);
  gl.Viewport(0, 0, map.size_px, map.size_px);
  gl.UseProgram(maps.program);
  gl.Enable(GL_DEPTH_TEST);
  gl.Enable(GL_CULL_FACE);
  gl.PolygonOffset(-kSlopeBias, -kLeastBias);  // away from the sun
  gl.Enable(GL_POLYGON_OFFSET_FILL);
}

void draw_into(const GlFunctions& gl, const ShadowMap& map, const PlacedBodies& placed) {
  const double share = static_cast<double>(map.size_px) / kWorld_px;
  const Eigen::AlignedBox2d window(Eigen::Vector2d::Zero(), Eigen::Vector2d::Constant(share));
  Eigen::Matrix4d clip_from_map = Eigen::Vector4d(2 / share, 2 / share, 1, 1).asDiagonal();
  clip_from_map(0, 3) = clip_from_map(1, 3) = -1;
  for (std::size_t i = 0; i < placed.bodies.size(); ++i) {
    const Eigen::Matrix4d map_from_object = map.map_from_world * placed.world_from_body[i].matrix();
    const Eigen::Matrix4f clip_from_object = (clip_from_map * map_from_object).cast<float>();
    gl.UniformMatrix4fv(uniform_camera_from_object, 1, GL_FALSE, clip_from_object.data());
    for (const GpuMesh& mesh : placed.bodies[i].meshes) {
      const Eigen::AlignedBox3d box = transformed(map_from_object, mesh.box);
      if (box.isEmpty() || !window.intersects({box.min().head<2>(), box.max().head<2>()})) continue;
      gl.BindVertexArray(mesh.vertex_array);
      gl.DrawElements(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr);
    }
  }
}

void end_map(const GlFunctions& gl) {
  gl.Disable(GL_POLYGON_OFFSET_FILL);
  gl.Disable(GL_CULL_FACE);
  gl.Disable(GL_SCISSOR_TEST);
}

void set_matrix(const GlFunctions& gl, Uniform uniform, const ShadowMap& map, const Pose& world_from_camera) {
  const Eigen::Matrix4f matrix = (map.map_from_world * world_from_camera.matrix()).cast<float>();
  gl.UniformMatrix4fv(uniform, 1, GL_FALSE, matrix.data());
}

}  // namespace

ShadowMaps make_shadow_maps(const GlFunctions& gl, const Scene& scene, const PlacedBodies& world) {
  ShadowMaps maps;
  maps.program = make_program(gl, ProgramOutput::none, {});
  maps.texture = make_layers(gl);
  maps.light_from_world = Eigen::Quaterniond::FromTwoVectors(scene.sun_direction, -Eigen::Vector3d::UnitZ());
  maps.world = make_map(gl, maps.texture, 0, kWorld_px);
  maps.objects = make_map(gl, maps.texture, 1, kObjects_px);
  gl.UseProgram(maps.program);
  const Eigen::Matrix4f identity = Eigen::Matrix4f::Identity();
  gl.UniformMatrix4fv(uniform_clip_from_camera, 1, GL_FALSE, identity.data());
  Eigen::AlignedBox3d box = box_in_light(maps, world);
  clip_to_reach(scene, maps, box);
  fit(maps.world, maps, box);
  begin_map(gl, maps, maps.world);
  draw_into(gl, maps.world, world);
  end_map(gl);
  return maps;
}

void draw_object_shadows(const GlFunctions& gl, ShadowMaps& maps, const PlacedBodies& world,
                         const PlacedBodies& objects) {
  Eigen::AlignedBox3d box = box_in_light(maps, objects);
  const Eigen::AlignedBox3d world_box = box_in_light(maps, world);
  if (!box.isEmpty() && !world_box.isEmpty()) {  // in depth it reaches all that can cast a shadow there
    box.min().z() = std::min(box.min().z(), world_box.min().z());
    box.max().z() = std::max(box.max().z(), world_box.max().z());
  }
  fit(maps.objects, maps, box);
  begin_map(gl, maps, maps.objects);
  draw_into(gl, maps.objects, objects);
  draw_into(gl, maps.objects, world);
  end_map(gl);
}

void use_shadow_maps(const GlFunctions& gl, const ShadowMaps& maps, const Pose& world_from_camera) {
  set_matrix(gl, uniform_world_shadow_from_camera, maps.world, world_from_camera);
  set_matrix(gl, uniform_objects_shadow_from_camera, maps.objects, world_from_camera);
  gl.BindTextureUnit(1, maps.texture);
}

}  // namespace uniquadric
