#include "harness/commands/commands.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <iostream>

#include "core/base/apart.h"
#include "core/base/error.h"
#include "core/base/warning.h"
#include "core/sequence/sequence.h"
#include "estimator/estimate.h"
#include "harness/commands/options.h"
#include "harness/estimate_text.h"
#include "harness/external/run_external.h"

namespace uniquadric {

namespace {

// Options that only our own estimator has; those of `sub` that were given are refused.
void refuse_own_options(const CLI::App* sub, const std::string& variant) {
  for (const char* option : {"--perception", "--perception-seed", "--camera-only", "--set"})
    if (sub->get_option(option)->count() > 0)
      throw InputError(variant, fmt::format("is a variant with a command, which takes no {}", option));
}

constexpr const char* kSet = "a value in place of the variant's, as carving.enabled=false";

Variant choose_variant(const std::string& sequence, const std::string& variant,
                       const std::vector<std::string>& set) {
  const std::vector<ConfigOverride> overrides = parse_overrides(set);
  return variant.empty() ? default_variant(open_sequence(sequence), overrides)
                         : load_variant(variant, overrides);
}

}  // namespace

void add_estimate(CLI::App& app, Common& common) {
  auto* sub = subcommand(app, "estimate", "sequence -> 9-DoF tracks of every object", common);
  sub->get_option("--quiet")->description("no progress on stderr, no summary on stdout");
  static std::string sequence, out, variant, prompt = "everything", perception;
  static std::vector<std::string> set;
  static EstimateOptions options;
  sub->add_option("SEQUENCE", sequence, "sequence folder")->required();
  sub->add_option("OUT", out, "folder for the estimate")->required();
  sub->add_option("--perception", perception, "folder that keeps the perception stage's result, or has it");
  sub->add_option("--variant", variant, "variant file (YAML); default: ours for the sequence's sensors");
  add_set(sub, set, kSet);
  sub->add_option("--seed", options.seed, "of the estimator's own sampling")->check(whole_number());
  static std::uint64_t perception_seed = 0;
  auto* own_seed = sub->add_option("--perception-seed", perception_seed,
                                   "of the perception stage's, for seeds to share one; default: --seed")
                       ->check(whole_number());
  sub->add_option("--prompt", prompt, "everything, points:FILE, or boxes:FILE or folder");
  sub->add_flag("--camera-only", options.camera_only, "follow the camera or LiDAR alone: no objects");
  add_no_verify(sub, options.verify);
  add_stage_options(sub, common);
  sub->callback([&common, sub, own_seed] {
    if (own_seed->count() > 0) options.perception_seed = perception_seed;
    options.threads = common.threads;
    options.quiet = common.quiet;
    options.force = common.force;
    options.perception = perception;
    options.prompts = parse_prompts(prompt);
    require_apart(out, {sequence, variant, perception, options.prompts.path});
    require_apart(perception, {sequence, variant, options.prompts.path});
    if (!variant.empty() && is_external(variant)) {
      refuse_own_options(sub, variant);
      const ExternalVariant external = load_external_variant(variant);
      const ExternalOptions run{options.seed, options.prompts.path, options.force, options.verify};
      return make_stage(common, out, [&] { run_external(sequence, external, run, out); });
    }
    const Variant chosen = choose_variant(sequence, variant, set);
    make_stage(common, out, [&] {
      const auto start = std::chrono::steady_clock::now();
      estimate(sequence, chosen, options, out);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
      if (!options.quiet)
        std::cout << estimate_text(out)
                  << fmt::format("{:.1f} s, {} warnings\n", took.count(), warnings_given());
    });
  });
}

void add_perceive(CLI::App& app, Common& common) {
  auto* sub =
      subcommand(app, "perceive", "the perception stage of estimate alone, for variants to share", common);
  static std::string sequence, out, variant, prompt = "everything";
  static std::vector<std::string> set;
  static EstimateOptions options;
  sub->add_option("SEQUENCE", sequence, "sequence folder")->required();
  sub->add_option("OUT", out, "folder for its result, for estimate's --perception")->required();
  sub->add_option("--variant", variant, "variant file (YAML); default: ours for the sequence's sensors");
  add_set(sub, set, kSet);
  sub->add_option("--seed", options.seed, "of the estimator's own sampling")->check(whole_number());
  sub->add_option("--prompt", prompt, "everything, points:FILE, or boxes:FILE or folder");
  add_no_verify(sub, options.verify);
  add_stage_options(sub, common);
  sub->callback([&common] {
    options.threads = common.threads;
    options.quiet = common.quiet;
    options.force = common.force;
    options.perception = out;
    options.prompts = parse_prompts(prompt);
    require_apart(out, {sequence, variant, options.prompts.path});
    const Variant chosen = choose_variant(sequence, variant, set);
    make_stage(common, out, [&] { keep_perception(sequence, chosen, options); });
  });
}

}  // namespace uniquadric
