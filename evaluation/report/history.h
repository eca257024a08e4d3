#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace uniquadric {

/// What became of the metrics from one results folder of `bench` to the next, oldest first.
struct History {
  std::string
      text;  ///< a table for people: a row a folder, and what the gate says of it against the one before
  std::string html;  ///< the same as a page that needs nothing else, with a curve a metric and variant
};

/// Reads the folders. A figure is the median over the objects of all scenes, each the median over its seeds.
/// A folder goes by the commit in its program.txt, else by its name. Throws InputError for what is no results
/// folder, or has no scores.csv, and for fewer than two folders.
History history(const std::vector<std::filesystem::path>& folders);

}  // namespace uniquadric
