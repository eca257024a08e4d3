#include "simulator/render/renderer.h"

#include <GL/glcorearb.h>
#include <fmt/format.h>

#include <array>
#include <set>

#include "core/base/error.h"
#include "simulator/render/gpu_mesh.h"
#include "simulator/render/program.h"
#include "simulator/render/render_targets.h"
#include "simulator/render/silhouettes.h"

namespace uniquadric {
namespace {

constexpr float kNear_m =
    0.01f;  // ours: nearer than any sensor focuses; with reversed Z it costs no precision

struct GpuBody {
  unsigned id = 0;
  std::vector<GpuMesh> meshes;
};

GpuBody upload_body(const GlFunctions& gl, const Body& body) {
  GpuBody gpu{static_cast<unsigned>(body.id), {}};
  for (const Mesh& mesh : body.meshes) gpu.meshes.push_back(upload_mesh(gl, mesh));
  return gpu;
}

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

}  // namespace

void check_can_render(const Scene& scene) {
  if (scene.camera.has_distortion())
    throw InputError(fmt::format(
        "scene {}: camera.distortion: lens distortion cannot be rendered, give a camera without it",
        scene.name));
  std::set<int> ids;
  for (const Body& body : scene.objects)
    if (body.id < 1 || body.id > 65535 || !ids.insert(body.id).second)
      throw InputError(fmt::format("scene {}: object {}: id {} is taken or not in 1..65535", scene.name,
                                   body.name, body.id));
}

ScenePoses poses_at(const Scene& scene, double time_s) {
  ScenePoses poses{scene.camera_motion.at(time_s), {}};
  for (const Body& body : scene.objects) poses.world_from_object.push_back(body.motion.at(time_s));
  return poses;
}

double ObjectView::visible_fraction() const {
  return silhouette_px > 0 ? static_cast<double>(visible_px) / static_cast<double>(silhouette_px) : 0;
}

struct Renderer::State {
  std::unique_ptr<GlContext> context;
  GlFunctions gl;
  RenderTargets targets;
  std::vector<GpuBody> world, objects;
  std::vector<Pose> world_from_static;  // one a body of the world
  Eigen::Vector3d sun_direction;
  std::array<float, 4> sky{};
  RenderedFrame frame;  // reused, as is
  cv::Mat bits;

  void use_program(const Scene& scene);
  void draw(const ScenePoses& poses, bool silhouettes);
  void draw_body(const GpuBody& body, const Pose& camera_from_object) const;
  std::vector<ObjectView> view_objects(const ScenePoses& poses, const cv::Mat& ids);
};

void Renderer::State::use_program(const Scene& scene) {
  gl.UseProgram(make_program(gl));
  const Eigen::Matrix4f clip = clip_from_camera(scene.camera);
  gl.UniformMatrix4fv(uniform_clip_from_camera, 1, GL_FALSE, clip.data());
  gl.Uniform1f(uniform_ambient, static_cast<float>(scene.ambient));
  gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl.DepthFunc(GL_GREATER);
  gl.FrontFace(GL_CW);  // rows run down here, up in OpenGL: what is counter-clockwise turns
  gl.Viewport(0, 0, targets.width, targets.height);
}

void Renderer::State::draw_body(const GpuBody& body, const Pose& camera_from_object) const {
  const Eigen::Matrix4f matrix = camera_from_object.matrix().cast<float>();
  gl.UniformMatrix4fv(uniform_camera_from_object, 1, GL_FALSE, matrix.data());
  gl.Uniform1ui(uniform_instance_id, body.id);
  for (const GpuMesh& mesh : body.meshes) {
    gl.Uniform3fv(uniform_color, 1, mesh.color.data());
    gl.BindTextureUnit(0, mesh.texture);
    gl.BindVertexArray(mesh.vertex_array);
    gl.DrawElements(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr);
  }
}

std::vector<ObjectView> Renderer::State::view_objects(const ScenePoses& poses, const cv::Mat& ids) {
  const Pose camera_from_world = poses.world_from_camera.inverse();
  std::vector<ObjectView> views;
  for (const GpuBody& body : objects) views.push_back({static_cast<int>(body.id)});
  view_silhouettes(
      gl, targets,
      [&](std::size_t i) { draw_body(objects[i], camera_from_world * poses.world_from_object[i]); }, bits,
      views);
  count_visible(ids, views);
  return views;
}

Renderer::Renderer(const Scene& scene) : state_(std::make_unique<State>()) {
  check_can_render(scene);
  State& s = *state_;
  s.context = make_osmesa_context();
  s.context->make_current();
  s.gl = load_gl_functions(*s.context);
  s.targets = make_render_targets(s.gl, scene.camera.width, scene.camera.height);
  s.use_program(scene);
  for (const Body& body : scene.world) {
    s.world.push_back(upload_body(s.gl, body));
    s.world_from_static.push_back(body.motion.at(0));
  }
  for (const Body& body : scene.objects) s.objects.push_back(upload_body(s.gl, body));
  s.sun_direction = scene.sun_direction.normalized();
  for (int k = 0; k < 3; ++k) s.sky[k] = static_cast<float>(scene.sky_color[k]);
  check_gl(s.gl, "preparing to draw");
}

Renderer::~Renderer() = default;

void Renderer::State::draw(const ScenePoses& poses, bool silhouettes) {
  context->make_current();
  constexpr float kNothing[4] = {0, 0, 0, 0};
  constexpr unsigned kNoId[4] = {0, 0, 0, 0};
  gl.BindFramebuffer(GL_FRAMEBUFFER, targets.image);
  gl.ClearBufferfv(GL_COLOR, 0, sky.data());
  gl.ClearBufferuiv(GL_COLOR, 1, kNoId);
  gl.ClearBufferfv(GL_COLOR, 2, kNothing);
  gl.StencilMask(0xff);
  gl.ClearBufferfi(GL_DEPTH_STENCIL, 0, 0, 0);  // together they are cleared in one go
  gl.Enable(GL_DEPTH_TEST);
  if (silhouettes) begin_silhouettes(gl);
  const Pose camera_from_world = poses.world_from_camera.inverse();
  const Eigen::Vector3f sun = (camera_from_world.rotation * sun_direction).cast<float>();
  gl.Uniform3fv(uniform_sun_direction, 1, sun.data());
  for (std::size_t i = 0; i < objects.size(); ++i) {  // first, so that they hide some of the world's pixels
    if (silhouettes) gl.StencilMask(silhouette_bit(i));
    draw_body(objects[i], camera_from_world * poses.world_from_object.at(i));
  }
  gl.Disable(GL_STENCIL_TEST);
  for (std::size_t i = 0; i < world.size(); ++i)
    draw_body(world[i], camera_from_world * world_from_static[i]);
}

void Renderer::draw(const ScenePoses& poses) {
  state_->draw(poses, false);
}

void Renderer::read_back(cv::Mat& rgba, cv::Mat& ids, cv::Mat& depth_m) {
  State& s = *state_;
  read_color(s.gl, s.targets, rgba);
  read_ids(s.gl, s.targets, ids);
  read_depth(s.gl, s.targets, depth_m);
  check_gl(s.gl, "drawing");
}

const RenderedFrame& Renderer::render(const ScenePoses& poses) {
  RenderedFrame& frame = state_->frame;
  state_->draw(poses, true);
  read_back(frame.rgba, frame.ids, frame.depth_m);
  frame.objects = state_->view_objects(poses, frame.ids);
  return frame;
}

}  // namespace uniquadric
