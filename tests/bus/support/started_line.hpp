#pragma once

#include <gtest/gtest.h>

#include "drive_line.hpp"

namespace driveline::bus_test {

/// Requests the motion and runs cycles until the axes follow their path.
inline void follow_path(LineOperation& line) {
  ASSERT_EQ(sentence(line.to_motion()), "");
  ASSERT_TRUE(line.run_until(motion::MotionPhase::kFollowing, std::chrono::seconds{2}))
      << to_text(line.motion().phase());
}

namespace start {
inline void scan(ecat_master::Master& master) {
  ASSERT_EQ(sentence(master.scan()), "");
}
inline void enter_pre_op(ecat_master::Master& master) {
  ASSERT_EQ(sentence(master.enter_pre_op()), "");
}
inline void scan_line(LineOperation& line) {
  scan(line.master());
}
inline void to_safe_op(LineOperation& line) {
  ASSERT_EQ(sentence(line.to_safe_op()), "");
}
inline void to_op(LineOperation& line) {
  ASSERT_EQ(sentence(line.to_op()), "");
}
}  // namespace start

/// Starts with its construction; a start that fails fails the test.
template <typename Base, auto kStart>
struct Started : Base {
  using Base::Base;
  bool started = (kStart(*this), true);
};

using ScannedMaster = Started<ecat_master::Master, start::scan>;
using PreOpMaster = Started<ScannedMaster, start::enter_pre_op>;
using ScannedOperation = Started<LineOperation, start::scan_line>;
using ConfiguredOperation = Started<LineOperation, start::to_safe_op>;  ///< in SAFEOP
using IdleOperation = Started<LineOperation, start::to_op>;             ///< in OP, axes not enabled
using FollowingOperation = Started<LineOperation, follow_path>;         ///< the axes follow their path

}  // namespace driveline::bus_test
