#include "estimator/variant.h"

#include "estimator/option_io.h"
#include "estimator/perception/aot_options.h"
#include "estimator/perception/segmentation_options.h"

namespace uniquadric {
namespace {

constexpr int kVariantSchema = 1;
constexpr int kMaxIterations = 1'000'000;             // hours: a typing error
constexpr double kLeastJump = 1e-4, kMostJump = 0.9;  // of relative depth: rounding, and all that there is
constexpr std::int64_t kMaxTimeOffset_ns = 10'000'000'000;

template <typename Io>
void visit(Io& io, PointOptions& o) {
  io.number("smooth_px", o.smooth_px, 0, 20);
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
  io.number("iterations", o.iterations, 1, kMaxIterations);
  io.number("sample_size", o.sample_size, 4);
  io.positive("inlier_threshold_m", o.inlier_threshold_m);
  io.number("best_weight", o.best_weight, 0.0, 1.0);
  io.positive("min_semi_axis_m", o.min_semi_axis_m);
}

template <typename Io>
void visit(Io& io, RigidMotionOptions& o) {
  io.positive("pixel_sigma", o.pixel_sigma);
  io.positive("pixel_gate", o.pixel_gate);
  io.positive("depth_gate", o.depth_gate);
  io.number("depth_slack_m", o.depth_slack_m, 0.0, 10.0);
  io.number("iterations", o.iterations, 1, kMaxIterations);
  io.number("min_inliers", o.min_inliers, 3, 10'000);
  io.number("min_share", o.min_share, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, EgoOptions& o) {
  io.number("keyframe_min_share", o.keyframe_min_share, 0.0, 1.0);
  io.positive("keyframe_shift", o.keyframe_shift);
  io.positive("keyframe_turn_rad", o.keyframe_turn_rad);
  io.number("keyframe_max_gap", o.keyframe_max_gap, 1, 10'000);
  io.number("window_keyframes", o.window_keyframes, 1, 10'000);
  io.flag("final_adjustment", o.final_adjustment);
  io.number("final_iterations", o.final_iterations, 1, 1000);
  io.section("pose", [&](auto& inner) { visit(inner, o.pose); });
  io.section("bundle", [&](auto& inner) {
    inner.positive("pixel_sigma", o.bundle.pixel_sigma);
    inner.positive("huber_sigmas", o.bundle.huber_sigmas);
    inner.positive("outlier_sigmas", o.bundle.outlier_sigmas);
    inner.number("iterations", o.bundle.iterations, 1, 1000);
  });
  io.section("loop", [&](auto& inner) {
    inner.number("min_gap_keyframes", o.loop.min_gap_keyframes, 1, 10'000);
    inner.number("min_points", o.loop.min_points, 3, 10'000);
    inner.positive("min_disagreement_px", o.loop.min_disagreement_px);
    inner.positive("loop_sigma", o.loop.loop_sigma);
    inner.section("motion", [&](auto& innermost) { visit(innermost, o.loop.motion); });
  });
  io.section("upright", [&](auto& inner) {
    inner.positive("plane_threshold_m", o.upright.plane_threshold_m);
    inner.number("min_share", o.upright.min_share, 0.0, 1.0);
    inner.number("max_tilt_deg", o.upright.max_tilt_deg, 0.0, 89.0);
    inner.positive("max_range_m", o.upright.max_range_m);
    inner.number("step_px", o.upright.step_px, 1, 100);
  });
}

template <typename Io>
void visit(Io& io, LidarMapOptions& o) {
  io.positive("cell_m", o.cell_m);
  io.number("neighbours", o.neighbours, 3, 27);
  io.number("min_neighbours", o.min_neighbours, 3, 27);
  io.number("levels", o.levels, 1, 8);
  io.positive("min_flatness", o.min_flatness);
  io.number("max_count", o.max_count, 1);
  io.positive("max_range_m", o.max_range_m);
  io.number("max_blocks", o.max_blocks, 1, 100'000'000);
}

template <typename Io>
void visit(Io& io, LidarEgoOptions& o) {
  LidarOdometryOptions& odometry = o.odometry;
  io.flag("use_imu", odometry.use_imu);
  io.choice("cut", o.cut, Choices<SweepCut>{{"frames", SweepCut::frames}, {"scans", SweepCut::scans}});
  io.number("imu_time_offset_ns", o.imu_time_offset_ns, -kMaxTimeOffset_ns, kMaxTimeOffset_ns);
  io.flag("use_masks", o.use_masks);
  io.positive("min_range_m", odometry.sweep.min_range_m);
  io.positive("max_range_m", odometry.sweep.max_range_m);
  io.positive("voxel_m", odometry.sweep.voxel_m);
  io.positive("max_scan_s", odometry.sweep.max_scan_s);
  io.section("map", [&](auto& inner) { visit(inner, odometry.map); });
  io.positive("acceleration_mps2_rthz", odometry.acceleration_mps2_rthz);
  io.positive("angular_acceleration_radps2_rthz", odometry.angular_acceleration_radps2_rthz);
  io.positive("range_sigma_m", odometry.sight.range_sigma_m);
  io.positive("beam_sigma_rad", odometry.sight.beam_sigma_rad);
  io.positive("plane_sigma_m", odometry.sight.plane_sigma_m);
  io.positive("max_thickness", odometry.sight.max_thickness);
  io.positive("side_points", odometry.sight.side_points);
  io.positive("gate_sigmas", odometry.sight.gate_sigmas);
  io.positive("gate_m", odometry.sight.gate_m);
  io.positive("open_gate_m", odometry.sight.open_gate_m);
  io.positive("huber_sigmas", odometry.sight.huber_sigmas);
  io.number("iterations", odometry.iterations, 1, 100);
  io.number("searches", odometry.sight.searches, 1, 100);
  io.number("min_points", odometry.sight.min_points, 6);
  io.positive("lost_sigma_m", odometry.lost_sigma_m);
  io.positive("first_velocity_mps", odometry.first_velocity_mps);
  io.number("first_sweeps", odometry.first_sweeps, 2, 1000);
  io.number("first_passes", odometry.first_passes, 1, 100);
}

template <typename Io>
void visit(Io& io, PlaneDepthOptions& o) {
  io.number("half_window_px", o.half_window_px, 1, 10);
  io.number("half_wide_px", o.half_wide_px, 0, 10);
  io.number("max_jump", o.max_jump, kLeastJump, kMostJump);
  io.number("min_share", o.min_share, 0.0, 1.0);
  io.positive("outlier_sigmas", o.outlier_sigmas);
  io.positive("agreement_sigmas", o.agreement_sigmas);
  io.number("curvature_share", o.curvature_share, 0.0, 10.0);
  io.number("min_sigma", o.min_sigma, 0.0, 1.0);
}

template <typename Io>
void visit(Io& io, GalleryOptions& o) {
  io.number("body_tracks", o.body_tracks, 0, 1'000'000);
  io.number("background_tracks", o.background_tracks, 0, 1'000'000);
  io.number("min_sightings", o.min_sightings, 1, 1000);
  io.number("max_distance", o.max_distance, 0, 256);
  io.number("max_ratio", o.max_ratio, 0.0, 1.0);
  io.number("min_matches", o.min_matches, 3, 10'000);
  io.number("min_share", o.min_share, 0.0, 1.0);
  io.positive("pixel_gate", o.pixel_gate);
}

template <typename Io>
void visit(Io& io, FeatureOptions& o) {
  io.number("body_features", o.body_features, 8, 10'000);
  io.number("background_features", o.background_features, 8, 100'000);
  io.number("fast_threshold", o.fast_threshold, 1, 255);
  io.positive("min_distance_px", o.min_distance_px);
  io.number("start_margin_px", o.start_margin_px, 1, 100);
  io.number("keep_margin_px", o.keep_margin_px, 1, 100);
  io.number("max_missed", o.max_missed, 0, 1000);
  io.number("max_prediction_gap_s", o.max_prediction_gap_s, 0.0, 1e6);
  io.number("max_anchor_warp", o.max_anchor_warp, 1.0, 10.0);
  io.number("min_anchor_correlation", o.min_anchor_correlation, 0.0, 1.0);
  io.positive("max_pixel_sigma", o.max_pixel_sigma);
  io.positive("max_slip_px", o.max_slip_px);
  io.positive("aligned_pixel_gate", o.aligned_pixel_gate);
  io.section("flow", [&](auto& inner) {
    inner.number("window_px", o.flow.window_px, 3, 100);
    inner.number("levels", o.flow.levels, 0, 8);
    inner.number("iterations", o.flow.iterations, 1, 1000);
    inner.positive("min_eigenvalue", o.flow.min_eigenvalue);
    inner.positive("max_round_trip_px", o.flow.max_round_trip_px);
  });
  io.section("alignment", [&](auto& inner) {
    inner.number("half_window_px", o.alignment.half_window_px, 2, 8);
    inner.number("iterations", o.alignment.iterations, 1, 1000);
    inner.positive("max_shift_px", o.alignment.max_shift_px);
    inner.number("min_correlation", o.alignment.min_correlation, 0.0, 1.0);
  });
  io.section("depth", [&](auto& inner) { visit(inner, o.depth); });
  io.section("motion", [&](auto& inner) { visit(inner, o.motion); });
  io.section("gallery", [&](auto& inner) { visit(inner, o.gallery); });
}

template <typename Io>
void visit(Io& io, SilhouetteOptions& o) {
  io.number("directions", o.directions, 4, 360);
  io.number("min_pixels", o.min_pixels, 1, 1'000'000);
  io.number("min_share", o.min_share, 0.0, 1.0);
  io.number("outline_noise_px", o.outline_noise_px, 0.0, 100.0);
  io.positive("outline_length_px", o.outline_length_px);
  io.number("border_px", o.border_px, 0.0, 100.0);
  io.number("touch_px", o.touch_px, 0.0, 100.0);
  io.number("cut_share", o.cut_share, 0.0, 1.0);
  io.positive("occluder_jump", o.occluder_jump);
  io.number("occluder_reach_px", o.occluder_reach_px, 1, 100);
}

template <typename Io>
void visit(Io& io, BodyTwistOptions& o) {
  io.positive("first_velocity_mps", o.first_velocity_mps);
  io.positive("first_turn_radps", o.first_turn_radps);
  io.positive("acceleration_mps2_rthz", o.acceleration_mps2_rthz);
  io.positive("turn_acceleration_radps2_rthz", o.turn_acceleration_radps2_rthz);
  io.number("reach_px", o.reach_px, 0.5, 200.0);
  io.number("neighbours", o.neighbours, 5, 1000);
  io.number("max_jump", o.max_jump, kLeastJump, kMostJump);
  io.number("max_points", o.max_points, 10, 1'000'000);
  io.positive("pixel_sigma", o.pixel_sigma);
  io.number("rows_as_one", o.rows_as_one, 1.0, 1e6);
}

template <typename Io>
void visit(Io& io, PointPlaneOptions& o) {
  io.number("reach_px", o.reach_px, 0.5, 200.0);
  io.number("neighbours", o.neighbours, 4, 1000);
  io.number("min_neighbours", o.min_neighbours, 4, 1000);
  io.number("max_jump", o.max_jump, kLeastJump, kMostJump);
}

template <typename Io>
void visit(Io& io, LidarDepthOptions& o) {
  io.choice("undistortion", o.undistortion,
            Choices<Undistortion>{
                {"none", Undistortion::none}, {"ego", Undistortion::ego}, {"object", Undistortion::object}});
  io.choice("motion", o.motion,
            Choices<MotionSource>{{"points", MotionSource::points}, {"features", MotionSource::features}});
  io.positive("motion_window_s", o.motion_window_s);
  io.section("twist", [&](auto& inner) { visit(inner, o.twist); });
  io.positive("window_s", o.window_s);
  io.number("erode_px", o.erode_px, 0, 100);
  visit(io, o.planes);
  io.number("max_points", o.max_points, 1, 1'000'000);
}

template <typename Io>
void visit(Io& io, ScanObjectOptions& o) {
  io.flag("enabled", o.enabled);
  io.positive("cell_m", o.clusters.cell_m);
  io.number("ground_tilt_deg", o.clusters.ground_tilt_deg, 0.0, 60.0);
  io.number("ground_samples", o.clusters.ground_samples, 1, kMaxIterations);
  io.positive("ground_m", o.clusters.ground_m);
  io.positive("tolerance_m", o.clusters.tolerance_m);
  io.number("min_points", o.clusters.min_points, 4, 1'000'000);
  io.positive("min_height_m", o.clusters.min_height_m);
  io.positive("max_extent_m", o.clusters.max_extent_m);
  io.number("window_scans", o.tracker.window_scans, 3, 1000);
  io.number("confirm_scans", o.tracker.confirm_scans, 1, 1000);
  io.flag("moving_only", o.tracker.moving_only);
  io.number("moving_scans", o.tracker.moving_scans, 1, 1000);
  io.positive("min_speed_mps", o.tracker.min_speed_mps);
  io.positive("max_stretch_mps", o.tracker.max_stretch_mps);
  io.number("min_overlap", o.tracker.min_overlap, 0.0, 1.0);
  io.number("patience_scans", o.tracker.patience_scans, 0, 1000);
  io.number("width_deg", o.width_deg, 1.0, 160.0);
  io.number("height_deg", o.height_deg, 1.0, 160.0);
  io.number("focal_px", o.focal_px, 10.0, 2000.0);
  io.number("rim_px", o.rim_px, 0.0, 1000.0);
  io.number("motion_scans", o.motion_scans, 0);
  visit(io, o.planes);
  io.number("max_points", o.max_points, 1, 1'000'000);
}

template <typename Io>
void visit(Io& io, CloudAlignmentOptions& o) {
  io.number("max_points", o.max_points, 10, 1'000'000);
  io.positive("point_sigma_m", o.point_sigma_m);
  io.positive("outline_sigma_px", o.outline_sigma_px);
  io.positive("far_m", o.far_m);
  io.positive("near_m", o.near_m);
  io.positive("max_distance_m", o.max_distance_m);
  io.positive("max_outline_px", o.max_outline_px);
  io.positive("turn_rad", o.turn_rad);
  io.number("turns", o.turns, 0, 6);
  io.positive("color_sigma", o.color_sigma);
}

template <typename Io>
void visit(Io& io, PerceptionOptions& o) {
  io.section("lidar", [&](auto& inner) {
    inner.number("time_offset_ns", o.lidar_time_offset_ns, -kMaxTimeOffset_ns, kMaxTimeOffset_ns);
  });
  io.section("ego", [&](auto& inner) {
    inner.choice("source", o.ego,
                 Choices<EgoSource>{
                     {"given", EgoSource::given}, {"rgbd", EgoSource::rgbd}, {"lidar", EgoSource::lidar}});
    visit(inner, o.odometry);
    inner.section("lidar", [&](auto& innermost) { visit(innermost, o.lidar); });
  });
  io.section("depth", [&](auto& inner) {
    inner.choice("source", o.depth,
                 Choices<DepthSource>{{"recorded", DepthSource::recorded},
                                      {"images", DepthSource::images},
                                      {"lidar", DepthSource::lidar}});
    inner.section("lidar", [&](auto& innermost) { visit(innermost, o.lidar_depth); });
  });
  io.section("segmentation", [&](auto& inner) { visit(inner, o.segmentation); });
  io.section("aot", [&](auto& inner) { visit(inner, o.aot); });
  io.section("features", [&](auto& inner) { visit(inner, o.features); });
  io.section("silhouettes", [&](auto& inner) { visit(inner, o.silhouettes); });
  io.section("points", [&](auto& inner) { visit(inner, o.points); });
  io.section("scan_objects", [&](auto& inner) { visit(inner, o.scan_objects); });
}

template <typename Io>
void visit(Io& io, ShortWindowOptions& o) {
  io.number("keyframes", o.keyframes, 3, 100);
  io.positive("keyframe_turn_deg", o.keyframe_turn_deg);
  io.number("keyframe_share", o.keyframe_share, 0.0, 1.0);
  io.number("keyframe_gap", o.keyframe_gap, 1, 1000);
  io.flag("motion_model", o.motion_model);
  io.positive("acceleration_noise", o.motion_noise.acceleration);
  io.positive("angular_acceleration_noise", o.motion_noise.angular_acceleration);
  io.flag("rest_factor", o.rest_factor);
  io.flag("marginal_prior", o.marginal_prior);
  io.number("max_landmarks", o.max_landmarks, 10);
  io.positive("pixel_sigma_px", o.pose.pixel_sigma_px);
  io.positive("gate_sigmas", o.pose.gate_sigmas);
  io.number("min_inliers", o.pose.min_inliers, 4);
  io.number("ransac_iterations", o.pose.ransac_iterations, 1, kMaxIterations);
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
  io.number("exponents", o.exponents, 0, 3);
  io.positive("outline_sigma_px", o.outline_sigma_px);
  io.choice("outline_noise", o.outline_noise,
            Choices<OutlineNoise>{{"given", OutlineNoise::given}, {"measured", OutlineNoise::measured}});
  io.flag("segmented_outlines", o.segmented_outlines);
  io.choice("axis_prior", o.axis_prior,
            Choices<AxisPrior>{{"none", AxisPrior::none},
                               {"mean", AxisPrior::mean},
                               {"inverse_variance", AxisPrior::inverse_variance},
                               {"renyi", AxisPrior::renyi},
                               {"literal", AxisPrior::literal},
                               {"accumulated", AxisPrior::accumulated}});
  io.choice("axis_samples", o.axis_samples,
            Choices<AxisSamples>{{"boxes", AxisSamples::boxes}, {"extents", AxisSamples::extents}});
  io.choice("rigid_prior", o.rigid_prior,
            Choices<RigidPrior>{
                {"none", RigidPrior::none}, {"soft", RigidPrior::soft}, {"hard", RigidPrior::hard}});
  io.positive("rigid_sigma_m", o.rigid_sigmas.translation_m);
  io.positive("rigid_sigma_rad", o.rigid_sigmas.rotation_rad);
  io.flag("surface_points", o.surface_points);
  io.positive("surface_sigma_m", o.surface_sigma_m);
  io.flag("extents", o.extents);
  io.flag("depth_sides", o.depth_sides);
  io.number("max_iterations", o.max_iterations, 1, kMaxIterations);
}

template <typename Io>
void visit(Io& io, LifecycleOptions& o) {
  io.number("confirm_keyframes", o.confirm_keyframes, 1, 1000);
  io.number("restart_frames", o.restart_frames, 1);
  io.positive("search_after_s", o.search_after_s);
  io.positive("lost_after_s", o.lost_after_s);
}

template <typename Io>
void visit(Io& io, TrajectorySmootherOptions& o) {
  io.positive("least_translation_sigma_m", o.least_translation_sigma_m);
  io.positive("least_rotation_sigma_rad", o.least_rotation_sigma_rad);
  io.positive("guess_sigma_m", o.guess_sigma_m);
  io.positive("guess_sigma_rad", o.guess_sigma_rad);
  io.positive("outlier", o.outlier);
  io.number("robust_rounds", o.robust_rounds, 1, 100);
}

template <typename Io>
void visit(Io& io, MotionDecisionOptions& o) {
  io.positive("window_s", o.window_s);
  io.positive("rest_s", o.rest_s);
  io.number("rest_poses", o.rest_poses, 2, 1000);
  io.positive("rest_sigmas", o.rest_sigmas);
  io.positive("moving_sigmas", o.moving_sigmas);
  io.positive("camera_sigma_m", o.camera_sigmas.translation_m);
  io.positive("camera_sigma_rad", o.camera_sigmas.rotation_rad);
  io.positive("surface_sigma_m", o.surface_sigma_m);
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
    inner.section("obb", [&](auto& innermost) { visit(innermost, o.body.shape.obb); });
  });
  io.section("short_window", [&](auto& inner) { visit(inner, o.body.short_window); });
  io.section("long_window", [&](auto& inner) { visit(inner, o.body.shape.long_window); });
  io.section("motion_decision", [&](auto& inner) { visit(inner, o.body.motion); });
  io.section("lifecycle", [&](auto& inner) { visit(inner, o.body.lifecycle); });
  io.section("cloud_alignment", [&](auto& inner) { visit(inner, o.body.alignment); });
  io.section("trajectory", [&](auto& inner) { visit(inner, o.body.trajectory); });
  io.choice("backend", o.backend,
            Choices<Backend>{{"single_frame", Backend::single_frame}, {"windows", Backend::windows}});
  io.choice(
      "parameterisation", o.body.parameterisation,
      Choices<Parameterisation>{{"object", Parameterisation::object}, {"global", Parameterisation::global}});
  io.choice("feedback", o.feedback,
            Choices<Feedback>{{"perception", Feedback::perception}, {"backend", Feedback::backend}});
  io.section("joined", [&](auto& inner) {
    inner.number("envelope_margin", o.joined.envelope_margin, 0.0, 100.0);
    inner.number("envelope_slack_m", o.joined.envelope_slack_m, 0.0, 100.0);
  });
  io.choice("output", o.output, Choices<Output>{{"causal", Output::causal}, {"final", Output::final}});
}

}  // namespace

Variant default_variant() {
  Variant variant;
  variant.perception.points.smooth_px = 0;  // windows, which all else is for, take the noise off first
  return variant;
}

Variant load_variant(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::load(path);
  root.at("schema");
  Variant variant;
  variant.name = std::filesystem::is_regular_file(path) ? path.stem().string() : "piped";
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

std::string perception_yaml(const Variant& variant) {
  PerceptionOptions copy = variant.perception;
  OptionWriter writer;
  visit(writer, copy);
  return writer.yaml();
}

}  // namespace uniquadric
