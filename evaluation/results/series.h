#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluation/results/results.h"

namespace uniquadric {

/// An object of an evaluation: its true id and the name it has in scores.csv.
struct NamedObject {
  long long id = 0;
  std::string subject;
};

/// Reads frames.csv: one series an object, in the order of `objects`. Columns are found by their header;
/// those the report does not know are read like the others. Throws InputError with file, line and column.
std::vector<ObjectSeries> read_series(const std::filesystem::path& file,
                                      const std::vector<NamedObject>& objects);

}  // namespace uniquadric
