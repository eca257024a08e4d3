#pragma once

namespace CLI {
class App;
}

namespace uniquadric {

struct Common;

/// Each adds its subcommand to `app`: options, and a callback that calls one function. Both arguments must
/// outlive the parsing.
void add_generate(CLI::App& app, Common& common);
void add_simulate(CLI::App& app, Common& common);
void add_preview(CLI::App& app, Common& common);
void add_estimate(CLI::App& app, Common& common);
void add_perceive(CLI::App& app, Common& common);
void add_evaluate(CLI::App& app, Common& common);
void add_bench(CLI::App& app, Common& common);
void add_report(CLI::App& app, Common& common);
void add_compare(CLI::App& app, Common& common);
void add_history(CLI::App& app, Common& common);
void add_overlay(CLI::App& app, Common& common);
void add_scenery(CLI::App& app, Common& common);
void add_info(CLI::App& app, Common& common);
void add_metric(CLI::App& app, Common& common);
void add_trajectory(CLI::App& app, Common& common);
void add_import(CLI::App& app, Common& common);
void add_export(CLI::App& app, Common& common);
void add_check_result(CLI::App& app, Common& common);
void add_convert_result(CLI::App& app, Common& common);
void add_completion(CLI::App& app, Common& common);

}  // namespace uniquadric
