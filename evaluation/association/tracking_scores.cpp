#include "evaluation/association/tracking_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/hungarian.h"

namespace uniquadric {
namespace {

constexpr int kThresholds = 19;      // 0.05, 0.10, ..., 0.95
constexpr double kKeepTrack = 1000;  // outweighs any sum of overlaps: a track is kept where it still overlaps
// An IoU that equals a threshold in exact arithmetic counts as reaching it (TrackEval).
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// One frame's table: similarity of each truth object with each track.
Eigen::MatrixXd similarity_at(const ObjectOverlaps& overlaps, std::size_t frame) {
  Eigen::MatrixXd table(overlaps.truth.size(), overlaps.estimate.size());
  for (std::size_t g = 0; g < overlaps.truth.size(); ++g)
    for (std::size_t e = 0; e < overlaps.estimate.size(); ++e)
      table(static_cast<Eigen::Index>(g), static_cast<Eigen::Index>(e)) = overlaps.iou3d[g][e][frame];
  return table;
}

Eigen::VectorXd detections(const std::vector<std::vector<std::optional<std::size_t>>>& presence) {
  Eigen::VectorXd counts(presence.size());
  for (std::size_t i = 0; i < presence.size(); ++i)
    counts[static_cast<Eigen::Index>(i)] = static_cast<double>(
        std::count_if(presence[i].begin(), presence[i].end(), [](auto s) { return s.has_value(); }));
  return counts;
}

bool any_at(const std::vector<std::vector<std::optional<std::size_t>>>& presence, std::size_t frame) {
  return std::any_of(presence.begin(), presence.end(),
                     [&](const auto& states) { return states[frame].has_value(); });
}

struct ClearCounts {
  std::vector<int> switches;  // of each truth object
  int true_positives = 0;
};
ClearCounts clear_counts(const ObjectOverlaps& overlaps, double threshold) {
  ClearCounts counts{std::vector<int>(overlaps.truth.size()), 0};
  std::vector<int> last(overlaps.truth.size(), -1);      // track that last matched the object
  std::vector<int> previous(overlaps.truth.size(), -1);  // ... in the last frame with objects and tracks
  for (std::size_t frame = 0; frame < overlaps.stamps_ns.size(); ++frame) {
    // as in TrackEval, what was matched before a frame without any object or any track is matched after it
    if (!any_at(overlaps.truth, frame) || !any_at(overlaps.estimate, frame)) continue;
    Eigen::MatrixXd score = similarity_at(overlaps, frame);
    for (Eigen::Index g = 0; g < score.rows(); ++g)
      for (Eigen::Index e = 0; e < score.cols(); ++e) {
        if (score(g, e) < threshold - kEpsilon || score(g, e) <= 0)
          score(g, e) = 0;
        else if (previous[static_cast<std::size_t>(g)] == e)
          score(g, e) += kKeepTrack;
      }
    const std::vector<int> match = maximum_assignment(score);
    for (std::size_t g = 0; g < match.size(); ++g) {
      const bool matched = match[g] >= 0 && score(static_cast<Eigen::Index>(g), match[g]) > 0;
      previous[g] = matched ? match[g] : -1;
      if (!matched) continue;
      ++counts.true_positives;
      if (last[g] >= 0 && last[g] != match[g]) ++counts.switches[g];
      last[g] = match[g];
    }
  }
  return counts;
}

double mota(const ObjectOverlaps& overlaps, double truths, double estimates) {
  const ClearCounts counts = clear_counts(overlaps, kClearThreshold);
  const double false_positives = estimates - counts.true_positives;
  double switches = 0;
  for (const int n : counts.switches) switches += n;
  return (counts.true_positives - false_positives - switches) / truths;
}

double idf1(const ObjectOverlaps& overlaps, double truths, double estimates) {
  Eigen::MatrixXd together = Eigen::MatrixXd::Zero(overlaps.truth.size(), overlaps.estimate.size());
  for (std::size_t frame = 0; frame < overlaps.stamps_ns.size(); ++frame)
    together.array() += (similarity_at(overlaps, frame).array() >= kClearThreshold).cast<double>();
  double true_positives = 0;
  if (together.size() > 0) {
    const std::vector<int> match = maximum_assignment(together);
    for (std::size_t g = 0; g < match.size(); ++g)
      if (match[g] >= 0) true_positives += together(static_cast<Eigen::Index>(g), match[g]);
  }
  return 2 * true_positives / (truths + estimates);
}

// How well each pair fits over all time, whatever the threshold: it steers the assignment frame by frame.
Eigen::MatrixXd global_alignment(const ObjectOverlaps& overlaps, const Eigen::VectorXd& truths,
                                 const Eigen::VectorXd& estimates) {
  Eigen::MatrixXd potential = Eigen::MatrixXd::Zero(truths.size(), estimates.size());
  for (std::size_t frame = 0; frame < overlaps.stamps_ns.size(); ++frame) {
    const Eigen::MatrixXd similarity = similarity_at(overlaps, frame);
    const Eigen::VectorXd rows = similarity.rowwise().sum();
    const Eigen::RowVectorXd columns = similarity.colwise().sum();
    for (Eigen::Index g = 0; g < similarity.rows(); ++g)
      for (Eigen::Index e = 0; e < similarity.cols(); ++e)
        if (similarity(g, e) > 0)
          potential(g, e) += similarity(g, e) / (rows[g] + columns[e] - similarity(g, e));
  }
  for (Eigen::Index g = 0; g < potential.rows(); ++g)
    for (Eigen::Index e = 0; e < potential.cols(); ++e)
      if (potential(g, e) > 0) potential(g, e) /= truths[g] + estimates[e] - potential(g, e);
  return potential;
}

double hota(const ObjectOverlaps& overlaps) {
  const Eigen::VectorXd truths = detections(overlaps.truth), estimates = detections(overlaps.estimate);
  const Eigen::MatrixXd alignment = global_alignment(overlaps, truths, estimates);
  std::vector<Eigen::MatrixXd> matches(kThresholds,
                                       Eigen::MatrixXd::Zero(alignment.rows(), alignment.cols()));
  for (std::size_t frame = 0; frame < overlaps.stamps_ns.size() && alignment.size() > 0; ++frame) {
    const Eigen::MatrixXd similarity = similarity_at(overlaps, frame);
    const std::vector<int> match = maximum_assignment(alignment.cwiseProduct(similarity));
    for (std::size_t row = 0; row < match.size(); ++row) {
      if (match[row] < 0) continue;
      const auto g = static_cast<Eigen::Index>(row);
      for (int k = 0; k < kThresholds; ++k)
        if (similarity(g, match[row]) > 0 && similarity(g, match[row]) >= 0.05 * (k + 1) - kEpsilon)
          matches[k](g, match[row]) += 1;
    }
  }
  double sum = 0;
  for (const Eigen::MatrixXd& counts : matches) {
    const double true_positives = counts.sum();
    if (true_positives == 0) continue;
    double association = 0;
    for (Eigen::Index g = 0; g < counts.rows(); ++g)
      for (Eigen::Index e = 0; e < counts.cols(); ++e)
        if (counts(g, e) > 0)
          association += counts(g, e) * counts(g, e) / (truths[g] + estimates[e] - counts(g, e));
    association /= true_positives;
    const double detection = true_positives / (truths.sum() + estimates.sum() - true_positives);
    sum += std::sqrt(detection * association);
  }
  return sum / kThresholds;
}

}  // namespace

std::optional<TrackingScores> tracking_scores(const ObjectOverlaps& overlaps) {
  const double truths = detections(overlaps.truth).sum(), estimates = detections(overlaps.estimate).sum();
  if (truths == 0) return std::nullopt;
  return TrackingScores{hota(overlaps), mota(overlaps, truths, estimates), idf1(overlaps, truths, estimates)};
}

std::vector<int> identity_switches(const ObjectOverlaps& overlaps, double threshold) {
  return clear_counts(overlaps, threshold).switches;
}

}  // namespace uniquadric
