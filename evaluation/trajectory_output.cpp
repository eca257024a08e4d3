#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/base/version.h"
#include "core/sequence/trajectory.h"
#include "evaluation/pose_json_parts.h"
#include "evaluation/trajectory_comparison.h"

namespace uniquadric {
namespace {
using nlohmann::json;

constexpr int kSchema = 1;
constexpr double kDegrees = 180 / std::numbers::pi;

const char* name_of(StampRule rule) {
  return rule == StampRule::nearest ? "nearest" : "one_to_one";
}

bool from_reference(const TrajectoryOptions& options) {
  return options.pairs_from_reference.value_or(!options.evo);
}

double max_difference_s(const TrajectoryOptions& options) {
  return static_cast<double>(options.association.max_difference_ns) / 1e9;
}

// As in evaluation.json: translation_m, rotation_rad, full.
std::string key_of(ErrorPart part) {
  return part == ErrorPart::full ? "full" : fmt::format("{}_{}", to_string(part), unit_of(part));
}

// |R - I|_F of turns by these angles: evo's rotation_part.
std::vector<double> matrix_norms(const std::vector<double>& angles_rad) {
  std::vector<double> norms;
  for (const double angle : angles_rad) norms.push_back(2 * std::numbers::sqrt2 * std::sin(angle / 2));
  return norms;
}

json delta_json(const TrajectoryOptions& options) {
  return {{"value", options.delta.delta},
          {"unit", to_string(options.delta.unit)},
          {"all_pairs", options.delta.all_pairs},
          {"pairs_from", from_reference(options) ? "ref" : "est"}};
}

json to_json(const AngleExtremes& angle, const PosePairs& pairs) {
  return {{"min_deg", angle.min_rad * kDegrees},
          {"min_timestamp_ns", pairs.stamps_ns[angle.min_index]},
          {"min_pair", angle.min_index},
          {"max_deg", angle.max_rad * kDegrees},
          {"max_timestamp_ns", pairs.stamps_ns[angle.max_index]},
          {"max_pair", angle.max_index}};
}

json first_pose_json(const TrajectoryComparison& c) {
  json result = to_json(c.drift);
  result["max_translation_pair"] = c.drift->translation_index;
  result["max_angle_pair"] = c.drift->angle_index;
  result["roll"] = to_json(c.drift_angles->roll, c.pairs);
  result["pitch"] = to_json(c.drift_angles->pitch, c.pairs);
  result["yaw"] = to_json(c.drift_angles->yaw, c.pairs);
  return result;
}

json to_json(const CalibratedDrift& drift) {
  const auto& percent = drift.max_translation_percent_of_path;
  const Eigen::Vector3d angles = drift.roll_pitch_yaw_rad * kDegrees;
  json result = to_json(AlignmentKind::first, {1, drift.reference_from_estimate}, "reference_from_estimate");
  result.erase("kind");
  result["alignment"] = "calibrated";
  result["determined"] = drift.determined;
  result["max_translation_m"] = drift.max_translation_m;
  result["max_translation_percent_of_path"] = percent ? json(*percent) : json();
  result["max_translation_pair"] = drift.translation_index;
  result["max_angle_deg"] = drift.max_angle_rad * kDegrees;
  result["roll_deg"] = angles.x();
  result["pitch_deg"] = angles.y();
  result["yaw_deg"] = angles.z();
  result["max_angle_pair"] = drift.angle_index;
  return result;
}

json to_json(const KittiErrors& errors) {
  return {{"translation_percent", errors.translation_percent},
          {"rotation_deg_per_100m", errors.rotation_deg_per_100m},
          {"parts", errors.parts}};
}

json to_json(const std::optional<KittiOdometry>& kitti) {
  if (!kitti) return nullptr;
  json result = to_json(kitti->mean);
  result["lengths"] = json::array();
  for (const KittiLength& length : kitti->lengths) {
    result["lengths"].push_back(to_json(length.errors));
    result["lengths"].back()["length_m"] = length.length_m;
  }
  return result;
}

std::string row(const std::string& name, const Statistics& s) {
  return fmt::format("{:<18}{:>12.5g}{:>12.5g}{:>12.5g}{:>12.5g}{:>12.5g}{:>12.5g}{:>12.5g}{:>8}\n", name,
                     s.rmse, s.mean, s.median, s.std, s.min, s.max, s.sse, s.n);
}

std::string alignment_text(const TrajectoryComparison& c, const TrajectoryOptions& options) {
  const auto& [scale, pose] = c.alignment;
  const Eigen::Vector3d& t = pose.translation;
  if (options.alignment == AlignmentKind::none) return "alignment  none\n";
  return fmt::format(
      "alignment  {} by {} pairs: scale {:.6g}, turned by {:.6g} deg, moved by {:.6g} {:.6g} {:.6g} m\n",
      to_string(options.alignment), c.aligned_pairs, scale,
      rotation_angle(pose.rotation.toRotationMatrix()) * kDegrees, t.x(), t.y(), t.z());
}

std::string percent_text(const std::optional<double>& percent) {
  return percent ? fmt::format(" ({:.4g} % of the reference's path up to there)", *percent) : "";
}

std::string drift_text(const TrajectoryComparison& c) {
  const auto at = [&](std::size_t k) { return format_stamp(c.pairs.stamps_ns[k]); };
  const auto extremes = [&](const char* name, const AngleExtremes& angle) {
    return fmt::format("  {:<12}{:.6g} deg at {} s to {:.6g} deg at {} s\n", name, angle.min_rad * kDegrees,
                       at(angle.min_index), angle.max_rad * kDegrees, at(angle.max_index));
  };
  const Drift& first = *c.drift;
  const CalibratedDrift& calibrated = *c.calibrated;
  const Eigen::Vector3d angles = calibrated.roll_pitch_yaw_rad * kDegrees;
  const auto greatest = [&](double translation_m, const std::optional<double>& percent, std::size_t k) {
    return fmt::format("  translation {:.6g} m at {} s{}\n", translation_m, at(k), percent_text(percent));
  };
  std::string text = "greatest drift, the first poses laid on one another:\n";
  text += greatest(first.max_translation_m, first.max_translation_percent_of_path, first.translation_index);
  text += fmt::format("  rotation    {:.6g} deg at {} s\n", first.max_angle_rad * kDegrees,
                      at(first.angle_index));
  text += extremes("roll", c.drift_angles->roll) + extremes("pitch", c.drift_angles->pitch) +
          extremes("yaw", c.drift_angles->yaw);
  text +=
      "greatest drift, calibrated: with the rigid transform of the body's frame that fits all poses best:\n";
  text += greatest(calibrated.max_translation_m, calibrated.max_translation_percent_of_path,
                   calibrated.translation_index);
  text += fmt::format("  rotation    {:.6g} deg (roll {:.6g}, pitch {:.6g}, yaw {:.6g}) at {} s\n",
                      calibrated.max_angle_rad * kDegrees, angles.x(), angles.y(), angles.z(),
                      at(calibrated.angle_index));
  if (!calibrated.determined) text += "  the motion leaves a part of the calibration open\n";
  return text;
}

std::string kitti_text(const std::optional<KittiOdometry>& kitti) {
  if (!kitti) return "KITTI: the reference's path has no part of 100 m\n";
  const auto line = [](const std::string& name, const KittiErrors& e) {
    return fmt::format("{:<18}{:>12.5g}{:>18.5g}{:>8}\n", name, e.translation_percent,
                       e.rotation_deg_per_100m, e.parts);
  };
  std::string text =
      fmt::format("{:<18}{:>12}{:>18}{:>8}\n", "KITTI", "t_rel [%]", "r_rel [deg/100m]", "parts");
  for (const KittiLength& length : kitti->lengths)
    text += line(fmt::format("{:g} m", length.length_m), length.errors);
  return text + line("all", kitti->mean);
}

}  // namespace

std::string trajectory_json(const TrajectoryComparison& c, const TrajectoryOptions& options) {
  json root = {{"schema", kSchema},
               {"program", kProgram},
               {"compat", options.evo ? json("evo") : json()},
               {"n_pairs", c.pairs.size()},
               {"coverage", c.coverage},
               {"reference", {{"poses", c.reference_poses}, {"path_m", c.reference_path_m}}},
               {"estimate", {{"poses", c.estimate_poses}, {"path_m", c.estimate_path_m}}},
               {"association",
                {{"rule", name_of(options.association.rule)}, {"max_dt_s", max_difference_s(options)}}}};
  root["alignment"] = to_json(options.alignment, c.alignment, "reference_from_estimate");
  root["alignment"]["n"] = c.aligned_pairs;
  for (const ErrorSeries& series : c.errors) {
    json& errors = root[to_string(series.relation)];
    errors[key_of(series.part)] = to_json(statistics(series.values));
    if (series.part == ErrorPart::rotation && options.evo)
      errors["rotation_part"] = to_json(statistics(matrix_norms(series.values)));
    if (series.relation == PoseRelation::rpe) errors["delta"] = delta_json(options);
  }
  if (options.drift) root["drift"] = {{"first", first_pose_json(c)}, {"calibrated", to_json(*c.calibrated)}};
  if (options.kitti) root["kitti"] = to_json(c.kitti);
  return root.dump(2) + "\n";
}

std::string trajectory_text(const TrajectoryComparison& c, const TrajectoryOptions& options) {
  std::string text = fmt::format("reference  {} poses, {:.6g} m\nestimate   {} poses, {:.6g} m\n",
                                 c.reference_poses, c.reference_path_m, c.estimate_poses, c.estimate_path_m);
  text += fmt::format("pairs      {} ({}, {:g} s), coverage {:.4g}\n", c.pairs.size(),
                      name_of(options.association.rule), max_difference_s(options), c.coverage);
  text += alignment_text(c, options);
  if (options.relations.back() == PoseRelation::rpe)
    text += fmt::format(
        "RPE        over {:g}{}, {}, steps of the {}{}\n", options.delta.delta, to_string(options.delta.unit),
        options.delta.all_pairs ? "all pairs" : "one after the other",
        from_reference(options) ? "reference" : "estimate", options.evo ? ", chosen as evo does" : "");
  text += fmt::format("\n{:<18}{:>12}{:>12}{:>12}{:>12}{:>12}{:>12}{:>12}{:>8}\n", "", "rmse", "mean",
                      "median", "std", "min", "max", "sse", "n");
  for (const ErrorSeries& series : c.errors) {
    const std::string unit = unit_of(series.part);
    text += row(
        fmt::format("{} {}{}", series.relation == PoseRelation::ape ? "APE" : "RPE",
                    to_string(series.part) == std::string("translation") ? "transl." : to_string(series.part),
                    unit.empty() ? "" : " [" + unit + "]"),
        *statistics(series.values));
  }
  if (options.drift) text += "\n" + drift_text(c);
  if (options.kitti) text += "\n" + kitti_text(c.kitti);
  return text;
}

}  // namespace uniquadric
