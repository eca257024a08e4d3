#include "harness/fault_line.h"

#include <gtest/gtest.h>

#include <new>
#include <opencv2/core.hpp>
#include <stdexcept>

namespace uniquadric {
namespace {

TEST(FaultLine, MemoryThatRanOutIsNoFaultToReport) {
  EXPECT_EQ(fault_line(std::bad_alloc()), "out of memory");
  EXPECT_EQ(fault_line(cv::Exception(cv::Error::StsNoMem, "Failed to allocate", "f", "f.cpp", 1)),
            "out of memory");
}

TEST(FaultLine, OtherFaultsAreToBeReportedInOneLine) {
  EXPECT_EQ(fault_line(std::logic_error("no such back end\n")),
            "internal error: no such back end; please report it with the command and its input");
}

}  // namespace
}  // namespace uniquadric
