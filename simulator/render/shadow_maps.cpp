#include "simulator/render/shadow_maps.h"

#include <GL/glcorearb.h>

#include <stdexcept>

#include "simulator/render/program.h"

namespace uniquadric {
namespace {

constexpr int kWorld_px = 2048, kObjects_px = 1024;  // ours: 4 mm in a room of 6 m, 1 mm about a tabletop
constexpr double kReach_m =
    60;  // ours: 6 cm a pixel of a street; what is further from the camera's way is lit
constexpr double kMargin_m = 0.01;  // so that no map is flat
// A lookup compares depths of up to one pixel away in both directions, where a plane's own depth differs by
// its slope, and OpenGL takes the larger of two for the slope: 2, and a little for rounding.
constexpr float kSlopeBias = 2.25f, kLeastBias = 16;

ShadowMap make_map(const GlFunctions& gl, int size_px) {
  ShadowMap map{size_px};
  gl.CreateTextures(GL_TEXTURE_2D, 1, &map.texture);
  gl.TextureStorage2D(map.texture, 1, GL_DEPTH_COMPONENT32F, size_px, size_px);
  gl.TextureParameteri(map.texture, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TextureParameteri(map.texture, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
  gl.TextureParameteri(map.texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TextureParameteri(map.texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TextureParameteri(map.texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);  // which is 0: lit
  gl.TextureParameteri(map.texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  gl.CreateFramebuffers(1, &map.framebuffer);
  gl.NamedFramebufferTexture(map.framebuffer, GL_DEPTH_ATTACHMENT, map.texture, 0);
  constexpr unsigned kNone = GL_NONE;
  gl.NamedFramebufferDrawBuffers(map.framebuffer, 1, &kNone);
  if (gl.CheckNamedFramebufferStatus(map.framebuffer, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw std::runtime_error("OpenGL cannot draw shadow maps");
  return map;
}

Eigen::AlignedBox3d box_in_light(const Eigen::Quaterniond& light_from_world,
                                 const std::vector<GpuBody>& bodies, const std::vector<Pose>& poses) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (int corner = 0; corner < 8; ++corner) {
      const auto type = static_cast<Eigen::AlignedBox3f::CornerType>(corner);
      if (!bodies[i].box.isEmpty())
        box.extend(light_from_world * (poses[i] * bodies[i].box.corner(type).cast<double>()));
    }
  return box;
}

// The part of the world beside which the camera passes: the least box about the places it takes, and a reach.
void clip_to_reach(const Scene& scene, const Eigen::Quaterniond& light_from_world, Eigen::AlignedBox3d& box) {
  Eigen::AlignedBox3d near;
  for (std::int64_t frame = 0; frame < scene.frames; ++frame)
    near.extend(light_from_world *
                scene.camera_motion.at(static_cast<double>(frame) / scene.rate_hz).translation);
  for (int k = 0; k < 2; ++k) {  // in depth all of it counts: a tower far up casts its shadow here
    box.min()[k] = std::max(box.min()[k], near.min()[k] - kReach_m);
    box.max()[k] = std::min(box.max()[k], near.max()[k] + kReach_m);
  }
}

// Rows run down, as they do in the image, so that outer sides wind the same way.
Eigen::Matrix4d map_from_light(Eigen::AlignedBox3d box) {
  if (box.isEmpty()) box = Eigen::AlignedBox3d(Eigen::Vector3d::Zero());
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kMargin_m), low = box.min() - margin,
                        high = box.max() + margin, scale = (high - low).cwiseInverse();
  Eigen::Matrix4d map = Eigen::Matrix4d::Identity();
  map.diagonal().head<3>() = scale.cwiseProduct(Eigen::Vector3d(1, -1, 1));
  map.col(3).head<3>() = scale.cwiseProduct(Eigen::Vector3d(-low.x(), high.y(), -low.z()));
  return map;
}

void draw_map(const GlFunctions& gl, const ShadowMaps& maps, const ShadowMap& map,
              const std::vector<GpuBody>& bodies, const std::vector<Pose>& poses) {
  constexpr float kFarthest = 0;
  Eigen::Matrix4d clip_from_map = Eigen::Vector4d(2, 2, 1, 1).asDiagonal();
  clip_from_map(0, 3) = clip_from_map(1, 3) = -1;
  gl.BindFramebuffer(GL_FRAMEBUFFER, map.framebuffer);
  gl.Viewport(0, 0, map.size_px, map.size_px);
  gl.ClearBufferfv(GL_DEPTH, 0, &kFarthest);
  gl.UseProgram(maps.program);
  gl.Enable(GL_DEPTH_TEST);
  gl.Enable(GL_CULL_FACE);
  gl.Enable(GL_POLYGON_OFFSET_FILL);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Matrix4f clip_from_object =
        (clip_from_map * map.map_from_world * poses[i].matrix()).cast<float>();
    gl.UniformMatrix4fv(uniform_camera_from_object, 1, GL_FALSE, clip_from_object.data());
    for (const GpuMesh& mesh : bodies[i].meshes) {
      gl.BindVertexArray(mesh.vertex_array);
      gl.DrawElements(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr);
    }
  }
  gl.Disable(GL_POLYGON_OFFSET_FILL);
  gl.Disable(GL_CULL_FACE);
}

void set_matrix(const GlFunctions& gl, Uniform uniform, const ShadowMap& map, const Pose& world_from_camera) {
  const Eigen::Matrix4f matrix = (map.map_from_world * world_from_camera.matrix()).cast<float>();
  gl.UniformMatrix4fv(uniform, 1, GL_FALSE, matrix.data());
}

}  // namespace

ShadowMaps make_shadow_maps(const GlFunctions& gl, const Scene& scene, const std::vector<GpuBody>& world,
                            const std::vector<Pose>& world_from_static) {
  ShadowMaps maps{make_program(gl, ProgramOutput::none, {}),
                  Eigen::Quaterniond::FromTwoVectors(scene.sun_direction, -Eigen::Vector3d::UnitZ()),
                  make_map(gl, kWorld_px), make_map(gl, kObjects_px)};
  gl.PolygonOffset(-kSlopeBias, -kLeastBias);  // away from the sun
  Eigen::AlignedBox3d box = box_in_light(maps.light_from_world, world, world_from_static);
  clip_to_reach(scene, maps.light_from_world, box);
  maps.world.map_from_world =
      map_from_light(box) * Pose{maps.light_from_world, Eigen::Vector3d::Zero()}.matrix();
  const Eigen::Matrix4f identity = Eigen::Matrix4f::Identity();
  gl.UseProgram(maps.program);
  gl.UniformMatrix4fv(uniform_clip_from_camera, 1, GL_FALSE, identity.data());
  draw_map(gl, maps, maps.world, world, world_from_static);
  return maps;
}

void draw_object_shadows(const GlFunctions& gl, ShadowMaps& maps, const std::vector<GpuBody>& objects,
                         const std::vector<Pose>& world_from_object) {
  const Eigen::AlignedBox3d box = box_in_light(maps.light_from_world, objects, world_from_object);
  maps.objects.map_from_world =
      map_from_light(box) * Pose{maps.light_from_world, Eigen::Vector3d::Zero()}.matrix();
  draw_map(gl, maps, maps.objects, objects, world_from_object);
}

void use_shadow_maps(const GlFunctions& gl, const ShadowMaps& maps, const Pose& world_from_camera) {
  set_matrix(gl, uniform_world_shadow_from_camera, maps.world, world_from_camera);
  set_matrix(gl, uniform_objects_shadow_from_camera, maps.objects, world_from_camera);
  gl.BindTextureUnit(1, maps.world.texture);
  gl.BindTextureUnit(2, maps.objects.texture);
}

}  // namespace uniquadric
