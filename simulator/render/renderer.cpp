#include "simulator/render/renderer.h"

#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <optional>

#include "core/base/vector_clones.h"
#include "simulator/render/box_pixels.h"
#include "simulator/render/gpu_mesh.h"
#include "simulator/render/lens.h"
#include "simulator/render/pass.h"
#include "simulator/render/render_targets.h"
#include "simulator/render/shadow_maps.h"
#include "simulator/render/silhouettes.h"
#include "simulator/scene/any_mesh.h"

namespace uniquadric {
namespace {

// How far the hull lies behind the surfaces: a tenth of what their depth changes by in a pixel, and some last
// places. Rounding errs by 1e-3 of the one, for depth is extrapolated from the image's corner, and by few of
// the others.
constexpr float kHullSlope = 0.1f, kHullPlaces = 64;

// Of all that is drawn.
double drawn_gain(const Imaging& imaging) {
  return imaging.changes_exposure() ? 1 : imaging.gain;
}

// Sums of `count` bytes each become their means. The product is exact: of sums below 2^16 and counts below
// 257 it errs by less than one part of the divisor.
UNIQUADRIC_VECTOR_CLONES
void divide_rounded(const std::vector<std::uint16_t>& sums, unsigned count, unsigned char* __restrict means) {
  const std::uint32_t inverse = ((1u << 24) + count - 1) / count, half = count / 2;
  const std::uint16_t* sum = sums.data();
  for (std::size_t i = 0, end = sums.size(); i < end; ++i)
    means[i] = static_cast<unsigned char>((sum[i] + half) * inverse >> 24);
}

// camera_from_object when the middle row is exposed, and the image's upper and lower edge.
struct Place {
  Pose middle, top, bottom;
};

Place at_once(const Pose& camera_from_object) {
  return {camera_from_object, camera_from_object, camera_from_object};
}

// Where the cameras of all frames are, seen from a body.
std::vector<Eigen::Vector3f> cameras_about(const Scene& scene, const Motion& body) {
  std::vector<Eigen::Vector3f> cameras_m;
  for (std::int64_t frame = 0; frame < scene.frames; ++frame) {
    const double time_s = 1e-9 * static_cast<double>(scene.stamp_ns(frame));
    cameras_m.push_back(
        (body.at(time_s).inverse() * scene.camera_motion.at(time_s).translation).cast<float>());
  }
  return cameras_m;
}

}  // namespace

struct Renderer::State {
  std::unique_ptr<GlContext> context;
  GlFunctions gl;
  RenderTargets targets;
  Pass all, color, geometry, hull;  // all rows; as ProgramOutput has them, the hull being `none`
  Pass returned;                    // what a depth sensor's light meets: all, evenly lit
  bool one_pass = true;  // render() draws colour, ids and depth at once, else ids and depth, then colour
  bool is_multisampled = false;
  std::vector<GpuBody> world, objects;
  std::vector<Pose> world_from_static;  // one a body of the world
  std::optional<ShadowMaps> shadows;
  std::optional<std::vector<Pose>> shadow_casters;  // where the objects' map has them: this frame's
  Camera camera;                                    // that is drawn: the ideal one where there is a lens
  std::optional<Lens> lens;                         // of a camera with distortion
  Eigen::Vector3d sun_direction;
  std::array<float, 4> sky{};
  RenderedFrame frame, late;  // reused, as are these
  cv::Mat bits, exposed;
  cv::Mat ideal_rgba, ideal_ids, ideal_m;  // of the lens
  std::vector<std::uint16_t> sums;

  void upload(const Scene& scene);
  void draw_image(const ScenePoses& poses, bool silhouettes);
  void draw_returned(const ScenePoses& poses) const;
  void clear_image() const;
  void clear_depth(unsigned framebuffer) const;
  void draw_depth(const ScenePoses& poses) const;
  void draw_color(const ColorStep& step);
  void draw_hull(const ColorStep& step) const;
  void draw_bodies(const Pass& pass, const ColorStep& step, bool silhouettes) const;
  void cast_shadows(const ScenePoses& poses);
  bool has_shadows_of(const std::vector<Pose>& poses) const;
  void draw_body(const Pass& pass, const GpuBody& body, const Place& place) const;
  bool is_beside_image(const GpuMesh& mesh, const Place& place) const;
  void read_image_color(cv::Mat& rgba);
  void read_geometry(cv::Mat& ids, cv::Mat& depth_m);
  void expose(const std::vector<ColorStep>& steps);
  std::vector<ObjectView> view_objects(const ScenePoses& poses, const cv::Mat& ids);
};

void Renderer::State::upload(const Scene& scene) {
  const auto upload_one = [&](const Body& body) {
    const bool rolls = scene.imaging.rolling_shutter_s > 0;  // then vertices have times, and triangles none
    return upload_body(gl, body, rolls ? cameras_about(scene, body.motion) : std::vector<Eigen::Vector3f>());
  };
  for (const Body& body : scene.world) {
    world.push_back(upload_one(body));
    world_from_static.push_back(body.motion.at(0));
  }
  for (const Body& body : scene.objects) objects.push_back(upload_one(body));
  sun_direction = scene.sun_direction.normalized();
  for (int k = 0; k < 3; ++k) sky[k] = static_cast<float>(drawn_gain(scene.imaging) * scene.sky_color[k]);
  if (scene.shadows) shadows = make_shadow_maps(gl, scene, {world, world_from_static});
}

// Most meshes of a street are.
bool Renderer::State::is_beside_image(const GpuMesh& mesh, const Place& place) const {
  return std::ranges::all_of(std::array{&place.middle, &place.top, &place.bottom}, [&](const Pose* pose) {
    return pixels_of_box(mesh.box, *pose, camera, kNear_m).empty();
  });
}

void Renderer::State::draw_body(const Pass& pass, const GpuBody& body, const Place& place) const {
  const auto set_pose = [&](Uniform uniform, const Pose& pose) {
    const Eigen::Matrix4f matrix = pose.matrix().cast<float>();
    gl.UniformMatrix4fv(uniform, 1, GL_FALSE, matrix.data());
  };
  unsigned in_use = 0;
  for (const GpuMesh& mesh : body.meshes) {
    if (is_beside_image(mesh, place)) continue;
    if (const unsigned program = mesh.shine > 0 ? pass.shiny : pass.matte; program != in_use) {
      gl.UseProgram(in_use = program);
      set_pose(uniform_camera_from_object, place.middle);
      if (pass.rolls) {
        set_pose(uniform_camera_from_object_at_top, place.top);
        set_pose(uniform_camera_from_object_at_bottom, place.bottom);
      }
      gl.Uniform1ui(uniform_instance_id, body.id);
    }
    gl.Uniform3fv(uniform_color, 1, mesh.color.data());
    gl.Uniform1f(uniform_shine, mesh.shine);
    gl.Uniform1f(uniform_depth_return, mesh.depth_return);
    gl.BindTextureUnit(0, mesh.texture);
    gl.BindVertexArray(mesh.vertex_array);
    gl.DrawElements(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr);
  }
}

// Whether nothing has moved by more than a texel since the map was drawn, as between a frame's exposures.
bool Renderer::State::has_shadows_of(const std::vector<Pose>& poses) const {
  if (!shadow_casters) return false;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose &drawn = (*shadow_casters)[i], &now = poses[i];
    const double turned_m =
        drawn.rotation.angularDistance(now.rotation) * 0.5 * objects[i].box.diagonal().norm();
    if ((now.translation - drawn.translation).norm() + turned_m > shadows->objects.texel_m) return false;
  }
  return true;
}

// Where a program that draws colour shall find the shadows at these poses.
void Renderer::State::cast_shadows(const ScenePoses& poses) {
  if (!shadows || has_shadows_of(poses.world_from_object)) return;
  shadow_casters = poses.world_from_object;
  draw_object_shadows(gl, *shadows, {world, world_from_static}, {objects, poses.world_from_object});
  gl.Viewport(0, 0, targets.width, targets.height);
}

void Renderer::State::draw_bodies(const Pass& pass, const ColorStep& step, bool silhouettes) const {
  const Pose camera_from_world = step.poses.world_from_camera.inverse();
  const Eigen::Vector3f sun = (camera_from_world.rotation * sun_direction).cast<float>();
  for (const unsigned program : {pass.matte, pass.shiny}) {
    gl.UseProgram(program);
    gl.Uniform3fv(uniform_sun_direction, 1, sun.data());
    if (shadows) use_shadow_maps(gl, *shadows, step.poses.world_from_camera);
  }
  // `world_from_body` tells where the body is at some poses of the scene.
  const auto place = [&](const auto& world_from_body) {
    const auto seen = [&](const ScenePoses& at) {
      return at.world_from_camera.inverse() * world_from_body(at);
    };
    const Pose middle = camera_from_world * world_from_body(step.poses);
    return step.edges ? Place{middle, seen((*step.edges)[0]), seen((*step.edges)[1])} : at_once(middle);
  };
  gl.Enable(GL_DEPTH_TEST);
  if (silhouettes) begin_silhouettes(gl);
  for (std::size_t i = 0; i < objects.size(); ++i) {  // first, so that they hide some of the world's pixels
    if (silhouettes) gl.StencilMask(silhouette_bit(i));
    draw_body(pass, objects[i],
              place([i](const ScenePoses& poses) { return poses.world_from_object.at(i); }));
  }
  gl.Disable(GL_STENCIL_TEST);
  for (std::size_t i = 0; i < world.size(); ++i)
    draw_body(pass, world[i], place([&](const ScenePoses&) { return world_from_static[i]; }));
}

// But its colour.
void Renderer::State::clear_image() const {
  constexpr float kNothing[4] = {0, 0, 0, 0};
  constexpr unsigned kNoId[4] = {0, 0, 0, 0};
  gl.BindFramebuffer(GL_FRAMEBUFFER, targets.image);
  gl.ClearBufferuiv(GL_COLOR, 1, kNoId);
  gl.ClearBufferfv(GL_COLOR, 2, kNothing);
  gl.StencilMask(0xff);
  gl.ClearBufferfi(GL_DEPTH_STENCIL, 0, 0, 0);  // together they are cleared in one go
}

// Ids and depth, which belong to pixel centres; in one pass colour looked up there too.
void Renderer::State::draw_image(const ScenePoses& poses, bool silhouettes) {
  if (one_pass) cast_shadows(poses);
  clear_image();
  if (one_pass) gl.ClearBufferfv(GL_COLOR, 0, sky.data());
  draw_bodies(one_pass ? all : geometry, {poses, {}}, silhouettes);
}

void Renderer::State::clear_depth(unsigned framebuffer) const {
  constexpr float kNothing[4] = {0, 0, 0, 0}, kFarthest = 0;
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  gl.ClearBufferfv(GL_COLOR, 2, kNothing);
  gl.ClearBufferfv(GL_DEPTH, 0, &kFarthest);
}

// What draw_image() makes of depth. Ids and stencil would cost a third more.
void Renderer::State::draw_depth(const ScenePoses& poses) const {
  clear_depth(targets.depth);
  draw_bodies(geometry, {poses, {}}, false);
}

// A depth sensor brings its own light: neither sun nor shadow counts, but what mirrors the sun blinds it.
// Only a lens needs ids.
void Renderer::State::draw_returned(const ScenePoses& poses) const {
  if (lens)
    clear_image();
  else
    clear_depth(targets.returned);
  gl.ClearBufferfv(GL_COLOR, 0, sky.data());
  draw_bodies(returned, {poses, {}}, false);
}

// A depth just behind the nearest surfaces, beyond which no colour needs to be made: it decides nothing else,
// and so the image is the same as without.
void Renderer::State::draw_hull(const ColorStep& step) const {
  gl.PolygonOffset(-kHullSlope, -kHullPlaces);
  gl.Enable(GL_POLYGON_OFFSET_FILL);
  draw_bodies(hull, step, false);
  gl.Disable(GL_POLYGON_OFFSET_FILL);
}

// Colour alone, each pixel the mean of its samples.
void Renderer::State::draw_color(const ColorStep& step) {
  constexpr float kFarthest = 0;
  cast_shadows(step.poses);
  gl.BindFramebuffer(GL_FRAMEBUFFER, targets.samples);
  gl.ClearBufferfv(GL_COLOR, 0, sky.data());
  gl.ClearBufferfv(GL_DEPTH, 0, &kFarthest);
  if (!is_multisampled) draw_hull(step);  // of several samples it costs what it saves
  draw_bodies(color, step, false);
  resolve_samples(gl, targets);
}

void Renderer::State::read_image_color(cv::Mat& rgba) {
  read_color(gl, targets, lens ? ideal_rgba : rgba);
  if (lens) see_color(*lens, ideal_rgba, rgba);
}

void Renderer::State::read_geometry(cv::Mat& ids, cv::Mat& depth_m) {
  read_ids(gl, targets, lens ? ideal_ids : ids);
  read_depth(gl, targets, lens ? ideal_m : depth_m);
  if (!lens) return;
  see_ids(*lens, ideal_ids, ids);
  see_depth(*lens, ideal_m, ideal_ids, depth_m);
}

// The mean of the steps' images, rounded.
void Renderer::State::expose(const std::vector<ColorStep>& steps) {
  sums.assign(frame.rgba.total() * frame.rgba.elemSize(), 0);
  for (const ColorStep& s : steps) {
    draw_color(s);
    read_image_color(exposed);
    for (std::size_t i = 0; i < sums.size(); ++i)
      sums[i] = static_cast<std::uint16_t>(sums[i] + exposed.data[i]);
  }
  divide_rounded(sums, static_cast<unsigned>(steps.size()), frame.rgba.data);
}

std::vector<ObjectView> Renderer::State::view_objects(const ScenePoses& poses, const cv::Mat& ids) {
  const Pose camera_from_world = poses.world_from_camera.inverse();
  std::vector<ObjectView> views;
  cv::Rect part;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    views.push_back({static_cast<int>(objects[i].id)});
    part |= pixels_of_box(objects[i].box, camera_from_world * poses.world_from_object[i], camera, kNear_m);
  }
  view_silhouettes(
      gl, targets, part,
      [&](std::size_t i) {
        draw_body(geometry, objects[i], at_once(camera_from_world * poses.world_from_object[i]));
      },
      lens ? &*lens : nullptr, bits, views);
  count_visible(ids, views);
  return views;
}

Renderer::Renderer(const Scene& scene, GlLibrary library) : state_(std::make_unique<State>()) {
  check_can_render(scene);
  State& s = *state_;
  s.context = make_gl_context(library);
  s.context->make_current();
  s.gl = load_gl_functions(*s.context);
  if (scene.camera.has_distortion()) s.lens = make_lens(scene.camera);
  s.camera = s.lens ? s.lens->ideal : scene.camera;
  const int samples = s.lens ? 1 : scene.imaging.samples;  // a lens takes the mean of four pixels
  s.targets = make_render_targets(s.gl, s.camera.width, s.camera.height, samples > 1 ? samples : 0);
  s.one_pass = samples == 1 && color_steps(scene, 0).empty();
  s.is_multisampled = samples > 1;
  const auto pass = [&](ProgramOutput output, const Light& light) {
    return make_pass(s.gl, scene, s.camera, s.lens ? &*s.lens : nullptr, output, light);
  };
  const Light sunlight{scene.shadows, scene.ambient, drawn_gain(scene.imaging)};
  s.geometry = pass(ProgramOutput::geometry, sunlight);
  if (s.one_pass) s.all = pass(ProgramOutput::all, sunlight);
  if (!s.one_pass) s.color = pass(ProgramOutput::color, sunlight);
  if (!s.one_pass && !s.is_multisampled) s.hull = pass(ProgramOutput::none, sunlight);
  if (scene.depth_noise.delay_s > 0 && has_faint_surface(scene)) s.returned = pass(ProgramOutput::all, {});
  s.gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  s.gl.DepthFunc(GL_GREATER);
  s.gl.FrontFace(GL_CW);  // rows run down here, up in OpenGL: what is counter-clockwise turns
  s.upload(scene);
  s.gl.Viewport(0, 0, s.targets.width, s.targets.height);
  check_gl(s.gl, "preparing to draw");
}

Renderer::~Renderer() = default;

void Renderer::draw(const ScenePoses& poses) {
  State& s = *state_;
  s.context->make_current();
  s.shadow_casters.reset();
  s.draw_image(poses, false);
  if (!s.one_pass) s.draw_color({poses, {}});
}

cv::Mat Renderer::depth_m(const ScenePoses& poses) {
  State& s = *state_;
  s.context->make_current();
  cv::Mat ids, depth_m;
  if (s.lens) {
    s.draw_image(poses, false);
    s.read_geometry(ids, depth_m);
  } else {
    s.draw_depth(poses);
    read_depth(s.gl, s.targets, depth_m);
  }
  return depth_m;
}

const RenderedFrame& Renderer::returned(const ScenePoses& poses) {
  State& s = *state_;
  assert(s.returned.matte);
  s.context->make_current();
  s.draw_returned(poses);
  s.read_image_color(s.late.rgba);
  s.lens ? s.read_geometry(s.late.ids, s.late.depth_m) : read_depth(s.gl, s.targets, s.late.depth_m);
  return s.late;
}

std::string Renderer::device() const {
  state_->context->make_current();
  return reinterpret_cast<const char*>(state_->gl.GetString(GL_RENDERER));
}

void Renderer::read_back(cv::Mat& rgba, cv::Mat& ids, cv::Mat& depth_m) {
  State& s = *state_;
  s.context->make_current();
  s.read_image_color(rgba);
  s.read_geometry(ids, depth_m);
  check_gl(s.gl, "drawing");
}

const RenderedFrame& Renderer::render(const ScenePoses& poses, const std::vector<ColorStep>& steps) {
  State& s = *state_;
  s.context->make_current();
  s.shadow_casters.reset();  // images do not depend on what was drawn before
  s.draw_image(poses, true);
  if (!s.one_pass && steps.empty()) s.draw_color({poses, {}});
  read_back(s.frame.rgba, s.frame.ids, s.frame.depth_m);
  if (!steps.empty()) s.expose(steps);
  s.frame.objects = s.view_objects(poses, s.frame.ids);
  return s.frame;
}

}  // namespace uniquadric
