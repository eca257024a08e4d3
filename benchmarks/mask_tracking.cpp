// The asynchronous object tracker against the truth: mask_tracking DATA [VARIANT.yaml], DATA holding
// sequence/ and truth/ as `uniquadric simulate` writes them. Prints, for each object, the overlap of the
// tracked masks with the true ones, the changes of its id, and the error of the free tangents; and the time
// of each part.
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <set>

#include "core/sequence/sequence.h"
#include "estimator/mask_tracking/aot.h"
#include "estimator/observation/silhouette.h"
#include "estimator/variant.h"

namespace uniquadric {
namespace {

constexpr int kMinTruePixels = 200;

struct Sum {
  double sum = 0, squares = 0;
  int count = 0;
  void add(double value) { sum += value, squares += value * value, ++count; }
  double mean() const { return count ? sum / count : 0; }
  double deviation() const {
    return std::sqrt(std::max(squares / std::max(count, 1) - mean() * mean(), 0.0));
  }
};

struct ObjectScore {
  Sum iou, tangent_px;
  double least_iou = 1;
  int missed = 0, switches = 0, last_id = 0;
  std::set<int> ids;
};

using Scores = std::map<int, ObjectScore>;

// The tracked id that overlaps a true mask most, with its IoU.
std::pair<int, double> best_id(const cv::Mat& tracked, const cv::Mat& truth_mask) {
  std::map<int, int> shared;
  for (int v = 0; v < tracked.rows; ++v)
    for (int u = 0; u < tracked.cols; ++u)
      if (truth_mask.at<unsigned char>(v, u)) ++shared[tracked.at<std::uint16_t>(v, u)];
  std::pair<int, double> best{0, 0};
  const int truth_pixels = cv::countNonZero(truth_mask);
  for (const auto& [id, both] : shared) {
    if (id == 0) continue;
    const double iou = both / double(truth_pixels + cv::countNonZero(tracked == id) - both);
    if (iou > best.second) best = {id, iou};
  }
  return best;
}

void score(const cv::Mat& masks, const cv::Mat& truth, const cv::Mat& depth, const Camera& camera,
           Scores& scores) {
  const auto found = silhouettes(masks, depth, camera, {});
  const auto expected = silhouettes(truth, depth, camera, {});
  for (const auto& [id, silhouette] : expected) {
    const cv::Mat truth_mask = truth == id;
    if (cv::countNonZero(truth_mask) < kMinTruePixels) continue;
    ObjectScore& object = scores[id];
    const auto [track, iou] = best_id(masks, truth_mask);
    object.iou.add(iou);
    object.least_iou = std::min(object.least_iou, iou);
    if (iou < 0.3) {
      ++object.missed;
      continue;
    }
    object.switches += object.last_id != 0 && object.last_id != track;
    object.last_id = track;
    object.ids.insert(track);
    const auto tracked = found.find(track);
    if (tracked == found.end()) continue;
    for (std::size_t k = 0; k < silhouette.support.size(); ++k)
      if (silhouette.support[k].free && tracked->second.support[k].free)
        object.tangent_px.add(tracked->second.support[k].offset_px - silhouette.support[k].offset_px);
  }
}

void print(const char* what, const Scores& scores) {
  for (const auto& [id, s] : scores)
    fmt::print(
        "{:10} object {}: IoU mean {:.4f} least {:.3f}, missed {} of {}, ids {}, switches {}, "
        "tangents {:+.2f} +- {:.2f} px ({})\n",
        what, id, s.iou.mean(), s.least_iou, s.missed, s.iou.count, s.ids.size(), s.switches,
        s.tangent_px.mean(), s.tangent_px.deviation(), s.tangent_px.count);
}

// Processor time of this thread [ms]: the machine may be busy with other things.
double thread_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void run(const std::filesystem::path& data, const Variant& variant) {
  cv::setNumThreads(1);
  const Sequence sequence = open_sequence(data / "sequence");
  const PromptedSegmenter segmenter = make_segmenter(sequence, variant.perception.segmentation, {});
  AsyncObjectTracker tracker(sequence.camera, slow_segmenter(sequence, segmenter, variant.perception.aot, 0),
                             variant.perception.aot);
  Scores tracked, arrived;
  std::map<std::string, Sum> times;
  std::map<std::int64_t, cv::Mat> truths, depths;
  for (const auto& frame : sequence.frames) {
    const cv::Mat rgb = read_rgb(sequence, frame);
    const cv::Mat depth = frame.depth.empty() ? cv::Mat() : read_depth(sequence, frame);
    const double start_ms = thread_ms();
    const AotFrame result = tracker.track(frame, rgb, depth);
    times["one core"].add(thread_ms() - start_ms);
    for (const StageTime& time : result.times) times[time.stage].add(time.ms);
    truths[frame.frame] = read_image(data / fmt::format("truth/instances/{:06}.png", frame.frame));
    depths[frame.frame] = depth;
    if (frame.frame > 10) score(result.masks, truths[frame.frame], depth, sequence.camera, tracked);
    for (const auto& result_of : result.arrived)
      score(result_of.masks, truths[result_of.frame], depths[result_of.frame], sequence.camera, arrived);
  }
  print("tracked", tracked);
  print("segmented", arrived);
  for (const auto& [part, ms] : times) fmt::print("{:14} {:6.2f} ms a frame\n", part, ms.mean());
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  uniquadric::run(argv[1], argc > 2 ? uniquadric::load_variant(argv[2]) : uniquadric::Variant{});
}
