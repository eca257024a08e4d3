#include "evaluation/report/overlay.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/calibration.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "evaluation/report/absence.h"
#include "evaluation/report/drawing.h"
#include "evaluation/report/jpeg.h"
#include "evaluation/report/outline.h"
#include "evaluation/report/page.h"
#include "evaluation/report/svg_colours.h"
#include "evaluation/run_record.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kWidth_px = 640;
constexpr int kTrue_px = 5, kEstimated_px = 2;  // of outlines: the estimated one on the true one shows both
constexpr int kWithin_px = 3;                   // of the ellipsoid within a true body
constexpr double kNoteHeight_px = 18;
constexpr int kCasing_px = 7;  // of a white outline, so that it shows on white, too
const cv::Scalar kTextColor(255, 255, 255), kCasingColor(0, 0, 0);

struct Colors {
  cv::Scalar truth{80, 220, 60}, estimate{0, 140, 255}, box{60, 220, 255};  // blue, green, red
  bool is_cased = false;
};

// As the report has them: the truth white, the estimate and its box in the variant's colour.
Colors colors_of(const std::string& hex) {
  if (hex.empty()) return {};
  const auto rgb = rgb_of(hex);
  if (!rgb) throw InputError(fmt::format("'{}' is no colour such as #0072b2", hex));
  const cv::Scalar color(rgb->blue, rgb->green, rgb->red);
  return {{255, 255, 255}, color, color, true};
}

enum class Whose { truth, estimate };

// Names of the truth stand above the outline, of the estimate below.
void draw_name(Canvas& canvas, const std::string& name, const std::vector<Eigen::Vector2d>& outline,
               Whose whose, const cv::Scalar& color) {
  Eigen::AlignedBox2d bounds;
  for (const Eigen::Vector2d& p : outline) bounds.extend(p);
  const double middle = bounds.center().x();
  const cv::Point2d at = whose == Whose::truth ? canvas.at({middle, bounds.min().y()}) + cv::Point2d(0, -6)
                                               : canvas.at({middle, bounds.max().y()}) + cv::Point2d(0, 16);
  draw_label(canvas, name, at, color);
}

void draw_object(Canvas& canvas, const ObjectTrack& track, const ObjectState& state,
                 const Pose& camera_from_world, Whose whose, const Colors& colors) {
  const Pose camera_from_object = camera_from_world * state.ellipsoid.world_from_object;
  const Eigen::Vector3d& semi_axes_m = state.ellipsoid.semi_axes_m;
  const bool is_truth = whose == Whose::truth;
  const cv::Scalar& color = is_truth ? colors.truth : colors.estimate;
  const bool is_box = state.exponents == SuperExponents{1, 1, 1};
  if (!is_truth || is_box)
    draw_box(canvas, camera_from_object, semi_axes_m, is_truth ? colors.truth : colors.box, 1);
  const auto outline = superellipsoid_outline(canvas.camera, camera_from_object,
                                              {semi_axes_m, state.exponents, state.profile_axis});
  if (outline.empty()) return;
  if (is_truth && colors.is_cased) draw_polygon(canvas, outline, kCasingColor, kCasing_px);
  draw_polygon(canvas, outline, color, is_truth ? kTrue_px : kEstimated_px);
  const EllipseProjection ellipse = project(canvas.camera, camera_from_object, semi_axes_m);
  if (!is_truth && state.exponents == SuperExponents{} && ellipse.status == ProjectionStatus::ok)
    draw_rectangle(canvas, ellipse.ellipse, color, 1);
  const bool is_occluded = state.status == ObjectStatus::occluded;
  draw_name(canvas, label_of(track) + (is_occluded ? " (occluded)" : ""), outline, whose, color);
}

void draw_tracks(Canvas& canvas, const Tracks& tracks, std::int64_t stamp_ns, Whose whose,
                 const Colors& colors) {
  const Pose* camera = camera_pose_at(tracks.camera, stamp_ns);
  if (!camera) return;
  for (const ObjectTrack& track : tracks.objects)
    if (const ObjectState* state = state_at(track, stamp_ns))
      draw_object(canvas, track, *state, camera->inverse(), whose, colors);
}

bool has_superellipsoids(const Tracks& tracks) {
  for (const ObjectTrack& track : tracks.objects)
    for (const ObjectState& state : track.states)
      if (state.exponents != SuperExponents{}) return true;
  return false;
}

// What has no formula, as a car or a mesh, is shown as its tight box.
SuperExponents exponents_of(const std::string& shape) {
  if (shape == "ball" || shape == "ellipsoid") return {};
  if (shape == "cylinder") return {2, 1, 1};
  return {1, 1, 1};
}

Tracks read_truth(const fs::path& folder) {
  if (folder.empty()) return {};
  Tracks truth = read_tracks(folder);
  if (!fs::exists(folder / "objects.yaml")) return truth;
  for (const ObjectDescription& object : read_objects_yaml(folder / "objects.yaml"))
    for (ObjectTrack& track : truth.objects)
      if (track.id == object.id)
        for (ObjectState& state : track.states) state.exponents = exponents_of(object.shape);
  return truth;
}

// Beside estimated ellipsoids the ones within the true bodies, which they are compared with.
void draw_ellipsoids_within(Canvas& canvas, const Tracks& truth, std::int64_t stamp_ns,
                            const Colors& colors) {
  const Pose* camera = camera_pose_at(truth.camera, stamp_ns);
  if (!camera) return;
  for (const ObjectTrack& track : truth.objects) {
    const ObjectState* state = state_at(track, stamp_ns);
    if (!state || state->exponents == SuperExponents{}) continue;
    const auto outline =
        superellipsoid_outline(canvas.camera, camera->inverse() * state->ellipsoid.world_from_object,
                               {state->ellipsoid.semi_axes_m, {}, 2});
    if (!outline.empty()) draw_polygon(canvas, outline, colors.truth, kWithin_px);
  }
}

// One below the other in the upper left corner.
void draw_notes(Canvas& canvas, const std::vector<std::string>& notes) {
  constexpr std::size_t kMost = 8;
  double y_px = 14;  // the first baseline
  const auto draw = [&](const std::string& text) {
    draw_label(canvas, text, {0, y_px}, kTextColor);
    y_px += kNoteHeight_px;
  };
  for (std::size_t i = 0; i < std::min(notes.size(), kMost); ++i) draw(notes[i]);
  if (notes.size() > kMost) draw(fmt::format("... and {} more", notes.size() - kMost));
}

void require_same_scene(const Sequence& sequence, const fs::path& truth, const fs::path& estimate) {
  const SceneClaim of_sequence{sequence.folder, sequence.scene_hash},
      of_estimate{estimate, scene_of(estimate)};
  require_one_scene(of_sequence, of_estimate);
  if (truth.empty()) return;
  const SceneClaim of_truth{truth, scene_of(truth)};
  require_one_scene(of_sequence, of_truth);
  require_one_scene(of_truth, of_estimate);
}

// The estimate's own masks, else the sequence's; empty where a frame has none.
cv::Mat find_masks(const Sequence& sequence, const SequenceFrame& frame, const fs::path& estimate) {
  const fs::path own = estimate / "masks" / fmt::format("{:06}.png", frame.frame);
  if (!fs::exists(own)) return frame.masks.empty() ? cv::Mat() : read_masks(sequence, frame);
  const cv::Mat masks = read_image(own);
  if (masks.type() != CV_16UC1) throw InputError(own, "expected a 16-bit image of one channel");
  if (masks.cols != sequence.camera.width || masks.rows != sequence.camera.height)
    throw InputError(own, fmt::format("is {}x{}, the camera says {}x{}", masks.cols, masks.rows,
                                      sequence.camera.width, sequence.camera.height));
  return masks;
}

}  // namespace

void write_overlays(const fs::path& sequence_folder, const fs::path& truth_folder,
                    const fs::path& estimate_folder, const fs::path& out, int count, bool force,
                    const std::string& color) {
  const Colors colors = colors_of(color);
  const Sequence sequence = open_sequence(sequence_folder);
  if (sequence.frames.empty()) throw InputError(sequence_folder, "has no images to draw in");
  require_same_scene(sequence, truth_folder, estimate_folder);
  const Tracks estimate = read_tracks(estimate_folder);
  const Tracks truth = read_truth(truth_folder);
  const bool ellipsoids_alone = !has_superellipsoids(estimate);
  const fs::path visibility_file = truth_folder / "instances/visibility.csv";
  const VisibilityTable visibility = !truth_folder.empty() && fs::exists(visibility_file)
                                         ? read_visibility(visibility_file)
                                         : VisibilityTable{};
  const std::size_t n = std::min(sequence.frames.size(), static_cast<std::size_t>(std::max(count, 0)));
  PendingFolder folder(out, "overlays", force);
  for (const std::size_t i : evenly_spaced(sequence.frames.size(), n)) {
    const SequenceFrame& frame = sequence.frames[i];
    Canvas canvas = make_canvas(read_rgb(sequence, frame), sequence.camera, kWidth_px);
    const cv::Mat masks = find_masks(sequence, frame, estimate_folder);
    if (!masks.empty()) tint_masks(canvas, masks);
    draw_tracks(canvas, truth, frame.stamp_ns, Whose::truth, colors);
    if (ellipsoids_alone) draw_ellipsoids_within(canvas, truth, frame.stamp_ns, colors);
    draw_tracks(canvas, estimate, frame.stamp_ns, Whose::estimate, colors);
    std::vector<std::string> notes =
        absence_notes(estimate, masks, frame.frame, frame.stamp_ns, truth, visibility);
    notes.insert(notes.begin(), fmt::format("frame {}", frame.frame));
    draw_notes(canvas, notes);
    write_jpeg(folder.path() / fmt::format("{:06}.jpg", frame.frame), canvas.image);
  }
  if (n > 0) write_contact_sheet(folder.path(), folder.path() / "sheet.jpg");
  folder.commit();
}

}  // namespace uniquadric
