#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace uniquadric {

/// The files of an estimate folder whose stamps step as those in another unit do: seconds are expected in
/// .tum files, nanoseconds in objects.csv. A line a file, naming it and the unit. Only stamps are read; files
/// whose stamps are no numbers are passed over.
std::vector<std::string> stamp_unit_faults(const std::filesystem::path& folder);

}  // namespace uniquadric
