#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/config.h"
#include "core/base/config_overrides.h"

namespace uniquadric {

/// `realism: ideal | mild | real | harsh` of a map; without the key `ideal`.
std::string read_realism(const ConfigNode& node);

/// One key of a scene and what each level of `realism` sets it to, as YAML; empty: the level leaves it.
struct RealismRow {
  std::string_view key;
  std::string_view mild, real, harsh;
  bool in_frames = false;  ///< values are shares of the time between two frames, the key takes seconds
  std::string_view source;
};

/// What `realism: mild | real | harsh` sets, in the order of scenes/realism.md.
const std::vector<RealismRow>& realism_rows();

/// What `realism` of a scene adds to it: values of keys that the scene does not give itself. Rows of a
/// section `imu` or `lidar` count only where the scene has it. `ideal`, the default, adds nothing.
std::vector<ConfigOverride> realism_of(const ConfigNode& scene);

}  // namespace uniquadric
