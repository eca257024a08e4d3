// How often `compare` finds a loss, by the noise of a pair: gate_power [TRIALS]. Six sequences of 8 seeds and
// one object, 10 or 30 metrics that are errors; d = ln(B / A) of each is normal with the standard deviation
// given, of its own for each metric, and one metric of B is worse as the column says. Prints the share of
// comparisons that answer `worse`, those without a loss being false alarms.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "core/base/random.h"
#include "evaluation/comparison/score_comparison.h"

namespace uniquadric {
namespace {

constexpr int kSequences = 6, kSeeds = 8;

struct Loss {
  const char* name;
  double factor;
  int sequences;  // that lose it, from the first
};
constexpr Loss kLosses[] = {{"none", 1, 0},
                            {"5 % of one metric", 1.05, kSequences},
                            {"10 % of one metric", 1.1, kSequences},
                            {"30 % on one of six", 1.3, 1},
                            {"50 % on one of six", 1.5, 1}};

double found(int metrics, double noise, const Loss& loss, int trials) {
  int worse = 0;
  for (int trial = 0; trial < trials; ++trial) {
    RandomStream random(1, fmt::format("{}/{}/{}", metrics, noise, loss.name),
                        static_cast<std::uint64_t>(trial));
    ScoreTable a{"a", {}, {}, {}}, b{"b", {}, {}, {}};
    for (int metric = 0; metric < metrics; ++metric) {
      const std::string name = fmt::format("error_{}_m", metric);
      a.lower_is_better[name] = b.lower_is_better[name] = true;
      for (int sequence = 0; sequence < kSequences; ++sequence)
        for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
          const ScoreKey key = {{"v", fmt::format("s{}", sequence), seed}, "object", name};
          const double factor = metric == 0 && sequence < loss.sequences ? loss.factor : 1;
          a.cells[key] = 0.1;
          b.cells[key] = 0.1 * factor * std::exp(noise * random.normal());
        }
    }
    worse += compare_scores(a, b).answer == GateAnswer::worse;
  }
  return static_cast<double>(worse) / trials;
}

}  // namespace
}  // namespace uniquadric

int main(int argc, char** argv) {
  using namespace uniquadric;
  const int trials = argc > 1 ? std::atoi(argv[1]) : 200;
  for (const int metrics : {10, 30}) {
    fmt::print("\n{} metrics, {} trials:\n\n| noise of a pair |", metrics, trials);
    for (const Loss& loss : kLosses) fmt::print(" {} |", loss.name);
    fmt::print("\n| ---: |");
    for ([[maybe_unused]] const Loss& loss : kLosses) fmt::print(" ---: |");
    for (const double noise : {0.02, 0.05, 0.07, 0.1, 0.15, 0.2}) {
      fmt::print("\n| {} |", noise);
      for (const Loss& loss : kLosses) fmt::print(" {:.2f} |", found(metrics, noise, loss, trials));
    }
    fmt::print("\n");
  }
}
