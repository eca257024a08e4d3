#include "core/base/on_demand.h"

#include <gtest/gtest.h>

#include <array>
#include <stdexcept>
#include <string>

namespace uniquadric {
namespace {

TEST(OnDemand, GivesTheFunctionOrNamesWhatIsMissing) {
  EXPECT_EQ(function_on_demand<double(double)>("libm.so.6", "floor")(2.5), 2.0);
  for (const auto& [library, symbol, missing] :
       {std::array{"libnone.so.1", "floor", "libnone.so.1"}, std::array{"libm.so.6", "no_such", "no_such"}})
    try {
      symbol_on_demand(library, symbol);
      ADD_FAILURE() << missing;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(missing), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace uniquadric
