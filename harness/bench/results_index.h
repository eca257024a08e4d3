#pragma once

#include <filesystem>
#include <string>

#include "harness/bench/plan.h"

namespace uniquadric {

/// Whether every stage of the cell stands in the results, whole.
bool is_done(const BenchPlan& plan, const BenchSimulation& simulation, const BenchCell& cell);

/// Sets the failures of the cells that are not done by what their stages' logs end with; a cell of which
/// nothing is told was not run. Returns the number of cells that are not done.
int find_failures(BenchPlan& plan);

/// Writes cells.csv, command.txt, hardware.txt, program.txt and inputs.csv, and the report of the cells that
/// are done.
void write_results(const BenchPlan& plan, const std::string& command);

}  // namespace uniquadric
