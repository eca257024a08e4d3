#include "core/base/threads.h"

#include <gtest/gtest.h>

namespace uniquadric {
namespace {

TEST(Threads, AreNeverMoreThanCoresAndAllOfThemForZero) {
  const int cores = threads_to_use(0);
  EXPECT_GE(cores, 1);
  EXPECT_EQ(threads_to_use(1), 1);
  EXPECT_EQ(threads_to_use(100'000), cores);
}

}  // namespace
}  // namespace uniquadric
