#pragma once

#include <string_view>

namespace uniquadric {

/// Whether a text is UTF-8 (RFC 3629: no overlong forms, no surrogates): JSON can hold no other.
bool is_utf8(std::string_view text);

}  // namespace uniquadric
