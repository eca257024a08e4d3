#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace uniquadric {

/// What a scenery.json holds, as scenery.h has it. Throws InputError with line or field for any other.
nlohmann::json read_scenery(const std::filesystem::path& file);

}  // namespace uniquadric
