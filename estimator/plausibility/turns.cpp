#include "estimator/plausibility/turns.h"

#include <Eigen/SVD>
#include <algorithm>

#include "core/base/quantile.h"
#include "core/base/seconds.h"

namespace uniquadric {
namespace {

// From one time to another, readings held between samples.
std::optional<Eigen::Vector3d> integrated(const std::vector<ImuSample>& samples, std::int64_t from_ns,
                                          std::int64_t to_ns, double scale) {
  if (samples.empty() || from_ns < samples.front().stamp_ns || to_ns > samples.back().stamp_ns)
    return std::nullopt;
  auto sample = std::upper_bound(samples.begin(), samples.end(), from_ns,
                                 [](std::int64_t ns, const ImuSample& s) { return ns < s.stamp_ns; });
  Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();
  for (std::int64_t now_ns = from_ns; now_ns < to_ns && sample != samples.end(); ++sample) {
    const std::int64_t next_ns = std::min(sample->stamp_ns, to_ns);
    const Eigen::Vector3d rate =
        0.5 * scale * (std::prev(sample)->angular_velocity_radps + sample->angular_velocity_radps);
    turned = turned * exp_so3(seconds(now_ns, next_ns) * rate);
    now_ns = next_ns;
  }
  return log_so3(turned.normalized());
}

}  // namespace

std::vector<Turn> turns_of(const Sequence& sequence, const std::vector<FramePair>& pairs) {
  std::vector<Turn> turns;
  for (const FramePair& pair : pairs)
    if (pair.b_from_a)
      turns.push_back({sequence.frames[pair.first].stamp_ns, sequence.frames[pair.second].stamp_ns,
                       log_so3(pair.b_from_a->rotation.conjugate())});
  return turns;
}

std::vector<std::optional<Eigen::Vector3d>> turns_by(const std::vector<ImuSample>& samples,
                                                     const std::vector<Turn>& turns, std::int64_t late_ns,
                                                     double scale) {
  std::vector<std::optional<Eigen::Vector3d>> result;
  for (const Turn& turn : turns)
    result.push_back(integrated(samples, turn.from_ns + late_ns, turn.to_ns + late_ns, scale));
  return result;
}

std::optional<double> disagreement(const std::vector<Turn>& turns,
                                   const std::vector<std::optional<Eigen::Vector3d>>& others,
                                   const ChangeOfTurn& change) {
  double difference = 0, sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < turns.size(); ++i) {
    if (!others[i]) continue;
    difference += (turns[i].vector - change(*others[i])).norm();
    sum += turns[i].vector.norm();
    ++count;
  }
  if (2 * count <= turns.size() || !(sum > 0)) return std::nullopt;
  return difference / sum;
}

Eigen::Matrix3d best_rotation(const std::vector<Turn>& turns,
                              const std::vector<std::optional<Eigen::Vector3d>>& others) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < turns.size(); ++i)
    if (others[i]) sum += turns[i].vector * others[i]->transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

double usual_turn(const std::vector<Turn>& turns) {
  std::vector<double> angles;
  for (const Turn& turn : turns) angles.push_back(turn.vector.norm());
  return angles.empty() ? 0 : quantile(std::move(angles), 0.5);
}

}  // namespace uniquadric
