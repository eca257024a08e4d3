#pragma once

#include <filesystem>
#include <string>

namespace uniquadric {

/// Throws InputError with file and line for YAML that would cost more than its length: more than 16 MiB,
/// nested more than 64 levels deep, or of more than 200,000 nodes, each with all that its aliases stand for;
/// and for texts in it that are not UTF-8. Text that is no YAML passes, as far as it is read: the parser says
/// what is wrong with it.
void require_bounded_yaml(const std::string& text, const std::filesystem::path& name);

}  // namespace uniquadric
