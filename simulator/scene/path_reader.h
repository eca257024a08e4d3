#pragma once

#include <filesystem>

namespace uniquadric {

class ConfigNode;

/// A path named in a scene: ${VARIABLE} is replaced by the environment's value (UNIQUADRIC_DATA has a
/// default, ../../shared/data beside the scene file), and a relative path counts from the scene file's
/// folder.
std::filesystem::path resolve_path(const ConfigNode& node);

/// The same of a file that must be there.
std::filesystem::path find_file(const ConfigNode& node);

}  // namespace uniquadric
