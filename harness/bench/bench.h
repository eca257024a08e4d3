#pragma once

#include <filesystem>
#include <string>

namespace uniquadric {

struct BenchOptions {
  int jobs = 0;  ///< stages at once; 0: as many as the machine has cores
  bool quiet = false;
  bool keep_sequences = false;  ///< beside the configuration's own wish
  bool collect = false;         ///< run no stage: the report of what is there
  std::string command;          ///< the command line, for the report
};

/// Runs scenes x variants x seeds of a bench file into `out` and writes the report. Stages run as processes
/// of this program, so that one that fails, crashes or hangs costs its own cell alone; stages whose inputs
/// and code have not changed are not run again. Returns the number of cells without a result. Throws
/// InputError for a bad configuration, scene or variant before any stage runs, and for an `out` that is
/// neither new, empty nor a bench's (which has bench.yaml from the start).
int bench(const std::filesystem::path& config, const std::filesystem::path& out, const BenchOptions& options);

}  // namespace uniquadric
