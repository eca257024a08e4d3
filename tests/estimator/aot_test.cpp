// The asynchronous tracker on drawn worlds, whose masks are known.
#include "estimator/mask_tracking/aot.h"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <set>
#include <thread>

#include "drawn_world.h"

namespace uniquadric {
namespace {

constexpr std::int64_t kLatency_ns = 100'000'000;  // three frames
using Kept = std::function<bool(std::int64_t frame, int id)>;

const Sprite kRed{
    1,        11, {50, 60, 180},
    {70, 50}, 2,  [](std::int64_t n) {
                    return Eigen::Vector2d(30 + 2.0 * double(n), 80 + 0.5 * double(n)); }};
const Sprite kBlue{
    2,        12,  {190, 90, 40},
    {50, 60}, 2.5, [](std::int64_t n) {
                     return Eigen::Vector2d(230 - 2.0 * double(n), 90.0); }};

// A segmenter with the true masks of a world, under labels that are others in each frame; `finds` says which
// bodies it does not miss.
SlowSegmenter perfect_segmenter(const std::vector<Sprite>& sprites, std::int64_t latency_ns = kLatency_ns,
                                const Kept& finds = {}) {
  SlowSegmenter segmenter;
  segmenter.latency_ns = [=](const SequenceFrame&) { return latency_ns; };
  segmenter.segment = [=](const SegmenterInput& input) {
    cv::Mat masks = draw_world(sprites, input.frame.frame).masks;
    for (auto& id : cv::Mat_<std::uint16_t>(masks)) {
      if (id == 0) continue;
      const bool found = !finds || finds(input.frame.frame, id);
      id = static_cast<std::uint16_t>(found ? 1 + (id * 7 + input.frame.frame * 3) % 11 : 0);
    }
    return masks;
  };
  return segmenter;
}

struct History {
  std::vector<AotFrame> frames;
  std::vector<DrawnFrame> truth;
};

History run(const std::vector<Sprite>& sprites, int frames, SlowSegmenter segmenter,
            const AotOptions& options = {}) {
  AsyncObjectTracker tracker(drawn_camera(), std::move(segmenter), options);
  History result;
  for (int n = 0; n < frames; ++n) {
    result.truth.push_back(draw_world(sprites, n));
    const DrawnFrame& drawn = result.truth.back();
    result.frames.push_back(tracker.track(drawn.frame, drawn.rgb, drawn.depth));
  }
  return result;
}

// The track that covers most of a body's mask; 0 for none.
int track_of(const History& run, std::size_t frame, int id) {
  std::map<int, int> pixels;
  const cv::Mat &truth = run.truth[frame].masks, &tracked = run.frames[frame].masks;
  for (int v = 0; v < truth.rows; ++v)
    for (int u = 0; u < truth.cols; ++u)
      if (truth.at<std::uint16_t>(v, u) == id) ++pixels[tracked.at<std::uint16_t>(v, u)];
  int best = 0, most = 0;
  for (const auto& [track, count] : pixels)
    if (count > most) most = count, best = track;
  return best;
}

double iou_of(const History& run, std::size_t frame, int id, int track) {
  return mask_iou(run.truth[frame].masks == id, run.frames[frame].masks == track);
}

TEST(Aot, KeyframesAndArrivalsFollowTheLatency) {
  const History result = run({kRed}, 12, perfect_segmenter({kRed}));
  int arrivals = 0;
  for (std::size_t n = 0; n < result.frames.size(); ++n) {
    const auto& arrived = result.frames[n].arrived;
    ASSERT_EQ(arrived.size(), n > 0 && n % 3 == 0 ? 1u : 0u) << n;
    if (arrived.empty()) continue;
    EXPECT_EQ(arrived[0].frame, static_cast<std::int64_t>(n) - 3);
    EXPECT_GT(mask_iou(arrived[0].masks != 0, result.truth[n - 3].masks != 0), 0.999);
    ++arrivals;
  }
  EXPECT_EQ(arrivals, 3);
  for (int n = 0; n < 3; ++n) EXPECT_EQ(cv::countNonZero(result.frames[n].masks), 0);
}

// A result that comes between two frames frees the segmenter for the newest frame there was then.
TEST(Aot, AFreedSegmenterTakesTheFrameThatWaits) {
  const History result = run({kRed}, 12, perfect_segmenter({kRed}, 50'000'000));  // one frame and a half
  std::vector<std::pair<std::int64_t, std::int64_t>> arrivals;                    // at, of
  for (std::size_t n = 0; n < result.frames.size(); ++n)
    for (const auto& arrived : result.frames[n].arrived) arrivals.emplace_back(n, arrived.frame);
  // Frame 0 is done at 1.5 frames, then frame 1 until 3.0, then frame 3 until 4.5, frame 4 until 6.0, ...
  const std::vector<std::pair<std::int64_t, std::int64_t>> expected = {{2, 0}, {3, 1}, {5, 3}, {6, 4},
                                                                       {8, 6}, {9, 7}, {11, 9}};
  EXPECT_EQ(arrivals, expected);
}

TEST(Aot, MasksFollowMovingBodiesBetweenResults) {
  const std::vector<Sprite> world = {kRed, kBlue};
  const History result = run(world, 20, perfect_segmenter(world));
  int checked = 0;
  for (std::size_t n = 4; n < 20; ++n)
    for (const int id : {1, 2}) {
      EXPECT_GT(iou_of(result, n, id, track_of(result, n, id)), 0.97) << n << " " << id;
      ++checked;
    }
  EXPECT_EQ(checked, 32);
}

// Without depth masks are carried by flow alone.
TEST(Aot, MasksFollowWithoutDepth) {
  AotOptions options;
  options.flow.flow.downscale = 1;  // these images are small
  AsyncObjectTracker tracker(drawn_camera(), perfect_segmenter({kRed}), options);
  for (int n = 0; n < 16; ++n) {
    const DrawnFrame drawn = draw_world({kRed}, n);
    const AotFrame result = tracker.track(drawn.frame, drawn.rgb, {});
    if (n >= 4) {
      EXPECT_GT(mask_iou(result.masks != 0, drawn.masks != 0), 0.75) << n;
    }
  }
}

TEST(Aot, IdsStayThroughACrossing) {
  const std::vector<Sprite> world = {kRed, kBlue};  // red passes in front of blue and hides most of it
  const History result = run(world, 75, perfect_segmenter(world));
  std::set<int> red, blue;
  for (std::size_t n = 4; n < 75; ++n) {
    if (cv::countNonZero(result.truth[n].masks == 1) > 500) red.insert(track_of(result, n, 1));
    if (cv::countNonZero(result.truth[n].masks == 2) > 1500) blue.insert(track_of(result, n, 2));
  }
  EXPECT_EQ(red.size(), 1u);
  EXPECT_EQ(blue.size(), 1u);
  EXPECT_NE(red, blue);
}

// Red is hidden for a second behind a pillar that no one segments.
TEST(Aot, ABodyThatWasHiddenKeepsItsId) {
  const Sprite pillar{9,          13,  {90, 140, 90},
                      {130, 240}, 1.2, [](std::int64_t) { return Eigen::Vector2d(100, 0); }};
  const std::vector<Sprite> world = {kRed, pillar};
  const Kept not_pillar = [](std::int64_t, int id) { return id != 9; };
  const History result = run(world, 100, perfect_segmenter(world, kLatency_ns, not_pillar));
  std::set<int> tracks;
  int hidden = 0, seen_after = 0;
  for (std::size_t n = 4; n < 100; ++n) {
    const int pixels = cv::countNonZero(result.truth[n].masks == 1);
    hidden += pixels == 0;
    if (pixels > 2000) {
      tracks.insert(track_of(result, n, 1));
      seen_after += hidden > 0;
    }
  }
  EXPECT_GT(hidden, 25);
  EXPECT_GT(seen_after, 5);
  EXPECT_EQ(tracks.size(), 1u);
  EXPECT_FALSE(tracks.contains(0));
}

// Two that look the same, at other distances, pass each other behind the pillar: each goes on.
TEST(Aot, TwinsThatPassEachOtherInHidingKeepTheirIds) {
  const Sprite pillar{9,          13,  {90, 140, 90},
                      {100, 240}, 1.2, [](std::int64_t) { return Eigen::Vector2d(110, 0); }};
  Sprite left = kRed, right = kRed;
  right.id = 2;
  right.depth_m = 2.4;
  left.corner_px = [](std::int64_t n) { return Eigen::Vector2d(10 + 2.0 * double(n), 90); };
  right.corner_px = [](std::int64_t n) { return Eigen::Vector2d(240 - 2.0 * double(n), 90); };
  const std::vector<Sprite> world = {left, right, pillar};
  const Kept not_pillar = [](std::int64_t, int id) { return id != 9; };
  const History result = run(world, 120, perfect_segmenter(world, kLatency_ns, not_pillar));
  for (const int id : {1, 2}) {
    EXPECT_NE(track_of(result, 10, id), 0);
    EXPECT_EQ(track_of(result, 119, id), track_of(result, 10, id)) << id;
  }
}

// Blue goes behind the pillar and a body of other colours comes out: another id.
TEST(Aot, ABodyOfOtherColoursIsANewOne) {
  const Sprite pillar{9,          13,  {90, 140, 90},
                      {130, 240}, 1.2, [](std::int64_t) { return Eigen::Vector2d(100, 0); }};
  Sprite other = kBlue;
  other.id = 3;
  other.texture = 14;
  other.color = {60, 190, 210};
  const auto at = [&](std::int64_t n) {
    return n < 45 ? std::vector{kBlue, pillar} : std::vector{other, pillar};
  };
  SlowSegmenter segmenter = perfect_segmenter({});
  segmenter.segment = [&](const SegmenterInput& input) {
    cv::Mat masks = draw_world(at(input.frame.frame), input.frame.frame).masks;
    masks.setTo(0, masks == 9);
    return masks;
  };
  AsyncObjectTracker tracker(drawn_camera(), segmenter, {});
  History result;
  for (int n = 0; n < 100; ++n) {
    result.truth.push_back(draw_world(at(n), n));
    result.frames.push_back(tracker.track(result.truth[n].frame, result.truth[n].rgb, result.truth[n].depth));
  }
  const int before = track_of(result, 20, 2), after = track_of(result, 99, 3);
  EXPECT_NE(before, 0);
  EXPECT_NE(after, 0);
  EXPECT_NE(before, after);
}

TEST(Aot, ABodyThatOneResultMissesIsCarriedOn) {
  const Kept misses_one = [](std::int64_t frame, int) { return frame != 9; };
  const History result = run({kRed}, 24, perfect_segmenter({kRed}, kLatency_ns, misses_one));
  for (std::size_t n = 4; n < 24; ++n) EXPECT_GT(iou_of(result, n, 1, 1), 0.95) << n;
  const Kept misses_all = [](std::int64_t frame, int) { return frame < 9; };
  const History gone = run({kRed}, 30, perfect_segmenter({kRed}, kLatency_ns, misses_all));
  EXPECT_EQ(cv::countNonZero(gone.frames.back().masks), 0);
}

// A body that is gone from one frame to the next leaves no mask on what is seen in its place.
TEST(Aot, ABodyThatIsGoneLeavesNoMaskOnTheWall) {
  Sprite leaving = kRed;
  leaving.corner_px = [](std::int64_t n) { return Eigen::Vector2d(n < 10 ? 100 : 1000, 80); };
  const History result = run({leaving}, 14, perfect_segmenter({leaving}));
  EXPECT_GT(cv::countNonZero(result.frames[9].masks), 3000);
  for (std::size_t n = 10; n < 14; ++n) EXPECT_EQ(cv::countNonZero(result.frames[n].masks), 0) << n;
}

// Between frames that are far apart there is time for a result, and nothing that flow could carry.
TEST(Aot, OfFramesFarApartEachHasItsOwnMasks) {
  const auto at = [](int n) {
    DrawnFrame drawn = draw_world({kRed}, 12 * n);
    drawn.frame.frame = n;
    return drawn;
  };
  SlowSegmenter segmenter = perfect_segmenter({});
  segmenter.segment = [&](const SegmenterInput& input) {
    return input.frame.frame == 3 ? cv::Mat() : at(static_cast<int>(input.frame.frame)).masks;
  };
  AsyncObjectTracker tracker(drawn_camera(), segmenter, {});
  for (int n = 0; n < 6; ++n) {
    const DrawnFrame drawn = at(n);
    const AotFrame result = tracker.track(drawn.frame, drawn.rgb, drawn.depth, at(n + 1).frame.stamp_ns);
    ASSERT_EQ(result.arrived.size(), n == 3 ? 0u : 1u) << n;
    EXPECT_EQ(result.has_masks, n != 3);
    EXPECT_GT(mask_iou(result.masks == 1, n == 3 ? cv::Mat(drawn.masks == 7) : drawn.masks == 1), 0.99) << n;
    if (n != 3) {
      EXPECT_EQ(result.arrived[0].frame, n);
    }
  }
}

TEST(Aot, WithoutNewResultsMasksAreGivenUpAndSaidToBeMissing) {
  SlowSegmenter segmenter = perfect_segmenter({kRed});
  segmenter.latency_ns = [](const SequenceFrame& frame) {
    return frame.frame < 6 ? std::optional(kLatency_ns) : std::nullopt;
  };
  AotOptions options;
  options.max_silence_s = 0.31;  // nine frames after the last result, which is there at frame 6
  const History result = run({kRed}, 20, segmenter, options);
  for (std::size_t n = 0; n < 20; ++n) {
    EXPECT_EQ(result.frames[n].has_masks, n >= 3 && n <= 15) << n;
    EXPECT_EQ(cv::countNonZero(result.frames[n].masks) > 0, n >= 3 && n <= 15) << n;
  }
}

TEST(Aot, NothingToSeeIsNoTrouble) {
  SlowSegmenter blind;
  blind.latency_ns = [](const SequenceFrame&) { return std::nullopt; };
  const History result = run({kRed}, 5, blind);
  for (const auto& frame : result.frames) EXPECT_EQ(cv::countNonZero(frame.masks), 0);
  SlowSegmenter empty = perfect_segmenter({kRed}, 0);
  empty.segment = [](const SegmenterInput&) { return cv::Mat(); };
  AsyncObjectTracker tracker(drawn_camera(), empty, {});
  const cv::Mat black = cv::Mat::zeros(240, 320, CV_8UC3), no_depth = cv::Mat::zeros(240, 320, CV_32FC1);
  for (int n = 0; n < 4; ++n) {
    const DrawnFrame drawn = draw_world({kRed}, 0);
    EXPECT_EQ(cv::countNonZero(tracker.track(drawn.frame, n % 2 ? black : drawn.rgb, no_depth).masks), 0);
  }
}

TEST(Aot, SameMasksForAnyNumberOfThreadsOfOpenCv) {
  const std::vector<Sprite> world = {kRed, kBlue};
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const History one = run(world, 16, perfect_segmenter(world));
  cv::setNumThreads(3);
  const History three = run(world, 16, perfect_segmenter(world));
  cv::setNumThreads(threads);
  for (std::size_t n = 0; n < 16; ++n)
    EXPECT_EQ(cv::countNonZero(one.frames[n].masks != three.frames[n].masks), 0) << n;
}

// What arrives when depends on the machine; that results come, in order and of earlier frames, does not.
TEST(Aot, RealThreadsDeliverEveryResultOnce) {
  AotOptions options;
  options.clock = AotClock::threads;
  AsyncObjectTracker tracker(drawn_camera(), perfect_segmenter({kRed}, 2'000'000), options);
  std::vector<std::int64_t> of;
  for (int n = 0; n < 300 && of.size() < 4; ++n) {
    const DrawnFrame drawn = draw_world({kRed}, n % 30);
    SequenceFrame frame = drawn.frame;
    frame.frame = n;
    frame.stamp_ns = n * 33'333'333LL;
    for (const auto& arrived : tracker.track(frame, drawn.rgb, drawn.depth).arrived) {
      EXPECT_LT(arrived.frame, n);
      of.push_back(arrived.frame);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GE(of.size(), 4u);
  EXPECT_TRUE(std::is_sorted(of.begin(), of.end()));
  EXPECT_EQ(std::set<std::int64_t>(of.begin(), of.end()).size(), of.size());
}

TEST(Aot, AFailingSegmenterThreadFailsTheTracker) {
  AotOptions options;
  options.clock = AotClock::threads;
  SlowSegmenter failing = perfect_segmenter({kRed}, 0);
  failing.segment = [](const SegmenterInput&) -> cv::Mat { throw std::runtime_error("broken"); };
  AsyncObjectTracker tracker(drawn_camera(), failing, options);
  const auto track_many = [&] {
    for (int n = 0; n < 300; ++n) {
      const DrawnFrame drawn = draw_world({kRed}, n % 30);
      SequenceFrame frame = drawn.frame;
      frame.frame = n;
      tracker.track(frame, drawn.rgb, drawn.depth);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  EXPECT_THROW(track_many(), std::runtime_error);
}

// A segmenter that shows four fifths of a body and then two halves: more than half of each lies in what was
// tracked, so both are the body's.
TEST(Aot, TheHalvesOfABodyKeepItsId) {
  const auto part = [](double from, double to) {
    Sprite sprite = kRed;
    sprite.size.width = static_cast<int>(kRed.size.width * (to - from));
    sprite.corner_px = [=](std::int64_t) { return Eigen::Vector2d(30 + kRed.size.width * from, 80); };
    return sprite;
  };
  const Sprite whole = part(0, 1);
  SlowSegmenter segmenter;
  segmenter.latency_ns = [](const SequenceFrame&) { return kLatency_ns; };
  segmenter.segment = [=](const SegmenterInput& input) {
    const std::int64_t n = input.frame.frame;
    if (n < 6) return draw_world({part(0, 0.8)}, n).masks;
    cv::Mat masks = draw_world({part(0, 0.5)}, n).masks;
    masks.setTo(2, draw_world({part(0.5, 1)}, n).masks != 0);
    return masks;
  };
  AsyncObjectTracker tracker(drawn_camera(), segmenter, {});
  for (int n = 0; n < 15; ++n) {
    const DrawnFrame drawn = draw_world({whole}, n);
    const cv::Mat masks = tracker.track(drawn.frame, drawn.rgb, {}).masks;
    EXPECT_EQ(cv::countNonZero(masks > 1), 0) << n;
    if (n >= 9) EXPECT_GT(mask_iou(masks == 1, drawn.masks != 0), 0.97) << n;
  }
}

TEST(Aot, TrustedIdsAreTheSegmenters) {
  AotOptions options;
  options.trust_ids = true;
  SlowSegmenter segmenter = perfect_segmenter({kRed, kBlue});
  segmenter.segment = [](const SegmenterInput& input) {
    return draw_world({kRed, kBlue}, input.frame.frame).masks;
  };
  const History result = run({kRed, kBlue}, 10, segmenter, options);
  EXPECT_EQ(track_of(result, 9, 1), 1);
  EXPECT_EQ(track_of(result, 9, 2), 2);
}

}  // namespace
}  // namespace uniquadric
