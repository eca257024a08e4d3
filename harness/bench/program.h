#pragma once

#include <string>

namespace uniquadric {

/// What this program was built from: "commit 0123..., unchanged", "commit 0123..., changed since" (sources,
/// not documents or tests), or "no known commit", as of an archive without its history.
std::string program_source();

}  // namespace uniquadric
