#include "driveline/ecat_master/error/clock_fault.hpp"

#include <gtest/gtest.h>

#include <set>

#include "driveline/ecat_master/dc/phase_controller.hpp"

namespace driveline::ecat_master::dc {
namespace {

TEST(ClockFault, EveryFaultHasASentenceOfItsOwn) {
  std::set<std::string> sentences;
  for (unsigned code = 0; code <= static_cast<unsigned>(ClockFault::kNotSynchronised); ++code) {
    auto error = clock_error(static_cast<ClockFault>(code), 7);
    error.received = 1234;
    const auto sentence = describe(error);
    EXPECT_FALSE(sentence.empty()) << code;
    EXPECT_TRUE(sentences.insert(sentence).second) << sentence;
  }
}

TEST(ClockFault, FactsAreInTheSentence) {
  auto error = clock_error(ClockFault::kActivation, 2);
  error.address = 0x0981;
  error.expected = 3;
  EXPECT_EQ(describe(error), "slave 2: register 0x0981 is 0x0 after 0x3 was written");
  error = clock_error(ClockFault::kBeforeReference, 0);
  error.received = 3;
  EXPECT_EQ(describe(error),
            "slave 0: frames pass it before the reference clock, slave 3, whose time it cannot follow");
  error = clock_error(ClockFault::kNotLocked);
  error.extra = static_cast<std::uint32_t>(PhaseController::Cause::kFrequencyLimit);
  EXPECT_EQ(
      describe(error),
      "the cycle is not locked to the reference clock: it runs more than 500 ppm away from the master's clock and "
      "cannot be disciplined");
  error.received = static_cast<std::uint32_t>(-4321);
  error.expected = 1250;
  for (const auto cause : {LockCause::kPhaseError, LockCause::kAcquiring}) {
    error.extra = static_cast<std::uint32_t>(cause);
    EXPECT_EQ(describe(error),
              "the cycle is not locked to the reference clock: its frames are -4321 ns off their phase on average and "
              "do not stay within 1250 ns of it");
  }
}

}  // namespace
}  // namespace driveline::ecat_master::dc
