#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/geometry/camera.h"
#include "core/geometry/ellipsoid.h"
#include "core/geometry/superquadric.h"

namespace uniquadric {

struct PosedBody {
  Superellipsoid body;
  Pose world_from_body;
};

struct PosedCamera {
  Camera camera;
  Pose world_from_camera;
};

/// The value of "id" in the outermost object of a line that may be no JSON, as JSON text: what an answer to a
/// line that cannot be read is told apart by. "null" where there is none that is whole, a string or a number,
/// or more than one.
std::string stated_id_json(std::string_view line);

/// One JSON line of `metric`. NaN and Infinity, which JSON does not know but other programs write, are read
/// as null, so that the field that holds them can be named.
class MetricLine {
 public:
  /// Throws InputError when `text` is no JSON object, or one that parse_strict_json refuses, or one nested
  /// more deeply than any line here is.
  explicit MetricLine(const std::string& text);

  /// The value of "id" as JSON text, "null" without one. Throws InputError unless it is a string, a number or
  /// null.
  std::string id_json() const;
  /// Throws InputError for a key of the line that is none of these.
  void refuse_other_keys(std::span<const std::string_view> known) const;
  /// {"c": [x,y,z], "q": [x,y,z,w], "a": [a,b,c]} at `key`. Throws InputError for a missing field, a number
  /// that is not finite, a semi-axis outside [1e-9, 1e12] m or 1e6 times another, a centre beyond 1e12 m from
  /// the origin along an axis (what the arithmetic carries) or a quaternion whose norm is off 1 by more than
  /// 1e-3 (closer ones are normalised).
  /// "shape" is read and checked, and counts in body() alone.
  Ellipsoid ellipsoid(const char* key) const;
  /// The same with its "shape": "ellipsoid" (the default), "box", or {"superellipsoid": {"q": [outline,
  /// upper, lower], "axis": "z"}} with exponents in [1, 2].
  PosedBody body(const char* key) const;
  /// {"K": 9 numbers row by row, "width", "height", "t_wc": [x,y,z], "q_wc": [x,y,z,w]} at "camera". Throws
  /// InputError for what is missing, no pinhole matrix without skew, or outside what the arithmetic carries:
  /// focal lengths in [1e-6, 1e9] px, principal point within 1e9 px, position as an ellipsoid's centre.
  PosedCamera camera() const;

 private:
  struct Json;
  std::shared_ptr<const Json> json_;
};

}  // namespace uniquadric
