// A line of the ServoOne variant under the real master.
#include <gtest/gtest.h>

#include "drive_line.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using slaves::msd::ErrorIndication;
using slaves::msd::Variant;
using wire::AlState;

class ServoOneLine : public testing::TestWithParam<Variant> {
 protected:
  DriveLine drives{2, {}, {}, std::nullopt, GetParam()};
  LineOperation operation{drives, RunOptions{.variant = GetParam()}};

  [[nodiscard]] ErrorIndication indication(std::size_t position) {
    return slaves::msd::error_indication(drives.slave(position).esc().al_status(), drives.al_status_code(position));
  }
};

TEST_P(ServoOneLine, FollowsItsPathInOp) {
  ASSERT_EQ(sentence(operation.to_motion()), "");
  EXPECT_TRUE(operation.run_until(motion::MotionPhase::kHolding, std::chrono::seconds{3}));
  for (std::size_t i = 0; i < drives.size(); ++i) {
    EXPECT_EQ(drives.drive(i).variant(), GetParam());
    EXPECT_EQ(drives.drive(i).fault(), std::nullopt);
    EXPECT_EQ(indication(i), ErrorIndication::kNone);
  }
  EXPECT_EQ(sentence(operation.master().shut_down()), "");
}

TEST_P(ServoOneLine, IsNotTakenForAnMsd) {
  ASSERT_EQ(sentence(operation.master().scan()), "");
  auto plans = operation.plans();
  plans[1].product_code = slaves::msd::kProductCode;
  EXPECT_FALSE(operation.master().configure(plans));
}

TEST_P(ServoOneLine, ErrorIndicationTellsWatchdogFromInvalidConfiguration) {
  ASSERT_EQ(sentence(operation.to_op()), "");
  drives.leave_alone(milliseconds{300});
  for (std::size_t i = 0; i < drives.size(); ++i) {
    EXPECT_EQ(drives.state(i), AlState::kSafeOp);
    EXPECT_EQ(indication(i), ErrorIndication::kWatchdog);
  }
  EXPECT_NE(sentence(operation.master().shut_down()), "a line that nobody served");
  // SAFEOP with a sync manager of the wrong length.
  ConfiguredOperation again(drives, RunOptions{.variant = GetParam()});
  EXPECT_EQ(indication(0), ErrorIndication::kNone);
  auto& bus = again.master().bus();
  const auto slave = again.master().slaves()[0].info.ref;
  const std::vector<ecat_master::SlaveRef> refs = {slave};
  ASSERT_EQ(sentence(ecat_master::change_state(bus, refs, AlState::kPreOp, std::chrono::seconds{1})), "");
  const auto disable = std::array{std::byte{0}};
  ASSERT_EQ(sentence(bus.write(slave, static_cast<std::uint16_t>(wire::reg::kSyncManager.at(2) + 6U), disable)), "");
  EXPECT_FALSE(ecat_master::change_state(bus, refs, AlState::kSafeOp, std::chrono::seconds{1}));
  EXPECT_EQ(indication(0), ErrorIndication::kInvalidConfiguration);
}

INSTANTIATE_TEST_SUITE_P(Variants, ServoOneLine, testing::Values(Variant::kServoOne, Variant::kServoOneJunior));

}  // namespace
}  // namespace driveline::bus_test
