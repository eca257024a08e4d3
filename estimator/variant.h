#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/config_overrides.h"
#include "estimator/objects/body_estimator.h"
#include "estimator/objects/joined_backend.h"
#include "estimator/perception/perceive.h"
#include "estimator/plausibility/plausibility_options.h"
#include "estimator/shape/obb_ransac.h"
#include "estimator/upright/upright_options.h"

namespace uniquadric {

/// What turns the observations of the frames into states.
enum class Backend {
  single_frame,  ///< each frame by itself: the paper's baseline
  windows,       ///< the dual sliding window
  upright,       ///< a box on the ground that moves along its length, by what its ends show
};

/// Which of an object's 24 equivalent frames a state of `single_frame` is written in.
enum class AxisNaming {
  world,  ///< axes nearest to the world's: frames are named without memory, but a body that turns is renamed
  previous,  ///< axes nearest to the object's last state (the world's for the first): names follow the body
};

/// What the tracking of features knows beforehand of how the bodies move and what they cover.
enum class Feedback {
  perception,  ///< perception's own motions from frame to frame: its result can be kept and shared
  backend,     ///< paper: the back end's prediction and quadric of each body; both run joined
};

/// A variant of the estimator, as its file says: all options of all parts, with defaults.
struct Variant {
  std::string name = "single_frame_obb";
  PerceptionOptions perception;
  // ours: names only, no measurement passes between frames; the world's names made 0.9 rad of error of a
  // turning cube that is right to 0.1 (docs/estimator/baseline.md)
  AxisNaming axis_naming = AxisNaming::previous;
  bool smooth = false;  // of `single_frame`: one size a track, its trajectory smoothed at the end
  BodyOptions body;
  Backend backend = Backend::single_frame;
  PlausibilityOptions plausibility;  // of the sequence, before anything is estimated
  bool write_features = false;       // features.csv, a row a sighting: megabytes
  Feedback feedback = Feedback::perception;
  JoinedOptions joined;  // of Feedback::backend
  UprightBoxOptions upright;
};

/// What is estimated when nobody says what: configs/variants/superquadric.yaml; where depth comes from a
/// LiDAR, lidar_masks.yaml; of scans without images, lidar_only.yaml. `set` as in load_variant.
Variant default_variant(const Sequence& sequence, const std::vector<ConfigOverride>& set = {});

/// Reads a variant file (configs/variants). Keys left out have their defaults; an unknown key, a value out of
/// range or of the wrong kind is an InputError with file and line. The values of `set` replace the file's.
Variant load_variant(const std::filesystem::path& path, const std::vector<ConfigOverride>& set = {});

/// All options, resolved, in the format that load_variant reads.
std::string variant_yaml(const Variant& variant);

/// Those of the perception stage alone: variants that agree in them can share its result.
std::string perception_yaml(const Variant& variant);

}  // namespace uniquadric
