#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/import/fields.h"
#include "core/import/omd_readers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// time_sec, time_nsec, object, quaternion x y z w, translation x y z, 4x4 row by row
constexpr std::size_t kColumns = 26, kName = 2, kQuaternion = 3, kTranslation = 7, kMatrix = 10;
constexpr double kAgreement = 1e-3;  // m and of R's elements: quaternions have 6 digits or more

enum class Direction { object_from_world, world_from_object, either };

bool is_nan(std::string_view field) {
  if (field.empty()) return true;
  if (field.front() == '-' || field.front() == '+') field.remove_prefix(1);
  return field.size() == 3 && std::tolower(field[0]) == 'n' && std::tolower(field[1]) == 'a' &&
         std::tolower(field[2]) == 'n';
}

bool agree(const Pose& a, const Pose& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff() < kAgreement;
}

// Which way quaternion and translation go, seen against the matrix.
Direction direction_of(const fs::path& path, int line, const Pose& stated, const Pose& object_from_world) {
  const bool same = agree(stated, object_from_world), inverse = agree(stated, object_from_world.inverse());
  if (!same && !inverse)
    throw InputError(
        path, line,
        "quaternion and translation are neither the 4x4 matrix nor its inverse: the directions of "
        "the poses are unknown");
  return same && inverse ? Direction::either
         : same          ? Direction::object_from_world
                         : Direction::world_from_object;
}

}  // namespace

ViconFile read_vicon(const fs::path& path, double offset_s) {
  ViconFile file;
  Direction direction = Direction::either;
  const std::int64_t offset_ns = std::llround(offset_s * 1e9);
  for_each_row(path, kColumns, [&](int line, const Fields& fields) {
    if (fields[kName].empty() || std::any_of(fields.begin() + kQuaternion, fields.end(), is_nan)) {
      ++file.dropped;
      return;
    }
    if (!is_plain_name(fields[kName])) throw InputError(path, line, "the object's name is no plain name");
    const std::int64_t stamp_ns = read_seconds_and_ns(path, line, fields[0], fields[1]) + offset_ns;
    const auto v = read_numbers(path, line, fields, kQuaternion);
    const double* q = v.data();
    const double* t = v.data() + (kTranslation - kQuaternion);
    const Pose stated{read_unit(path, line, {q[3], q[0], q[1], q[2]}), {t[0], t[1], t[2]}};
    const Pose object_from_world = read_pose_rows(path, line, {v.begin() + (kMatrix - kQuaternion), v.end()});
    const Direction here = direction_of(path, line, stated, object_from_world);
    if (direction == Direction::either) direction = here;
    if (here != Direction::either && here != direction)
      throw InputError(path, line, "quaternion and translation go the other way than in the rows before");
    Trajectory& body = file.bodies[std::string(fields[kName])];
    require_later(path, line, body, stamp_ns);
    body.push_back({stamp_ns, object_from_world.inverse()});
  });
  return file;
}

}  // namespace uniquadric
