#pragma once

#include <filesystem>
#include <string>

namespace uniquadric {

/// A results folder written by hand: scene `s`, variants `a` and `b`, seed 1; `b` failed.
void write_small_results(const std::filesystem::path& folder);

/// Writes a file of a test, with the folders above it.
void write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace uniquadric
