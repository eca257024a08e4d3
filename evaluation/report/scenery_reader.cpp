#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "evaluation/report/scenery_parts.h"
#include "evaluation/strict_json_parts.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

// A value of the file and its name there, as "meshes[0].id".
struct Field {
  const fs::path& file;
  std::string name;
  const json& value;

  [[noreturn]] void fail(const char* expected) const {
    throw InputError(file, fmt::format("field {}: expected {}", name, expected));
  }
  Field at(const char* key) const {
    if (!value.is_object()) fail("an object with named values");
    const auto found = value.find(key);
    const std::string path = name.empty() ? key : fmt::format("{}.{}", name, key);
    if (found == value.end()) throw InputError(file, fmt::format("field {}: is missing", path));
    return {file, path, *found};
  }
  Field at(std::size_t i) const { return {file, fmt::format("{}[{}]", name, i), value[i]}; }
  std::size_t size() const {
    if (!value.is_array()) fail("a list");
    return value.size();
  }
};

void require_integer(const Field& field) {
  if (!field.value.is_number_integer()) field.fail("a whole number");
}

void require_positive(const Field& field) {
  if (!field.value.is_number() || !(field.value.get<double>() > 0)) field.fail("a positive number");
}

// Numbers in groups of three, whole ones of which each is in [0, end) where `end` is not 0. Returns the
// groups.
std::size_t require_triples(const Field& list, std::size_t end = 0) {
  if (list.size() % 3 != 0) list.fail("three numbers a point or triangle");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const json& value = list.value[i];
    if (!value.is_number()) list.at(i).fail("a number");
    if (end > 0 && !(value.is_number_unsigned() && value.get<std::size_t>() < end))
      list.at(i).fail("the index of a point");
  }
  return list.size() / 3;
}

void check_camera(const Field& camera) {
  for (const char* key : {"width", "height", "fx", "fy"}) require_positive(camera.at(key));
  for (const char* key : {"cx", "cy"})
    if (!camera.at(key).value.is_number()) camera.at(key).fail("a number");
}

void check_mesh(const Field& mesh) {
  require_integer(mesh.at("id"));
  const std::size_t points = require_triples(mesh.at("positions_mm"));
  if (mesh.at("triangles").size() > 0 && points == 0) mesh.at("positions_mm").fail("the triangles' points");
  require_triples(mesh.at("triangles"), points);
}

void check_cloud(const Field& cloud) {
  const std::size_t points = require_triples(cloud.at("positions_mm"));
  const Field colors = cloud.at("colors");
  if (colors.size() != points) colors.fail("one colour a point");
  for (std::size_t i = 0; i < points; ++i)
    if (!colors.value[i].is_number_unsigned()) colors.at(i).fail("a colour as a whole number");
}

}  // namespace

json read_scenery(const fs::path& file) {
  json scenery = read_strict_json(file);
  const Field root{file, "", scenery};
  if (!scenery.is_object())
    throw InputError(file, "expected an object with camera, frames, meshes and cloud");
  check_camera(root.at("camera"));
  const Field frames = root.at("frames"), meshes = root.at("meshes");
  for (std::size_t i = 0; i < frames.size(); ++i)
    for (const char* key : {"frame", "stamp_ns"}) require_integer(frames.at(i).at(key));
  for (std::size_t i = 0; i < meshes.size(); ++i) check_mesh(meshes.at(i));
  check_cloud(root.at("cloud"));
  return scenery;
}

}  // namespace uniquadric
