#pragma once

#include <filesystem>
#include <vector>

namespace uniquadric {

/// Whether a path is a folder or lies in it, by their names alone: both resolved, without a slash at the end.
bool holds(const std::filesystem::path& folder, const std::filesystem::path& path);

/// Throws InputError when writing `out` could harm an input: when it is one of `inputs`, holds one of them or
/// lies inside one. Links are followed; empty paths and pipes are passed over; nothing has to exist.
void require_apart(const std::filesystem::path& out, const std::vector<std::filesystem::path>& inputs);

}  // namespace uniquadric
