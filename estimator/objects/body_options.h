#pragma once

#include "estimator/base/option_io.h"
#include "estimator/objects/body_estimator.h"

namespace uniquadric {

/// Names the options' keys, for reading and writing (option_io.h).
template <typename Io>
void visit(Io& io, ObbOptions& o) {
  io.choice("fit", o.fit,
            Choices<BoxFit>{{"surface", BoxFit::surface},
                            {"tight_surface", BoxFit::tight_surface},
                            {"minimum_volume", BoxFit::minimum_volume},
                            {"pca", BoxFit::pca}});
  io.choice(
      "inlier_distance", o.inlier_distance,
      Choices<InlierDistance>{{"surface", InlierDistance::surface}, {"corner", InlierDistance::corner}});
  io.choice("axis_rule", o.axis_rule,
            Choices<AxisRule>{{"blend_best", AxisRule::blend_best}, {"literal", AxisRule::literal}});
  io.flag("canonicalise", o.canonicalise);
  io.number("iterations", o.iterations, 1, kMostIterations);
  io.number("sample_size", o.sample_size, 4);
  io.positive("inlier_threshold_m", o.inlier_threshold_m);
  io.number("best_weight", o.best_weight, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, SurfaceCloudOptions& o) {
  io.number("min_hits", o.min_hits, 1, 1000);
  io.number("max_points", o.max_points, 10, 100'000);
}

/// The rule of the fusion is not its own: long_window.axis_prior says it.
template <typename Io>
void visit(Io& io, AxisFusionOptions& o) {
  io.number("bandwidth", o.bandwidth, 0.01, 100.0);
  io.number("iterations", o.iterations, 1, kMostIterations);
  io.number("literal_alpha", o.literal_alpha, 0.0, 0.99);
  io.positive("literal_step", o.literal_step);
}

/// But for the long window, which is a section of its own.
template <typename Io>
void visit(Io& io, ShapeOptions& o) {
  io.section("obb", [&](auto& inner) { visit(inner, o.obb); });
  io.section("surface_cloud", [&](auto& inner) { visit(inner, o.surface); });
  io.section("axis_fusion", [&](auto& inner) { visit(inner, o.fusion); });
  io.positive("sphere_sigma", o.sphere_sigma, kSigmaOfRatio);
  io.flag("plain_shapes", o.plain_shapes);
  io.number("search_keyframes", o.search_keyframes, 0, 1000);
}

template <typename Io>
void visit(Io& io, ShortWindowOptions& o) {
  io.number("keyframes", o.keyframes, 3, 100);
  io.number("keyframe_gap_s", o.keyframe_gap_s, 1e-3, 1e6);
  io.flag("motion_model", o.motion_model);
  io.flag("marginal_prior", o.marginal_prior);
  io.number("min_inliers", o.pose.min_inliers, 4);
}

template <typename Io>
void visit(Io& io, LongWindowOptions& o) {
  io.number("keyframes", o.keyframes, 1, 1000);
  io.choice("semantic", o.semantic,
            Choices<SemanticFactor>{{"none", SemanticFactor::none},
                                    {"literal", SemanticFactor::literal},
                                    {"vector", SemanticFactor::vector},
                                    {"tangent", SemanticFactor::tangent}});
  io.choice(
      "outline", o.outline,
      Choices<Outline>{{"bbox", Outline::bbox}, {"rot_bbox", Outline::rot_bbox}, {"hull", Outline::hull}});
  io.choice("exponents", o.exponents, Choices<int>{{"0", 0}, {"1", 1}, {"3", 3}});
  io.positive("outline_sigma_px", o.outline_sigma_px, kSigma_px);
  io.choice("outline_noise", o.outline_noise,
            Choices<OutlineNoise>{{"given", OutlineNoise::given}, {"measured", OutlineNoise::measured}});
  io.flag("segmented_outlines", o.segmented_outlines);
  io.choice("axis_prior", o.axis_prior,
            Choices<AxisPrior>{{"none", AxisPrior::none},
                               {"mean", AxisPrior::mean},
                               {"inverse_variance", AxisPrior::inverse_variance},
                               {"renyi", AxisPrior::renyi},
                               {"literal", AxisPrior::literal}});
  io.choice("axis_samples", o.axis_samples,
            Choices<AxisSamples>{{"boxes", AxisSamples::boxes}, {"extents", AxisSamples::extents}});
  io.choice("rigid_prior", o.rigid_prior,
            Choices<RigidPrior>{
                {"none", RigidPrior::none}, {"soft", RigidPrior::soft}, {"hard", RigidPrior::hard}});
  io.flag("surface_points", o.surface_points);
  io.positive("surface_sigma_m", o.surface_sigma_m, kSigma_m);
  io.flag("extents", o.extents);
  io.flag("box_by_points", o.box_by_points);
  io.flag("contacts", o.contacts);
}

template <typename Io>
void visit(Io& io, LifecycleOptions& o) {
  io.positive("acceleration_mps2", o.acceleration_mps2);
  io.positive("angular_acceleration_radps2", o.angular_acceleration_radps2);
  io.positive("lost_after_s", o.lost_after_s);
  io.flag("ends_outside", o.ends_outside);
  io.flag("ends_unplaced", o.ends_unplaced);
  io.flag("weighs_evidence", o.weighs_evidence);
  io.flag("drops_models", o.drops_models);
  io.flag("follows_points", o.follows_points);
}

template <typename Io>
void visit(Io& io, MotionDecisionOptions& o) {
  io.positive("camera_sigma_m", o.camera_sigmas.translation_m, kSigma_m);
  io.positive("camera_sigma_rad", o.camera_sigmas.rotation_rad, kSigma_rad);
  io.positive("surface_sigma_m", o.surface_sigma_m, kSigma_m);
}

template <typename Io>
void visit(Io& io, CarvingOptions& o) {
  io.flag("enabled", o.enabled);
  io.number("views", o.views, 1, 60'000);
}

template <typename Io>
void visit(Io& io, CloudAlignmentOptions& o) {
  io.flag("impacts", o.impacts);
}

}  // namespace uniquadric
