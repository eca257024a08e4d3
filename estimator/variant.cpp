#include "estimator/variant.h"

#include <algorithm>

#include "core/base/read_file.h"
#include "estimator/base/option_io.h"
#include "estimator/default_variants.h"
#include "estimator/objects/body_options.h"
#include "estimator/perception/perception_options.h"

namespace uniquadric {
namespace {

constexpr int kVariantSchema = 1;

template <typename Io>
void visit(Io& io, UprightBoxOptions& o) {
  io.positive("acceleration_mps2", o.acceleration_mps2);
  io.number("lost_after_s", o.lost_after_s, 0.0, 60.0);
  io.flag("shape_yaw", o.shape_yaw);
  io.flag("street_sizes", o.street_sizes);
  io.flag("beam_gaps", o.beam_gaps);
}

template <typename Io>
void visit(Io& io, Variant& o) {
  int schema = kVariantSchema;
  io.number("schema", schema, kVariantSchema, kVariantSchema);
  io.text("name", o.name);
  visit(io, o.perception);
  io.section("shape", [&](auto& inner) {
    inner.choice("axis_naming", o.axis_naming,
                 Choices<AxisNaming>{{"world", AxisNaming::world}, {"previous", AxisNaming::previous}});
    visit(inner, o.body.shape);
  });
  io.section("short_window", [&](auto& inner) { visit(inner, o.body.short_window); });
  io.section("long_window", [&](auto& inner) { visit(inner, o.body.shape.long_window); });
  io.section("motion_decision", [&](auto& inner) { visit(inner, o.body.motion); });
  io.section("lifecycle", [&](auto& inner) { visit(inner, o.body.lifecycle); });
  io.section("cloud_alignment", [&](auto& inner) { visit(inner, o.body.alignment); });
  io.section("carving", [&](auto& inner) { visit(inner, o.body.carving); });
  io.choice("backend", o.backend,
            Choices<Backend>{{"single_frame", Backend::single_frame},
                             {"windows", Backend::windows},
                             {"upright", Backend::upright}});
  io.section("upright", [&](auto& inner) { visit(inner, o.upright); });
  io.choice(
      "parameterisation", o.body.parameterisation,
      Choices<Parameterisation>{{"object", Parameterisation::object}, {"global", Parameterisation::global}});
  io.choice("feedback", o.feedback,
            Choices<Feedback>{{"perception", Feedback::perception}, {"backend", Feedback::backend}});
  io.flag("plausibility", o.plausibility.enabled);
  io.flag("smooth", o.smooth);
  io.flag("write_features", o.write_features);
}

Variant read_variant(const ConfigNode& root, const std::string& name) {
  root.at("schema");
  Variant variant;
  variant.name = name;
  OptionReader reader(root);
  visit(reader, variant);
  root.refuse_unknown_keys();
  return variant;
}

}  // namespace

Variant default_variant(const Sequence& sequence, const std::vector<ConfigOverride>& set) {
  const auto read = [&](const char* name, const char* text) {
    return read_variant(ConfigNode::parse(text, std::string(name) + ".yaml", set), name);
  };
  if (sequence.frames.empty()) return read("lidar_only", kLidarOnlyVariant);
  const bool has_depth =
      std::ranges::any_of(sequence.frames, [](const SequenceFrame& frame) { return !frame.depth.empty(); });
  if (sequence.lidar && !has_depth) return read("lidar_masks", kLidarMasksVariant);
  return read("superquadric", kSuperquadricVariant);
}

Variant load_variant(const std::filesystem::path& path, const std::vector<ConfigOverride>& set) {
  return read_variant(ConfigNode::parse(read_file(path, kYamlFile), path, set), path.stem().string());
}

std::string variant_yaml(const Variant& variant) {
  Variant copy = variant;
  OptionWriter writer;
  visit(writer, copy);
  return writer.yaml();
}

std::string perception_yaml(const Variant& variant) {
  PerceptionOptions copy = variant.perception;
  OptionWriter writer;
  visit(writer, copy);
  return writer.yaml();
}

}  // namespace uniquadric
