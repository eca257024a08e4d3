#pragma once

#include <filesystem>
#include <vector>

#include "simulator/scene/motion.h"
#include "simulator/scene/pose_reader.h"

namespace uniquadric {

/// Reads the keys of `kind: spline` (scenes/README.md) and leaves unknown ones to the caller's check. Warns
/// once of a spline that swings far out between two way-points. Throws InputError with file and line.
Motion read_spline(const ConfigNode& node, Mover mover);

/// The same of `kind: recorded`, whose file is appended to `files`. Warns of a record that has no time with
/// the scene, which runs from 0 to `end_s`, in common.
Motion read_recorded(const ConfigNode& node, std::vector<std::filesystem::path>& files, double end_s);

}  // namespace uniquadric
