// Two masters in one program, each with its own line, both in motion at the same time.
#include <gmock/gmock.h>

#include "drive_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::MotionPhase;

TEST(TwoNetworks, RunSideBySide) {
  DriveLine lines[2] = {DriveLine(2), DriveLine(3)};
  RunOptions slower;
  slower.period = milliseconds{1};
  LineOperation first(lines[0]);
  LineOperation second(lines[1], slower);
  ASSERT_EQ(sentence(first.to_motion()), "");
  ASSERT_EQ(sentence(second.to_motion()), "");
  for (int i = 0; i < 100; ++i) {
    first.run(milliseconds{5});
    second.run(milliseconds{5});
  }
  EXPECT_EQ(first.statistics().wkc_errors + second.statistics().wkc_errors, 0U);
  EXPECT_EQ(first.statistics().lost_frames + second.statistics().lost_frames, 0U);
  EXPECT_TRUE(first.run_until(MotionPhase::kHolding, std::chrono::seconds{2}));
  // One is shut down, which must not affect the other.
  first.motion().request_stop();
  ASSERT_TRUE(first.run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
  EXPECT_EQ(sentence(first.master().shut_down()), "");
  EXPECT_TRUE(second.run_until(MotionPhase::kHolding, std::chrono::seconds{2}));
  EXPECT_TRUE(lines[0].all_in(wire::AlState::kInit));
  EXPECT_TRUE(lines[1].all_in(wire::AlState::kOp));
}

}  // namespace
}  // namespace driveline::bus_test
