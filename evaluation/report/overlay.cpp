#include "evaluation/report/overlay.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "evaluation/report/absence.h"
#include "evaluation/report/drawing.h"
#include "evaluation/report/jpeg.h"
#include "evaluation/report/page.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kWidth_px = 640;
constexpr int kOutline_px = 2;
constexpr double kNoteHeight_px = 18;
const cv::Scalar kTrueColor(80, 220, 60), kEstimatedColor(0, 140, 255), kBoxColor(60, 220, 255),
    kTextColor(255, 255, 255);

enum class Whose { truth, estimate };

void draw_object(Canvas& canvas, const ObjectTrack& track, const ObjectState& state,
                 const Pose& camera_from_world, Whose whose) {
  const Pose camera_from_object = camera_from_world * state.ellipsoid.world_from_object;
  const bool is_truth = whose == Whose::truth;
  const cv::Scalar& color = is_truth ? kTrueColor : kEstimatedColor;
  if (!is_truth) draw_box(canvas, camera_from_object, state.ellipsoid.semi_axes_m, kBoxColor, 1);
  const EllipseProjection projection =
      project(canvas.camera, camera_from_object, state.ellipsoid.semi_axes_m);
  if (projection.status != ProjectionStatus::ok) return;
  const Ellipse& e = projection.ellipse;
  draw_ellipse(canvas, e, color, kOutline_px);
  if (!is_truth) draw_rectangle(canvas, e, color, 1);
  // True names stand above the outline, estimated ones below.
  const double half_height_px =
      std::hypot(e.semi_major * std::sin(e.angle_rad), e.semi_minor * std::cos(e.angle_rad));
  const cv::Point2d at = is_truth
                             ? canvas.at(e.center - Eigen::Vector2d(0, half_height_px)) + cv::Point2d(0, -6)
                             : canvas.at(e.center + Eigen::Vector2d(0, half_height_px)) + cv::Point2d(0, 16);
  const bool is_occluded = state.status == ObjectStatus::occluded;
  draw_label(canvas, label_of(track) + (is_occluded ? " (occluded)" : ""), at, color);
}

void draw_tracks(Canvas& canvas, const Tracks& tracks, std::int64_t stamp_ns, Whose whose) {
  const Pose* camera = camera_pose_at(tracks.camera, stamp_ns);
  if (!camera) return;
  for (const ObjectTrack& track : tracks.objects)
    if (const ObjectState* state = state_at(track, stamp_ns))
      draw_object(canvas, track, *state, camera->inverse(), whose);
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
                    const fs::path& estimate_folder, const fs::path& out, int count, bool force) {
  const Sequence sequence = open_sequence(sequence_folder);
  const Tracks estimate = read_tracks(estimate_folder);
  const Tracks truth = truth_folder.empty() ? Tracks{} : read_tracks(truth_folder);
  const fs::path visibility_file = truth_folder / "instances/visibility.csv";
  const VisibilityTable visibility = !truth_folder.empty() && fs::exists(visibility_file)
                                         ? read_visibility(visibility_file)
                                         : VisibilityTable{};
  const std::size_t n = std::min(sequence.frames.size(), static_cast<std::size_t>(std::max(count, 0)));
  PendingFolder folder(out, force);
  for (const std::size_t i : evenly_spaced(sequence.frames.size(), n)) {
    const SequenceFrame& frame = sequence.frames[i];
    Canvas canvas = make_canvas(read_rgb(sequence, frame), sequence.camera, kWidth_px);
    const cv::Mat masks = find_masks(sequence, frame, estimate_folder);
    if (!masks.empty()) tint_masks(canvas, masks);
    draw_tracks(canvas, truth, frame.stamp_ns, Whose::truth);
    draw_tracks(canvas, estimate, frame.stamp_ns, Whose::estimate);
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
