#pragma once

#include <filesystem>
#include <string>

#include "estimator/perception/segmentation.h"
#include "estimator/shape/obb_ransac.h"
#include "estimator/shape/object_points.h"

namespace uniquadric {

/// Where the camera's poses come from.
enum class EgoSource {
  given,  ///< camera_given.tum of the sequence
};

/// What turns the observations of the frames into states.
enum class Backend {
  single_frame,  ///< each frame by itself: the paper's baseline
};

/// Which of an object's 24 equivalent frames a state is written in.
enum class AxisNaming {
  world,  ///< axes nearest to the world's: frames are named without memory, but a body that turns is renamed
  previous,  ///< axes nearest to the object's last state (the world's for the first): names follow the body
};

/// A variant of the estimator, as its file says: all options of all parts, with defaults.
struct Variant {
  std::string name = "single_frame_obb";
  EgoSource ego = EgoSource::given;
  SegmentationOptions segmentation;
  PointOptions points;
  ObbOptions obb;
  // ours: names only, no measurement passes between frames; the world's names made 0.9 rad of error of a
  // turning cube that is right to 0.1 (README.md)
  AxisNaming axis_naming = AxisNaming::previous;
  Backend backend = Backend::single_frame;
};

/// Reads a variant file (configs/variants). Keys left out have their defaults; an unknown key, a value out of
/// range or of the wrong kind is an InputError with file and line.
Variant load_variant(const std::filesystem::path& path);

/// All options, resolved, in the format that load_variant reads.
std::string variant_yaml(const Variant& variant);

}  // namespace uniquadric
