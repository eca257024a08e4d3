#include "drawn_sequence.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {

const Sprite kRed{1,        11, {50, 60, 180},
                  {70, 50}, 2,  [](std::int64_t n) {
                                  return Eigen::Vector2d(60 + 2.0 * double(n), 80); }};

Sequence write_drawn_sequence(const fs::path& folder, const std::vector<Sprite>& sprites, int frames,
                              const Damage& damage, const Camera& camera) {
  for (const char* name : {"rgb", "depth", "masks"}) fs::create_directories(folder / name);
  Sequence sequence;
  sequence.folder = folder;
  sequence.name = "drawn";
  sequence.camera = camera;
  sequence.rate_hz = 30;
  sequence.given_camera.emplace();
  for (int n = 0; n < frames; ++n) {
    DrawnFrame drawn = draw_world(sprites, n);
    if (damage) damage(drawn);
    cv::Mat depth;
    drawn.depth.convertTo(depth, CV_16U, sequence.depth_units_per_m);
    const std::string file = fmt::format("{:06}.png", n);
    SequenceFrame& frame = drawn.frame;
    write_png(folder / (frame.rgb = fs::path("rgb") / file), drawn.rgb);
    write_png(folder / (frame.depth = fs::path("depth") / file), depth);
    write_png(folder / (frame.masks = fs::path("masks") / file), drawn.masks);
    frame.masks_arrival_ns = draw_world({}, n + kLatencyFrames).frame.stamp_ns;
    sequence.frames.push_back(frame);
    sequence.given_camera->push_back({frame.stamp_ns, Pose{}});
  }
  write_sequence_index(folder, sequence);
  return sequence;
}

Variant windows(EgoSource ego) {
  Variant variant;
  variant.backend = Backend::windows;
  variant.perception.ego = ego;
  return variant;
}

Perception perceived(const Sequence& sequence, const PerceptionOptions& options, const char* name) {
  PerceiveOptions quiet;
  quiet.quiet = true;
  std::vector<StageTime> times;
  const fs::path folder = sequence.folder / name;
  fs::create_directories(folder);
  PerceptionWriter out(folder, perception_camera(sequence, options), {});
  perceive(sequence, options, quiet, out, times);
  return Perception(folder);
}

Outcome run(const fs::path& folder, int threads, const Variant& variant) {
  const TempFolder temp;
  EstimateOptions options;
  options.quiet = true;
  options.threads = threads;
  estimate(folder, variant, options, temp.path() / "out");
  Outcome outcome{read_tracks(temp.path() / "out"), {}};
  for (const auto& entry : fs::recursive_directory_iterator(temp.path() / "out"))
    if (entry.is_regular_file() && entry.path().filename() != "timing.csv" &&
        entry.path().filename() != "usage.csv")
      outcome.files[fs::relative(entry.path(), temp.path()).string()] = read_text(entry.path());
  return outcome;
}

void expect_sane(const Tracks& tracks) {
  for (const ObjectTrack& track : tracks.objects)
    for (const ObjectState& state : track.states) {
      const Ellipsoid& e = state.ellipsoid;
      EXPECT_TRUE(e.world_from_object.translation.allFinite() && e.semi_axes_m.allFinite()) << state.frame;
      EXPECT_GT(e.semi_axes_m.minCoeff(), 0) << state.frame;
      EXPECT_LT(e.semi_axes_m.maxCoeff(), 5) << state.frame;
    }
}

}  // namespace uniquadric
