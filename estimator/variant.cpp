#include "estimator/variant.h"

#include "estimator/option_io.h"

namespace uniquadric {
namespace {

constexpr int kVariantSchema = 1;
constexpr int kMaxIterations = 1'000'000;  // hours: a typing error

template <typename Io>
void visit(Io& io, GrabcutOptions& o) {
  io.number("iterations", o.iterations, 1, 100);
  io.number("downscale", o.downscale, 1, 16);
  io.number("context", o.context, 0.01, 2.0);
  io.positive("depth_reach", o.depth_reach);
  io.positive("plane_threshold_m", o.plane_threshold_m);
  io.number("plane_share", o.plane_share, 0.01, 1.0);
  io.number("rim", o.rim, 0.0, 1.0);
  io.positive("depth_jump", o.depth_jump);
}

template <typename Io>
void visit(Io& io, SegmentationOptions& o) {
  io.choice("source", o.source,
            Choices<MaskSource>{{"automatic", MaskSource::automatic},
                                {"sequence", MaskSource::sequence},
                                {"grabcut_depth", MaskSource::grabcut_depth}});
  io.section("grabcut_depth", [&](auto& inner) { visit(inner, o.grabcut_depth); });
}

template <typename Io>
void visit(Io& io, PointOptions& o) {
  io.number("erode_px", o.erode_px, 0, 100);
  io.positive("edge_ratio", o.edge_ratio);
  io.positive("max_depth_m", o.max_depth_m);
  io.positive("voxel_m", o.voxel_m);
  io.number("outlier_neighbours", o.outlier_neighbours, 1, 1000);
  io.positive("outlier_sigmas", o.outlier_sigmas);
  io.number("outlier_rounds", o.outlier_rounds, 0, 10);
  io.number("max_points", o.max_points, 4);
  io.number("min_points", o.min_points, 4);
}

template <typename Io>
void visit(Io& io, ObbOptions& o) {
  io.choice(
      "fit", o.fit,
      Choices<BoxFit>{
          {"surface", BoxFit::surface}, {"minimum_volume", BoxFit::minimum_volume}, {"pca", BoxFit::pca}});
  io.choice(
      "inlier_distance", o.inlier_distance,
      Choices<InlierDistance>{{"surface", InlierDistance::surface}, {"corner", InlierDistance::corner}});
  io.choice("axis_rule", o.axis_rule,
            Choices<AxisRule>{{"blend_best", AxisRule::blend_best}, {"literal", AxisRule::literal}});
  io.flag("canonicalise", o.canonicalise);
  io.number("iterations", o.iterations, 1, kMaxIterations);
  io.number("sample_size", o.sample_size, 4);
  io.positive("inlier_threshold_m", o.inlier_threshold_m);
  io.number("best_weight", o.best_weight, 0.0, 1.0);
  io.positive("min_semi_axis_m", o.min_semi_axis_m);
}

template <typename Io>
void visit(Io& io, Variant& o) {
  int schema = kVariantSchema;
  io.number("schema", schema, kVariantSchema, kVariantSchema);
  io.text("name", o.name);
  io.section("ego", [&](auto& inner) {
    inner.choice("source", o.ego, Choices<EgoSource>{{"given", EgoSource::given}});
  });
  io.section("segmentation", [&](auto& inner) { visit(inner, o.segmentation); });
  io.section("points", [&](auto& inner) { visit(inner, o.points); });
  io.section("shape", [&](auto& inner) {
    inner.choice("axis_naming", o.axis_naming,
                 Choices<AxisNaming>{{"world", AxisNaming::world}, {"previous", AxisNaming::previous}});
    inner.section("obb", [&](auto& innermost) { visit(innermost, o.obb); });
  });
  io.choice("backend", o.backend, Choices<Backend>{{"single_frame", Backend::single_frame}});
}

}  // namespace

Variant load_variant(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::load(path);
  root.at("schema");
  Variant variant;
  variant.name = path.stem().string();
  OptionReader reader(root);
  visit(reader, variant);
  root.refuse_unknown_keys();
  return variant;
}

std::string variant_yaml(const Variant& variant) {
  Variant copy = variant;
  OptionWriter writer;
  visit(writer, copy);
  return writer.yaml();
}

}  // namespace uniquadric
