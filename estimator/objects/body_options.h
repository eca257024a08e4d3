#pragma once

#include "estimator/objects/body_estimator.h"
#include "estimator/option_io.h"

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
  io.positive("min_semi_axis_m", o.min_semi_axis_m);
}

template <typename Io>
void visit(Io& io, SurfaceCloudOptions& o) {
  io.number("voxel_share", o.voxel_share, 0.005, 1.0);
  io.number("min_hits", o.min_hits, 1, 1000);
  io.number("max_points", o.max_points, 10, 100'000);
}

/// The rule of the fusion is not its own: long_window.axis_prior says it.
template <typename Io>
void visit(Io& io, AxisFusionOptions& o) {
  io.number("bandwidth", o.bandwidth, 0.01, 100.0);
  io.flag("weighted_spread", o.weighted_spread);
  io.positive("min_sigma_m", o.min_sigma_m, kSigma_m);
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
  io.number("search_keyframes", o.search_keyframes, 0, 1000);
}

template <typename Io>
void visit(Io& io, ShortWindowOptions& o) {
  io.number("keyframes", o.keyframes, 3, 100);
  io.positive("keyframe_turn_deg", o.keyframe_turn_deg);
  io.number("keyframe_share", o.keyframe_share, 0.0, 1.0);
  io.number("keyframe_gap_s", o.keyframe_gap_s, 1e-3, 1e6);
  io.flag("motion_model", o.motion_model);
  io.positive("acceleration_noise", o.motion_noise.acceleration);
  io.positive("angular_acceleration_noise", o.motion_noise.angular_acceleration);
  io.flag("rest_factor", o.rest_factor);
  io.flag("marginal_prior", o.marginal_prior);
  io.number("max_landmarks", o.max_landmarks, 10);
  io.positive("pixel_sigma_px", o.pose.pixel_sigma_px, kSigma_px);
  io.positive("gate_sigmas", o.pose.gate_sigmas);
  io.number("min_inliers", o.pose.min_inliers, 4);
  io.number("ransac_iterations", o.pose.ransac_iterations, 1, kMostIterations);
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
  io.positive("rigid_sigma_m", o.rigid_sigmas.translation_m, kSigma_m);
  io.positive("rigid_sigma_rad", o.rigid_sigmas.rotation_rad, kSigma_rad);
  io.positive("profile_sigma", o.profile_sigma, kSigmaOfRatio);
  io.flag("surface_points", o.surface_points);
  io.positive("surface_sigma_m", o.surface_sigma_m, kSigma_m);
  io.number("surface_sigma_radii", o.surface_sigma_radii, 0.0, 1.0);
  io.flag("extents", o.extents);
  io.flag("contacts", o.contacts);
  io.number("max_iterations", o.max_iterations, 1, kMostIterations);
}

template <typename Io>
void visit(Io& io, LifecycleOptions& o) {
  io.number("confirm_keyframes", o.confirm_keyframes, 1, 1000);
  io.number("restart_frames", o.restart_frames, 1);
  io.positive("acceleration_mps2", o.acceleration_mps2);
  io.positive("angular_acceleration_radps2", o.angular_acceleration_radps2);
  io.positive("search_after_s", o.search_after_s);
  io.positive("lost_after_s", o.lost_after_s);
  io.flag("ends_outside", o.ends_outside);
}

template <typename Io>
void visit(Io& io, TrajectorySmootherOptions& o) {
  io.positive("least_translation_sigma_m", o.least_translation_sigma_m, kSigma_m);
  io.positive("least_rotation_sigma_rad", o.least_rotation_sigma_rad, kSigma_rad);
  io.positive("guess_sigma_m", o.guess_sigma_m, kSigma_m);
  io.positive("guess_sigma_rad", o.guess_sigma_rad, kSigma_rad);
  io.positive("outlier", o.outlier);
  io.number("robust_rounds", o.robust_rounds, 1, 100);
  io.number("settle_s", o.settle_s, 0.0, 60.0);
  io.number("sudden", o.sudden, 1.0, 1e9);
  io.number("history_s", o.history_s, 0.0, 60.0);
}

template <typename Io>
void visit(Io& io, MotionDecisionOptions& o) {
  io.positive("window_s", o.window_s);
  io.positive("rest_s", o.rest_s);
  io.number("rest_poses", o.rest_poses, 2, 1000);
  io.positive("rest_sigmas", o.rest_sigmas);
  io.positive("moving_sigmas", o.moving_sigmas);
  io.positive("camera_sigma_m", o.camera_sigmas.translation_m, kSigma_m);
  io.positive("camera_sigma_rad", o.camera_sigmas.rotation_rad, kSigma_rad);
  io.positive("surface_sigma_m", o.surface_sigma_m, kSigma_m);
}

template <typename Io>
void visit(Io& io, CarvingOptions& o) {
  io.flag("enabled", o.enabled);
  io.number("cells", o.cells, 4, 128);
  io.number("views", o.views, 1, 60'000);
  io.positive("sigmas", o.sigmas);
  io.number("min_views", o.min_views, 1, 60'000);
  io.number("min_share", o.min_share, 0.0, 1.0);
  io.number("least_free", o.least_free, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, CloudAlignmentOptions& o) {
  io.number("max_points", o.max_points, 10, 1'000'000);
  io.positive("point_sigma_m", o.point_sigma_m, kSigma_m);
  io.positive("outline_sigma_px", o.outline_sigma_px, kSigma_px);
  io.positive("far_m", o.far_m);
  io.positive("near_m", o.near_m);
  io.number("min_normal_cosine", o.min_normal_cosine, 0.0, 1.0);
  io.number("min_matched", o.min_matched, 0.0, 1.0);
  io.number("min_lines", o.min_lines, 1, 1000);
  io.positive("max_distance_m", o.max_distance_m);
  io.positive("max_outline_px", o.max_outline_px);
  io.number("max_outline_share", o.max_outline_share, 0.0, 1.0);
  io.positive("turn_rad", o.turn_rad);
  io.number("turns", o.turns, 0, 6);
  io.positive("color_sigma", o.color_sigma, kSigmaOfRatio);
}

}  // namespace uniquadric
