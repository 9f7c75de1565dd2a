// Every layout of the process image runs the same tests.
#include <gmock/gmock.h>

#include <cmath>

#include "every_layout.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::MotionFailure;
using motion::MotionPhase;
using wire::AlState;

class EveryLayout : public LayoutTest {};

TEST_P(EveryLayout, CarriesOutputsToTheDrivesAndInputsBack) {
  start(drives.line());
  operation->run(milliseconds{200});
  EXPECT_EQ(operation->motion().phase(), MotionPhase::kFollowing);
  EXPECT_EQ(operation->statistics().wkc_errors, 0U);
  EXPECT_EQ(operation->statistics().lost_frames, 0U);
  for (std::size_t i = 0; i < kDrives; ++i) {
    // The position in the master matches that of the drive, apart from a few cycles of motion.
    EXPECT_NEAR(operation->motion().axes()[i].inputs().position, drives.drive(i).position_rad(), 0.01) << i;
    EXPECT_NEAR(operation->motion().setpoints()[i].position, drives.drive(i).position_rad(), 0.02) << i;
    const auto report = core().slave_report(i);
    EXPECT_TRUE(report.operational) << i;
    EXPECT_EQ(report.al_status, 8) << i;
  }
  operation->motion().request_stop();
  ASSERT_TRUE(operation->run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
  EXPECT_EQ(sentence(operation->master().shut_down()), "");
  EXPECT_TRUE(drives.all_in(AlState::kInit));
}

TEST_P(EveryLayout, BridgesLostFrames) {
  start(drives.line());
  const auto before = operation->statistics().lost_frames;
  operation->line_samples.clear();
  drives.line().drop_frames(3);
  operation->run(milliseconds{20});
  ASSERT_EQ(operation->line_samples.size(), 160U);
  for (const auto& sample : operation->line_samples) {
    EXPECT_LE(sample.cost_ns, 100'000) << "the cycle ends at its deadline, whatever is missing";
    EXPECT_EQ(sample.missed_periods, 0U);
  }
  EXPECT_EQ(operation->statistics().lost_frames - before, 3U);
  EXPECT_EQ(operation->motion().phase(), MotionPhase::kFollowing);
  EXPECT_EQ(operation->motion().failure().cause, MotionFailure::Cause::kNone);
}

TEST_P(EveryLayout, NamesADriveThatIsGoneAndKeepsTheOthersValid) {
  start(drives.line());
  drives.line().set_power(kDrives - 1, false);
  operation->run(milliseconds{1});
  const auto& motion = operation->motion();
  const double position = motion.axes()[0].inputs().position;
  operation->run(milliseconds{20});
  EXPECT_NE(motion.axes()[0].inputs().position, position) << "its inputs are still taken";
  for (std::size_t i = 0; i + 1 < kDrives; ++i) {
    EXPECT_TRUE(core().slave_report(i).valid) << i;
    EXPECT_EQ(core().slave_report(i).stale_exchanges, 0U) << i;
  }
  EXPECT_FALSE(core().slave_report(kDrives - 1).valid);
  EXPECT_TRUE(core().slave_report(kDrives - 1).absent);
  EXPECT_GE(core().slave_report(kDrives - 1).stale_exchanges, 150U / divider_of(kDrives - 1));
  EXPECT_EQ(motion.failure().cause, MotionFailure::Cause::kAxisLost);
  EXPECT_EQ(motion.failure().axis, kDrives - 1);
}

TEST_P(EveryLayout, ADriveThatFallsOutOfOpIsNamedInTheNextExchange) {
  start(drives.line());
  ecat_master::CyclicEvent event;
  while (core().take_event(event)) {
  }
  // The supervision does not know about this change.
  ecat_master::SlaveRef ref = operation->master().slaves()[2].info.ref;
  const auto value = wire::AlControl{AlState::kSafeOp, false, false}.raw();
  ASSERT_EQ(sentence(operation->master().bus().write(ref, wire::reg::kAlControl, value)), "");
  for (std::uint32_t i = 0; i < 2 * divider_of(2); ++i) operation->cycle();
  EXPECT_EQ(core().slave_report(2).al_status, 4);
  EXPECT_TRUE(core().slave_report(2).valid) << "its inputs are fresh";
  EXPECT_FALSE(core().slave_report(2).operational);
  bool named = false;
  while (core().take_event(event)) {
    if (event.kind != ecat_master::CyclicEvent::Kind::kSlaveState) continue;
    EXPECT_EQ(event.index, 2);
    EXPECT_EQ(event.before, 8);
    EXPECT_EQ(event.after, 4);
    named = true;
  }
  EXPECT_TRUE(named);
}

/// Changes the working counters of process data on their way back: too low, too high, and doubled.
TEST_P(EveryLayout, AWorkingCounterThatNobodyExplainsMakesNobodyValid) {
  int more = 0;
  ChangingPort port(drives.line(), {}, [&](std::span<std::byte> frame) {
    auto cursor = wire::MutableDatagramCursor::open(frame);
    while (more != 0 && cursor && !cursor->done()) {
      auto datagram = cursor->next();
      if (datagram && wire::is_logical(datagram->header.command)) {
        bytes::store_le<std::uint16_t>(datagram->working_counter_bytes,
                                       static_cast<std::uint16_t>(datagram->working_counter() + more));
      }
    }
  });
  start(port);
  for (const int change : {-1, 1, 2, 18}) {
    SCOPED_TRACE(change);
    const auto errors = operation->statistics().wkc_errors;
    more = change;
    operation->run(microseconds{125} * 10);
    for (std::size_t i = 0; i < kDrives; ++i) EXPECT_FALSE(core().slave_report(i).valid) << i;
    EXPECT_GT(operation->statistics().wkc_errors, errors + 4U);
    more = 0;
    operation->run(milliseconds{1});
    for (std::size_t i = 0; i < kDrives; ++i) EXPECT_TRUE(core().slave_report(i).valid) << i;
  }
}

TEST_P(EveryLayout, CarriesMoreDrivesThanOneFrameHolds) {
  DriveLine many(80);
  auto run = options();
  run.period = microseconds{250};
  IdleOperation large(many, run);
  EXPECT_GE(large.master().image().frame_count(), 2U);
  large.run(milliseconds{10});
  EXPECT_EQ(large.statistics().wkc_errors, 0U);
  EXPECT_EQ(large.statistics().lost_frames, 0U);
  for (std::size_t i = 0; i < many.size(); ++i) EXPECT_TRUE(large.master().core()->slave_report(i).operational) << i;
}

INSTANTIATE_TEST_SUITE_P(Layouts, EveryLayout, all_layouts(),
                         [](const auto& name) { return std::string(name.param.name); });

}  // namespace
}  // namespace driveline::bus_test
