#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

std::vector<PoseError> absolute_errors(const PosePairs& poses) {
  std::vector<PoseError> errors;
  for (std::size_t i = 0; i < poses.size(); ++i)
    errors.push_back(absolute_error(poses.reference[i], poses.estimate[i]));
  return errors;
}

std::vector<PoseError> relative_errors(const PosePairs& poses, const std::vector<IndexStep>& steps) {
  std::vector<PoseError> errors;
  for (const auto& [i, j] : steps)
    errors.push_back(
        relative_error(poses.reference[i], poses.reference[j], poses.estimate[i], poses.estimate[j]));
  return errors;
}

std::vector<double> translations_m(const std::vector<PoseError>& errors) {
  std::vector<double> values;
  for (const PoseError& error : errors) values.push_back(error.translation_m);
  return values;
}

std::vector<double> rotations_rad(const std::vector<PoseError>& errors) {
  std::vector<double> values;
  for (const PoseError& error : errors) values.push_back(error.rotation_rad);
  return values;
}

std::optional<Drift> maximum_drift(const PosePairs& poses) {
  if (poses.size() == 0) return std::nullopt;
  Drift drift;
  double path_m = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i > 0) path_m += (poses.reference[i].translation - poses.reference[i - 1].translation).norm();
    // Both relative to their own first pose, which is what aligning the first poses comes to.
    const PoseError error =
        relative_error(poses.reference[0], poses.reference[i], poses.estimate[0], poses.estimate[i]);
    if (error.translation_m > drift.max_translation_m) {
      drift.max_translation_m = error.translation_m;
      drift.translation_index = i;
      drift.max_translation_percent_of_path.reset();
      if (path_m > 0) drift.max_translation_percent_of_path = 100 * error.translation_m / path_m;
    }
    if (error.rotation_rad > drift.max_angle_rad) {
      drift.max_angle_rad = error.rotation_rad;
      drift.angle_index = i;
    }
  }
  if (drift.max_translation_m == 0 && path_m > 0) drift.max_translation_percent_of_path = 0;
  return drift;
}

}  // namespace uniquadric
