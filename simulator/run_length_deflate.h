#pragma once

#include <span>
#include <string>

namespace uniquadric {

/// A zlib stream (RFC 1950, 1951) of one block with the fixed codes, in which only runs of one byte are
/// shortened. For long runs it is some ten times faster than general compressors, which keep account of every
/// byte they pass.
std::string deflate_runs(std::span<const unsigned char> bytes);

}  // namespace uniquadric
