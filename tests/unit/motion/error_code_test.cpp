// Names of error codes, by hand from the table of IEC 61800-7-201.
#include "driveline/motion/cia402/error_code.hpp"

#include <gtest/gtest.h>

namespace driveline::motion::cia402 {
namespace {

TEST(ErrorCode, HasTheNameOfTheStandard) {
  EXPECT_EQ(error_text(0x2310), "0x2310, continuous overcurrent");
  EXPECT_EQ(error_text(0x8611), "0x8611, following error");
  EXPECT_EQ(error_text(0x1000), "0x1000, generic error");
  EXPECT_EQ(error_text(0xFF00), "0xFF00, manufacturer-specific");
}

TEST(ErrorCode, WithoutANameOfItsOwnHasThatOfItsGroup) {
  EXPECT_EQ(error_name(0x3122), "mains undervoltage") << "of phase L2";
  EXPECT_EQ(error_name(0x7380), "sensor");
  EXPECT_EQ(error_name(0x4999), "temperature");
  EXPECT_EQ(error_name(0xFF17), "manufacturer-specific");
}

TEST(ErrorCode, WhatNobodyNamesStaysANumber) {
  EXPECT_EQ(error_text(0x0000), "0x0000");
  EXPECT_EQ(error_text(0xA001), "0xA001");
}

}  // namespace
}  // namespace driveline::motion::cia402
