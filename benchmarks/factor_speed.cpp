// Time of one evaluation, residuals and Jacobians, of each factor.
#include <benchmark/benchmark.h>
#include <ceres/cost_function.h>

#include <array>
#include <memory>
#include <vector>

#include "estimator/factors/conic.h"
#include "estimator/factors/motion_model.h"
#include "estimator/factors/pose_block.h"
#include "estimator/factors/pose_prior.h"
#include "estimator/factors/reprojection.h"
#include "estimator/factors/shape_block.h"
#include "estimator/factors/surface_point.h"
#include "estimator/factors/tangent.h"

namespace {

using namespace uniquadric;

const Camera kCamera;
const Pose kWorldFromCamera{exp_so3({0.2, -0.4, 0.1}), {3, -2, 1}};
const PoseBlock kBody = pose_block(kWorldFromCamera * Pose{exp_so3({0.5, 0.3, 0.1}), {0.3, -0.1, 2.2}});
const PoseBlock kOffset = pose_block({exp_so3({0.1, 0.2, 0.3}), {0.05, 0, 0.02}});
const AxesBlock kAxes = axes_block({0.3, 0.15, 0.22});
const std::array<double, 3> kExponents = {0.3, -0.4, 1.0};
const std::array<double, 3> kPoint = {0.1, -0.2, 0.15};

void run(benchmark::State& state, std::unique_ptr<ceres::CostFunction> cost,
         std::vector<const double*> blocks) {
  std::vector<std::vector<double>> storage;
  std::vector<double*> jacobians;
  for (const int size : cost->parameter_block_sizes()) storage.emplace_back(size * cost->num_residuals());
  for (auto& block : storage) jacobians.push_back(block.data());
  std::array<double, 6> residuals{};
  for (auto _ : state) {
    cost->Evaluate(blocks.data(), residuals.data(), jacobians.data());
    benchmark::DoNotOptimize(residuals);
  }
}

Feature feature(bool depth) {
  Feature f;
  f.pixel = {350, 200};
  if (depth) f.depth_m = 2.3, f.depth_sigma_m = 0.011;
  return f;
}

TangentPlane plane() {
  return tangent_plane(kCamera, kWorldFromCamera, {{0.6, 0.8}, 350, true}, 2.2);
}

}  // namespace

int main(int argc, char** argv) {
  const auto add = [](const char* name, auto make, std::vector<const double*> blocks) {
    benchmark::RegisterBenchmark(name, [=](benchmark::State& state) { run(state, make(), blocks); });
  };
  const auto* body = kBody.data();
  const auto* offset = kOffset.data();
  add("reprojection", [] { return reprojection_factor(kCamera, kWorldFromCamera, feature(false), 1); },
      {body, kPoint.data()});
  add("reprojection with depth",
      [] { return reprojection_factor(kCamera, kWorldFromCamera, feature(true), 1); }, {body, kPoint.data()});
  for (const int exponents : {1, 3}) {
    add(exponents == 1 ? "tangent" : "tangent, three exponents",
        [=] {
          return tangent_factor(plane(), {exponents, 1});
        },
        {body, offset, kAxes.data(), kExponents.data()});
    add(exponents == 1 ? "surface point" : "surface point, three exponents",
        [=] {
          return surface_point_factor({0.2, 0.1, 0.15}, 0.01, exponents);
        },
        {offset, kAxes.data(), kExponents.data()});
  }
  for (const auto form : {ConicResidual::vector, ConicResidual::literal})
    add(form == ConicResidual::vector ? "conic, vector" : "conic, literal",
        [=] {
          return conic_factor(kCamera, kWorldFromCamera, {{330, 210}, 70, 45, 0.7}, {form, 0.02});
        },
        {body, offset, kAxes.data()});
  add("pose prior", [] { return pose_prior_factor(Pose{}, PoseSigmas{}); }, {body});
  for (const auto model : {MotionModel::straight, MotionModel::screw})
    add(model == MotionModel::straight ? "motion, straight" : "motion, screw",
        [=] { return motion_model_factor(1.2, model, {}); }, {body, offset, body});
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
