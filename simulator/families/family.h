#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/config_overrides.h"

namespace uniquadric {

/// A scene that nobody chose: drawn at random from a family (scenes/families.md has the distributions).
struct FamilyRequest {
  std::string family;
  std::uint64_t seed = 0;
  std::vector<ConfigOverride> set;  ///< of the family's own keys
};

/// How every scene that is drawn begins.
constexpr std::string_view kSceneHead = "# Family ";

/// Their names, in the order of their documentation.
const std::vector<std::string>& family_names();

/// Throws InputError for a family that there is not, a key that it has not, and a value out of range.
void check_request(const FamilyRequest& request);

/// The scene as YAML, the same bytes for the same request. Throws as check_request, and for meshes that are
/// not there or do not fit.
std::string generate_scene(const FamilyRequest& request);

}  // namespace uniquadric
