#pragma once

#include <cstdint>
#include <filesystem>

#include "harness/external/external_variant.h"

namespace uniquadric {

struct ExternalOptions {
  std::uint64_t seed = 0;
  std::filesystem::path prompt;  ///< file or folder; empty: none
  bool force = false;            ///< replace an existing output folder
  bool verify = true;            ///< the sequence's text files against its hashes.txt
};

/// Runs a variant's program on a sequence folder and makes of its result a whole estimate folder at `out`
/// (camera.tum, objects/, objects.csv, camera.yaml, usage.csv, run.yaml). The program sees its sequence, its
/// inputs and the system, no network and nothing of the truth where bubblewrap can run (run.yaml: `isolation:
/// bubblewrap`), else a copy of the sequence elsewhere (`none`, and a warning). Throws InputError for a
/// sequence that lacks sensors, a program that fails or comes to a limit, and a result that is none or of
/// another sequence; then nothing is left at `out` and no process of the program runs.
void run_external(const std::filesystem::path& sequence, const ExternalVariant& variant,
                  const ExternalOptions& options, const std::filesystem::path& out);

}  // namespace uniquadric
