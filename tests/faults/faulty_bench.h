#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <string>

#include "tests/harness/program.h"

namespace uniquadric {

/// What stands in a results folder, by path: every file's bytes but for measured times. Folders and files in
/// the making (*.partial), logs and what is measured alone are left out.
std::map<std::string, std::string> results_in(const std::filesystem::path& out);

/// Expects that nothing in a results folder is torn: every file is one of `whole` with the same bytes.
void expect_nothing_torn(const std::filesystem::path& out, const std::map<std::string, std::string>& whole);

/// Without the sequences and what was perceived of them, which go when they are no longer needed.
std::map<std::string, std::string> without_sequences(std::map<std::string, std::string> results);

/// A bench of two cells on a small scene, in `folder`; `extra`: more lines for the bench file.
std::filesystem::path write_faulty_bench(const std::filesystem::path& folder, const std::string& extra = "");

/// Runs it with a fault (fault_preload.cpp).
ProgramRun run_with_fault(const std::string& fault, const std::filesystem::path& bench,
                          const std::filesystem::path& out);

/// Starts it.
pid_t start_bench(const std::filesystem::path& bench, const std::filesystem::path& out);

/// SIGKILL to the process alone, or also to all that it started, these first; then waits for it. Returns
/// whether it had ended well before.
bool kill_bench(pid_t process, bool with_children);

}  // namespace uniquadric
