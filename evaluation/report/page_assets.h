#pragma once

#include <string_view>

namespace uniquadric {

/// A file of the page (page/ and Chart.js), embedded when the library is built. Asserts that it exists.
std::string_view page_asset(std::string_view name);

}  // namespace uniquadric
