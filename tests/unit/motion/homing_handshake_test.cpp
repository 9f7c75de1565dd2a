#include "driveline/motion/drive/homing_handshake.hpp"

#include <gtest/gtest.h>

namespace driveline::motion {
namespace {

using std::chrono::milliseconds;
using State = HomingHandshake::State;

// Bits 13, 12 and 10 of CiA 402-2, table "Definition of bit 10, bit 12, and bit 13", over an enabled drive.
constexpr std::uint16_t kHomingRuns = 0x0237;
constexpr std::uint16_t kNotStarted = 0x0637;
constexpr std::uint16_t kAttainedMoving = 0x1237;
constexpr std::uint16_t kAttainedAtRest = 0x1637;
constexpr std::uint16_t kErrorMoving = 0x2237;
constexpr std::uint16_t kErrorAtRest = 0x2637;

TEST(HomingHandshake, IsWhatTheTableSays) {
  HomingHandshake homing;
  homing.start(kNotStarted);
  EXPECT_EQ(homing.judge(kNotStarted, milliseconds{1}), State::kRunning);
  EXPECT_EQ(homing.judge(kHomingRuns, milliseconds{2}), State::kRunning);
  EXPECT_EQ(homing.judge(kAttainedMoving, milliseconds{3}), State::kRunning);
  EXPECT_EQ(homing.judge(kAttainedAtRest, milliseconds{4}), State::kAttained);
  EXPECT_EQ(homing.judge(kErrorMoving, milliseconds{4}), State::kFailed);
  EXPECT_EQ(homing.judge(kErrorAtRest, milliseconds{4}), State::kFailed);
}

TEST(HomingHandshake, AnEarlierResultCountsOnceItHasGone) {
  for (const auto before : {kAttainedAtRest, kErrorAtRest}) {
    HomingHandshake homing;
    homing.start(before);
    EXPECT_EQ(homing.judge(before, milliseconds{1}), State::kRunning);
    EXPECT_EQ(homing.judge(kHomingRuns, milliseconds{2}), State::kRunning);
    EXPECT_EQ(homing.judge(kAttainedAtRest, milliseconds{3}), State::kAttained);
  }
}

/// A drive that homes without a movement may finish before its start was seen.
TEST(HomingHandshake, AnEarlierResultIsANewOneWhenTheDriveHasHadItsTime) {
  HomingHandshake homing;
  homing.start(kAttainedAtRest);
  EXPECT_EQ(homing.judge(kAttainedAtRest, HomingHandshake::kReaction - milliseconds{1}), State::kRunning);
  EXPECT_EQ(homing.judge(kAttainedAtRest, HomingHandshake::kReaction), State::kAttained);
}

}  // namespace
}  // namespace driveline::motion
