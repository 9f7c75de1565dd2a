#include <gtest/gtest.h>

#include <cstdint>

#include "driveline/motion/axis/setpoint_delay.hpp"

namespace driveline::motion {
namespace {

/// 10,000 cycles are the longest gap that a line description allows.
TEST(SetpointHistory, ExtrapolatesAsIfTheSetpointsHadBeenAddedOneByOne) {
  for (const double delay : {0.0, 1.0, 3.3, 17.9}) {
    for (const std::int64_t cycles : {0, 1, 2, 5, 19, 20, 10'000}) {
      SetpointHistory pushed(delay);
      pushed.push(1.0);
      pushed.push(1.5);
      auto extrapolated = pushed;
      for (std::int64_t cycle = 0; cycle < cycles; ++cycle) pushed.push(pushed.ago(0) + 0.25);
      extrapolated.extrapolate(cycles, 0.25);
      EXPECT_DOUBLE_EQ(extrapolated.followed(), pushed.followed()) << delay << ", " << cycles;
      for (std::size_t ago = 0; ago < pushed.whole_cycles() + 2; ++ago)
        EXPECT_DOUBLE_EQ(extrapolated.ago(ago), pushed.ago(ago)) << delay << ", " << cycles;
    }
  }
}

TEST(SetpointHistory, KnowsWhatIsFollowedWhenAPositionIsMeasuredLater) {
  for (const double delay : {0.0, 1.0, 2.5, 3.0}) {
    SetpointHistory history(delay);
    for (int i = 0; i < 10; ++i) history.push(2.0 * i);
    EXPECT_DOUBLE_EQ(history.followed_later(0.0), history.followed()) << delay;
    for (const double later : {0.25, 0.75, 1.0, 2.6}) {
      EXPECT_DOUBLE_EQ(history.followed_later(later), history.followed() + 2.0 * later) << delay << ", " << later;
      EXPECT_DOUBLE_EQ(history.continued(later), 18.0 + 2.0 * later);
    }
  }
}

}  // namespace
}  // namespace driveline::motion
