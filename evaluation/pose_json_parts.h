#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "evaluation/align/alignment.h"
#include "evaluation/statistics/statistics.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

/// STATS of the JSON files; null where there were no values.
nlohmann::json to_json(const std::optional<Statistics>& statistics);

/// Kind, and the transform as position_m, quaternion_xyzw and scale under the name `transform`.
nlohmann::json to_json(AlignmentKind kind, const Alignment& alignment, const char* transform);

/// The first-pose form of the drift; null where there are no pairs.
nlohmann::json to_json(const std::optional<Drift>& drift);

}  // namespace uniquadric
