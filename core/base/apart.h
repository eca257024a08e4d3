#pragma once

#include <filesystem>
#include <vector>

namespace uniquadric {

/// Throws InputError when writing `out` could harm an input: when it is one of `inputs`, holds one of them or
/// lies inside one. Links are followed; empty paths and pipes are passed over; nothing has to exist.
void require_apart(const std::filesystem::path& out, const std::vector<std::filesystem::path>& inputs);

}  // namespace uniquadric
