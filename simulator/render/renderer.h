#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/pose.h"
#include "simulator/render/gl_context.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// Where everything that moves is at one time.
struct ScenePoses {
  Pose world_from_camera;               ///< optical frame
  std::vector<Pose> world_from_object;  ///< one an object, in the scene's order
};
ScenePoses poses_at(const Scene& scene, double time_s);

/// How much of one object the camera sees.
struct ObjectView {
  int id = 0;
  std::int64_t visible_px = 0;     ///< pixels whose nearest surface is the object's
  std::int64_t silhouette_px = 0;  ///< pixels inside the image that it would cover if nothing stood before it
  bool touches_border = false;     ///< that silhouette reaches the image's outermost row or column

  /// Share of the silhouette inside the image that no other body hides; 0 when there is none. What lies
  /// outside the image counts as neither: see touches_border.
  double visible_fraction() const;
};

struct RenderedFrame {
  cv::Mat rgba;  ///< 8UC4, made as scene.imaging says. Fourth channel: share of a depth sensor's light that
                 ///< returns, 255 all; 0 where nothing is
  cv::Mat ids;   ///< 16UC1: the object's id, 0 for the world and where nothing is
  cv::Mat depth_m;                  ///< 32FC1: z along the optical axis [m], 0 where nothing is
  cv::Mat returning_rgba;           ///< Renderer::returned, where depth comes late; empty: rgba
  std::vector<ObjectView> objects;  ///< in the scene's order
};

/// One of the images whose mean is the colour image.
struct ColorStep {
  ScenePoses poses;  ///< when the middle row is exposed
  /// Of a rolling shutter: when the image's upper and lower edge are exposed.
  std::optional<std::array<ScenePoses, 2>> edges;
};
/// The steps of a frame: the middles of the steps of exposure_s. Empty when neither that nor the rolling
/// shutter takes time.
std::vector<ColorStep> color_steps(const Scene& scene, double time_s);

/// Throws InputError when the camera's lens distortion cannot be drawn (lens_fault), or when an object's id
/// is outside 1..65535 or stands twice.
void check_can_render(const Scene& scene);

/// Draws a scene off screen. Pixel centres lie at integer coordinates: the value of pixel (u, v) is what the
/// ray through (u, v) meets, so that it agrees with Camera::project. With lens distortion this holds to a
/// quarter of a pixel at edges (Lens). Surfaces nearer than 1 cm are not drawn.
/// Images do not depend on the time, the thread or what was drawn before. A renderer may be used by one
/// thread at a time; renderers of several threads work at the same time.
class Renderer {
 public:
  /// Copies the scene's meshes; checks the scene first (check_can_render).
  explicit Renderer(const Scene& scene, GlLibrary library = GlLibrary::automatic);
  ~Renderer();

  /// The frame is the renderer's own, until the next call. Ids, depth and objects are those of `poses`, and
  /// the colour too unless there are `steps`, which make it then.
  const RenderedFrame& render(const ScenePoses& poses, const std::vector<ColorStep>& steps = {});

  /// The depth alone, as RenderedFrame has it.
  cv::Mat depth_m(const ScenePoses& poses);

  /// Depth, and as colour what surfaces return of a depth sensor's own light: their own colour whatever the
  /// sun does, beside the fourth channel. For scenes with faint surfaces whose depth comes late
  /// (has_faint_surface, DepthNoise::delay_s). The images are the renderer's own, until the next call.
  const RenderedFrame& returned(const ScenePoses& poses);

  /// What draws, in the words of OpenGL: "llvmpipe (LLVM ...)" or a graphics card.
  std::string device() const;

  /// The steps of render(), apart, for measurements: draws colour, ids and depth;
  void draw(const ScenePoses& poses);
  /// copies them into images that are reused.
  void read_back(cv::Mat& rgba, cv::Mat& ids, cv::Mat& depth_m);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace uniquadric
