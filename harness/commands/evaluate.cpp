#include "harness/commands/commands.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "core/base/apart.h"
#include "evaluation/evaluate.h"
#include "evaluation/results/results.h"
#include "evaluation/results/summary.h"
#include "harness/commands/options.h"

namespace uniquadric {

void add_evaluate(CLI::App& app, Common& common) {
  auto* sub =
      subcommand(app, "evaluate", "truth and estimate -> evaluation.json, frames.csv, poses.csv", common);
  static std::string truth, estimate_folder, out;
  static EvaluateOptions options;
  sub->get_option("--quiet")->description("no table on stdout");
  sub->add_option("TRUTH", truth, "truth folder; of a recording without one, its sequence folder")
      ->required();
  sub->add_option("ESTIMATE", estimate_folder, "estimate folder")->required();
  sub->add_option("OUT", out, "folder for the evaluation")->required();
  sub->add_option("--samples", options.iou_samples, "of the Monte Carlo 3D IoU")
      ->check(whole_number(1, kMaxCount));
  sub->add_option("--seed", options.seed, "of those samples")->check(whole_number());
  static std::string alignment = "auto";
  sub->add_option(
         "--align", alignment,
         "the estimate's world with the truth's, by the camera; auto: none where its poses were given, "
         "else poses")
      ->check(CLI::IsMember({"auto", "none", "first", "se3", "sim3", "scale", "posyaw", "poses"}));
  static std::string body_frame = "none";
  sub->add_option("--body-frame", body_frame, "each object's frame with the true one, for its pose errors")
      ->check(CLI::IsMember({"none", "first", "fit"}));
  static std::string objects = "all", unlabelled = "auto";
  sub->add_option("--objects", objects,
                  "which are scored, with commas: all, moving, in_view, labelled, or classes such as car");
  sub->add_option("--unlabelled", unlabelled,
                  "estimates that no label speaks of: ignore or false; auto: ignore where labels are partial")
      ->check(CLI::IsMember({"auto", "ignore", "false"}));
  add_no_verify(sub, options.verify);
  add_stage_options(sub, common);
  sub->callback([&common] {
    options.quiet = common.quiet;
    options.force = common.force;
    options.alignment = parse_alignment_kind(alignment);
    options.objects = parse_object_choice(objects);
    if (unlabelled != "auto")
      options.unlabelled = unlabelled == "ignore" ? Unlabelled::ignored : Unlabelled::counted_false;
    options.body_frame = *parse_body_frame(body_frame);
    require_apart(out, {truth, estimate_folder});
    make_stage(common, out, [] { evaluate(truth, estimate_folder, options, out); });
    if (!options.quiet) std::cout << evaluation_text(read_cell_evaluation(out));
  });
}

}  // namespace uniquadric
