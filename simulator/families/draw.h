#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <vector>

#include "core/base/config.h"
#include "core/base/random.h"

namespace uniquadric {

/// What the scenes of all families have of their own.
struct FamilyOptions {
  std::string family;
  double difficulty = 0.5;  ///< 0 to 1: of what scenes/families.md says of each family
  std::int64_t frames = 300;
  int count = 0;       ///< of objects; 0: drawn
  std::string meshes;  ///< a folder of scanned things to draw from; empty: primitives
  std::string realism = "ideal";
  std::string lidar;  ///< of streets: the scan pattern; empty: drawn
  std::string lens;   ///< a line of `camera`; empty, as in streets: without distortion

  /// That a camera's way is drawn for: a scene shorter than a second shows its beginning.
  double camera_s() const { return std::max(1.0, static_cast<double>(frames) / 30); }
};

/// `easy` at difficulty 0, `hard` at 1.
double graded(double difficulty, double easy, double hard);

/// A value of a list, each as likely.
template <typename T>
const T& one_of(RandomStream& random, const std::vector<T>& values) {
  return values[random.below(static_cast<std::uint32_t>(values.size()))];
}

/// Numbers and poses as YAML, to a tenth of a millimetre or a hundredth of a degree: the same bytes anywhere.
std::string yaml_number(double value, int digits = 4);
std::string yaml_vector(const Eigen::Vector3d& value, int digits = 4);

/// Red, green, blue from 0 to 1: muted.
Eigen::Vector3d drawn_color(RandomStream& random);

/// `material:` of a body: fewer marks and less contrast the harder the scene, up to half without any; three
/// in ten shine, and return up to 40 % less of a depth sensor's light.
std::string drawn_material(RandomStream& random, double difficulty);

/// A world's line: a furnished room of 6 m.
std::string drawn_room(RandomStream& random);

/// The part of a composed motion that a hand at a camera adds, indented by six.
std::string drawn_camera_tremor(RandomStream& random);

/// `calibration:` of a camera, indented by two, with the distortion of every other lens; or nothing.
std::string drawn_lens(RandomStream& random);

}  // namespace uniquadric
