// The windows' solver time against minimal problems of the same size: window_speed SEQUENCE [VARIANT.yaml]
// Estimates the sequence (camera poses given, one thread). Each problem that a window hands to Ceres is
// solved a second time as a minimal twin: as many blocks of the same tangent sizes, constant where ours are,
// as many residuals of each, the same elimination order, linear solver and number of iterations; but its
// costs are squares with analytic derivatives, and there is no loss or manifold. Processor time of
// ceres::Solve, which the linker wraps (CMakeLists.txt); how long the windows take to build their problems is
// not in it.
#include <ceres/ceres.h>
#include <fmt/format.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "estimator/estimate.h"

namespace uniquadric {
namespace {

struct Totals {
  int solves = 0, iterations = 0;
  std::int64_t residuals = 0, blocks = 0;
  double ours_ms = 0, minimal_ms = 0;
};
std::map<std::string, Totals> totals;  // by window

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Residual i is y^2, y = sum over all numbers x_j of c_(i + j) x_j. A Gauss-Newton step halves x, so that no
// iteration is the last one.
class SquareCost : public ceres::CostFunction {
 public:
  SquareCost(int residuals, const std::vector<int>& sizes) {
    set_num_residuals(residuals);
    *mutable_parameter_block_sizes() = sizes;
  }
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override {
    constexpr double kCoefficients[8] = {0.9, -0.4, 0.7, 0.2, -0.8, 0.5, -0.3, 0.6};
    const auto& sizes = parameter_block_sizes();
    for (int i = 0; i < num_residuals(); ++i) {
      double y = 0;
      for (std::size_t b = 0, k = i; b < sizes.size(); ++b)
        for (int j = 0; j < sizes[b]; ++j, ++k) y += kCoefficients[k % 8] * x[b][j];
      residuals[i] = y * y;
      for (std::size_t b = 0, k = i; jacobians && b < sizes.size(); ++b)
        for (int j = 0; j < sizes[b]; ++j, ++k)
          if (jacobians[b]) jacobians[b][i * sizes[b] + j] = 2 * y * kCoefficients[k % 8];
    }
    return true;
  }
};

// Of another problem: blocks of the same tangent sizes, costs of the same shapes.
struct Twin {
  ceres::Problem problem;
  std::vector<std::vector<double>> values;
  ceres::Solver::Options options;

  Twin(const ceres::Problem& ours, const ceres::Solver::Options& our_options) : options(our_options) {
    std::vector<double*> blocks;
    ours.GetParameterBlocks(&blocks);
    std::map<const double*, double*> twin_of;
    values.reserve(blocks.size());
    if (options.linear_solver_ordering)
      options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (double* block : blocks) {
      double* twin = values.emplace_back(ours.ParameterBlockTangentSize(block), 1.0).data();
      twin_of[block] = twin;
      problem.AddParameterBlock(twin, static_cast<int>(values.back().size()));
      if (ours.IsParameterBlockConstant(block)) problem.SetParameterBlockConstant(twin);
      if (options.linear_solver_ordering)
        options.linear_solver_ordering->AddElementToGroup(twin,
                                                          our_options.linear_solver_ordering->GroupId(block));
    }
    std::vector<ceres::ResidualBlockId> costs;
    ours.GetResidualBlocks(&costs);
    for (const ceres::ResidualBlockId cost : costs) {
      ours.GetParameterBlocksForResidualBlock(cost, &blocks);
      std::vector<int> sizes;
      for (double*& block : blocks) {
        sizes.push_back(ours.ParameterBlockTangentSize(block));
        block = twin_of.at(block);
      }
      const int residuals = ours.GetCostFunctionForResidualBlock(cost)->num_residuals();
      problem.AddResidualBlock(new SquareCost(residuals, sizes), nullptr, blocks);
    }
  }
};

}  // namespace

extern "C" {
// ceres::Solve as the linker finds it, and what it gives to everybody else in this program.
void __real__ZN5ceres5SolveERKNS_6Solver7OptionsEPNS_7ProblemEPNS0_7SummaryE(const ceres::Solver::Options&,
                                                                             ceres::Problem*,
                                                                             ceres::Solver::Summary*);
void __wrap__ZN5ceres5SolveERKNS_6Solver7OptionsEPNS_7ProblemEPNS0_7SummaryE(
    const ceres::Solver::Options& options, ceres::Problem* problem, ceres::Solver::Summary* summary) {
  const auto solve = __real__ZN5ceres5SolveERKNS_6Solver7OptionsEPNS_7ProblemEPNS0_7SummaryE;
  Twin twin(*problem, options);
  const double start = cpu_ms();
  solve(options, problem, summary);
  const double middle = cpu_ms();
  const auto iterations = static_cast<int>(summary->iterations.size()) - 1;
  twin.options.max_num_iterations = std::max(1, iterations);
  twin.options.function_tolerance = twin.options.gradient_tolerance = twin.options.parameter_tolerance = 0;
  ceres::Solver::Summary minimal;
  const double before = cpu_ms();
  solve(twin.options, &twin.problem, &minimal);
  const double after = cpu_ms();
  // a twin that stopped early, or a window that needed no step, compares nothing
  if (iterations < 1 || static_cast<int>(minimal.iterations.size()) - 1 != iterations) {
    ++totals["left out"].solves;
    return;
  }
  Totals& sum = totals[options.linear_solver_type == ceres::DENSE_QR ? "long window" : "short window"];
  ++sum.solves;
  sum.iterations += iterations;
  sum.residuals += problem->NumResiduals();
  sum.blocks += problem->NumParameterBlocks();
  sum.ours_ms += middle - start;
  sum.minimal_ms += after - before;
}
}

namespace {

void run(int argc, char** argv) {
  Variant variant = load_variant(argc > 2 ? argv[2] : "configs/variants/superquadric.yaml");
  variant.perception.ego = EgoSource::given;
  EstimateOptions options;
  options.threads = 1;
  options.quiet = options.force = true;
  const std::filesystem::path out =
      std::filesystem::temp_directory_path() / fmt::format("window_speed.{}", getpid());
  estimate(argv[1], variant, options, out);
  std::filesystem::remove_all(out);
  for (const auto& [window, sum] : totals) {
    const double n = sum.solves;
    fmt::print("{}: {} solves", window, sum.solves);
    if (sum.iterations > 0)
      fmt::print(
          ", {:.0f} residuals, {:.0f} blocks, {:.1f} iterations each: {:.3f} ms, minimal {:.3f} ms, ratio "
          "{:.3f}",
          static_cast<double>(sum.residuals) / n, static_cast<double>(sum.blocks) / n, sum.iterations / n,
          sum.ours_ms / n, sum.minimal_ms / n, sum.minimal_ms / sum.ours_ms);
    fmt::print("\n");
  }
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: window_speed SEQUENCE [VARIANT.yaml]\n");
    return 2;
  }
  try {
    uniquadric::run(argc, argv);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 2;
  }
}
