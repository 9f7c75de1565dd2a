#include <gmock/gmock.h>

#include <cmath>
#include <set>

#include "drive_line.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::MotionPhase;
using slaves::PowerState;
using wire::AlState;
using wire::AlStatusCode;
using Cause = motion::MotionFailure::Cause;

/// Three drives moving along their path.
class InMotion : public testing::Test {
 protected:
  void start(std::size_t count = 3, const RunOptions& options = {}) {
    drives = std::make_unique<DriveLine>(count);
    operation = std::make_unique<LineOperation>(*drives, options);
    ASSERT_EQ(sentence(operation->to_motion()), "");
    ASSERT_TRUE(operation->run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
    operation->run(milliseconds{80});
    ASSERT_GT(std::abs(drives->drive(0).velocity_rad_s()), 1.0);
    visited.resize(count);
  }
  /// Runs and records the states that the drives pass.
  void watch(nanoseconds duration) {
    const auto end = drives->clock.now() + duration;
    while (drives->clock.now() < end) {
      operation->cycle();
      for (std::size_t i = 0; i < drives->size(); ++i) visited[i].insert(drives->drive(i).state());
    }
  }
  void expect_quick_stopped(std::size_t position) {
    EXPECT_TRUE(visited[position].count(PowerState::kQuickStopActive)) << "drive " << position << " was not braked";
    EXPECT_EQ(drives->drive(position).state(), PowerState::kSwitchOnDisabled) << "drive " << position;
    EXPECT_NEAR(drives->drive(position).velocity_rad_s(), 0.0, 0.05) << "drive " << position;
  }

  std::unique_ptr<DriveLine> drives;
  std::unique_ptr<LineOperation> operation;
  std::vector<std::set<PowerState>> visited;
};

TEST_F(InMotion, ADriveFaultStopsAllAxes) {
  start();
  drives->drive(1).set_dc_link(false);
  watch(milliseconds{500});
  const auto failure = operation->motion().failure();
  EXPECT_EQ(failure.cause, Cause::kAxisFault);
  EXPECT_EQ(failure.axis, 1);
  EXPECT_EQ(failure.error_code, 0x3220) << "DC link undervoltage";
  EXPECT_EQ(failure.status_word & 0x0F, 0x0F & failure.status_word);
  EXPECT_TRUE((failure.status_word & 0x4F) == 0x08 || (failure.status_word & 0x4F) == 0x0F);
  expect_quick_stopped(0);
  expect_quick_stopped(2);
  EXPECT_EQ(drives->drive(1).state(), PowerState::kFault);
  EXPECT_EQ(operation->motion().phase(), MotionPhase::kIdle);
  EXPECT_TRUE(drives->all_in(AlState::kOp)) << "a drive fault is no fault of the bus";
  EXPECT_EQ(sentence(operation->master().shut_down()), "");
}

TEST_F(InMotion, AFollowingErrorStopsAllAxes) {
  start();
  ecat_master::CoeClient coe(*operation->master().mailbox(2));
  ASSERT_EQ(sentence(coe.download_as<std::uint16_t>(0x6066, 0, 1)), "");
  ASSERT_EQ(sentence(coe.download_as<std::uint32_t>(0x6065, 0, 1)), "");
  watch(milliseconds{500});
  EXPECT_EQ(operation->motion().failure().cause, Cause::kAxisFault);
  EXPECT_EQ(operation->motion().failure().axis, 2);
  EXPECT_EQ(operation->motion().failure().error_code, 0x8611) << "following error (CiA 402)";
  expect_quick_stopped(0);
  expect_quick_stopped(1);
}

TEST_F(InMotion, ADriveWhoseHardwareEnableIsTakenAwayStopsAllAxes) {
  start();
  drives->drive(0).set_enpo(false);
  watch(milliseconds{500});
  EXPECT_EQ(operation->motion().failure().cause, Cause::kAxisLost);
  EXPECT_EQ(operation->motion().failure().axis, 0);
  expect_quick_stopped(1);
  expect_quick_stopped(2);
}

TEST_F(InMotion, AfterAFaultTheMotionStartsAgain) {
  start();
  drives->drive(1).set_dc_link(false);
  watch(milliseconds{500});
  ASSERT_EQ(operation->motion().phase(), MotionPhase::kIdle);
  drives->drive(1).set_dc_link(true);
  operation->motion().request_start();
  EXPECT_TRUE(operation->run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  EXPECT_EQ(operation->motion().failure().cause, Cause::kNone);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(drives->drive(i).state(), PowerState::kOperationEnabled);
}

TEST_F(InMotion, AFaultThatStaysEndsInAnEnableTimeout) {
  start(3, RunOptions{.enable_timeout = milliseconds{300}});
  drives->drive(1).set_enpo(false);
  watch(milliseconds{500});
  ASSERT_EQ(operation->motion().phase(), MotionPhase::kIdle);
  operation->motion().request_start();
  watch(milliseconds{100});
  EXPECT_EQ(operation->motion().phase(), MotionPhase::kEnabling);
  watch(milliseconds{500});
  EXPECT_EQ(operation->motion().failure().cause, Cause::kEnableTimeout);
  EXPECT_EQ(operation->motion().failure().axis, 1);
  EXPECT_EQ(operation->motion().phase(), MotionPhase::kIdle);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_FALSE(drives->drive(i).state() == PowerState::kOperationEnabled);
}

TEST_F(InMotion, ALastDriveWithoutPowerStopsTheOthers) {
  start();
  drives->line().set_power(2, false);
  watch(milliseconds{500});
  // One LRW carries all three; its working counter does not tell which drive is missing, but the status bytes do.
  EXPECT_EQ(operation->motion().failure().cause, Cause::kAxisLost);
  EXPECT_EQ(operation->motion().failure().axis, 2);
  EXPECT_EQ(operation->master().core()->al_status().slaves, 2);
  EXPECT_TRUE(operation->master().core()->slave_report(1).operational) << "the others go on";
  EXPECT_TRUE(operation->master().core()->slave_report(2).absent);
  EXPECT_GT(operation->statistics().wkc_errors, 0U);
  expect_quick_stopped(0);
  expect_quick_stopped(1);
}

TEST_F(InMotion, TheShutDownReachesTheDrivesThatAreLeft) {
  start();
  drives->line().set_power(2, false);
  watch(milliseconds{500});
  const auto done = operation->master().shut_down();
  ASSERT_FALSE(done) << "the missing drive must not pass unnoticed";
  EXPECT_EQ(sentence(done), "slave 2: working counter 0 instead of 1 at address 0x0130");
  EXPECT_EQ(drives->state(0), AlState::kInit);
  EXPECT_EQ(drives->state(1), AlState::kInit);
}

TEST_F(InMotion, ADriveThatLostPowerIsTakenInAgainByANewStart) {
  start();
  drives->line().set_power(1, false);
  watch(milliseconds{300});
  drives->line().set_power(1, true);
  ASSERT_FALSE(operation->master().shut_down().has_value());
  LineOperation again(*drives);
  ASSERT_EQ(sentence(again.to_motion()), "");
  EXPECT_TRUE(again.run_until(MotionPhase::kFollowing, std::chrono::seconds{3})) << to_text(again.motion().phase());
  EXPECT_EQ(again.statistics().wkc_errors, 0U);
}

TEST_F(InMotion, APowerCycleIsNoFaultOfTheDrive) {
  start();
  drives->line().set_power(1, false);
  watch(milliseconds{300});
  drives->line().set_power(1, true);
  watch(milliseconds{10});
  EXPECT_EQ(drives->drive(1).fault(), std::nullopt) << drives->drive(1).display();
  EXPECT_NE(drives->drive(1).state(), PowerState::kFault);
  EXPECT_NE(drives->drive(1).state(), PowerState::kOperationEnabled);
}

TEST_F(InMotion, ABrokenCableStopsBothSides) {
  start(4);
  ASSERT_TRUE(drives->line().break_cable({1, 1}));
  watch(milliseconds{800});
  EXPECT_EQ(operation->motion().failure().cause, Cause::kAxisLost);
  EXPECT_EQ(operation->motion().failure().axis, 2) << "the first behind the break";
  EXPECT_EQ(operation->master().core()->al_status().slaves, 2);
  expect_quick_stopped(0);
  expect_quick_stopped(1);
  for (const std::size_t cut_off : {2U, 3U}) {
    EXPECT_EQ(drives->state(cut_off), AlState::kSafeOp);
    EXPECT_EQ(drives->al_status_code(cut_off), AlStatusCode::kSyncManagerWatchdog);
    EXPECT_EQ(drives->drive(cut_off).state(), PowerState::kFault);
    EXPECT_NEAR(drives->drive(cut_off).velocity_rad_s(), 0.0, 0.05);
  }
  EXPECT_FALSE(operation->master().shut_down().has_value());
  ASSERT_TRUE(drives->line().break_cable({1, 1}, false));
  LineOperation again(*drives);
  ASSERT_EQ(sentence(again.to_motion()), "");
  EXPECT_TRUE(again.run_until(MotionPhase::kFollowing, std::chrono::seconds{3}));
}

TEST_F(InMotion, LossOfEverythingIsALossOfCommunication) {
  start();
  drives->line().drop_frames(1'000'000);
  watch(milliseconds{800});
  EXPECT_EQ(operation->motion().failure().cause, Cause::kCommunication);
  EXPECT_EQ(operation->master().core()->al_status().slaves, 0);
  EXPECT_GT(operation->master().core()->bad_cycles(), 6000U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(drives->state(i), AlState::kSafeOp);
    EXPECT_EQ(drives->al_status_code(i), AlStatusCode::kSyncManagerWatchdog);
    EXPECT_NEAR(drives->drive(i).velocity_rad_s(), 0.0, 0.05) << "stopped by itself";
  }
  EXPECT_FALSE(operation->master().shut_down().has_value());
  EXPECT_EQ(operation->motion().phase(), MotionPhase::kQuickStop);
}

TEST_F(InMotion, AShortLossIsBridged) {
  start();
  drives->line().drop_frames(7);
  watch(milliseconds{20});
  EXPECT_EQ(operation->motion().phase(), MotionPhase::kFollowing);
  EXPECT_EQ(operation->motion().failure().cause, Cause::kNone);
  EXPECT_EQ(operation->statistics().lost_frames, 7U);
}

TEST_F(InMotion, OneLostCycleMoreThanAllowedIsALoss) {
  start();
  drives->line().drop_frames(8);
  watch(milliseconds{500});
  EXPECT_EQ(operation->motion().failure().cause, Cause::kCommunication);
  for (std::size_t i = 0; i < 3; ++i) expect_quick_stopped(i);
  EXPECT_EQ(operation->motion().phase(), MotionPhase::kIdle)
      << "the drives came back and have reported that they stopped";
}

TEST_F(InMotion, DrivesLeftAloneStopThemselves) {
  start();
  drives->leave_alone(milliseconds{90});
  EXPECT_TRUE(drives->all_in(AlState::kOp)) << "the watchdog runs 100 ms";
  drives->leave_alone(milliseconds{110});
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(drives->state(i), AlState::kSafeOp);
    EXPECT_EQ(drives->al_status_code(i), AlStatusCode::kSyncManagerWatchdog);
    EXPECT_EQ(drives->drive(i).fault(), slaves::msd::Fault::kBusWatchdog);
  }
  drives->leave_alone(milliseconds{300});
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(drives->drive(i).velocity_rad_s(), 0.0, 0.05);
  LineOperation again(*drives);
  ASSERT_EQ(sentence(again.to_motion()), "");
  ASSERT_TRUE(again.run_until(MotionPhase::kFollowing, std::chrono::seconds{3}));
  again.run(milliseconds{100});
  EXPECT_EQ(again.motion().phase(), MotionPhase::kFollowing);
  EXPECT_FALSE(drives->drive(0).fault());
}

TEST_F(InMotion, WhenTheCycleComesBackTooLateTheAxesStayOff) {
  start();
  drives->leave_alone(milliseconds{200});
  watch(milliseconds{100});
  EXPECT_EQ(operation->motion().failure().cause, Cause::kMasterAway) << "named before what the drives make of it";
  EXPECT_GT(operation->statistics().missed_periods, 1500U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(drives->drive(i).fault(), slaves::msd::Fault::kBusWatchdog);
    EXPECT_NE(drives->drive(i).state(), PowerState::kOperationEnabled);
  }
}

TEST(TwoDatagrams, ADriveLostInOneIsTheOnlyOne) {
  DriveLine drives(80);
  FollowingOperation operation(drives, RunOptions{.period = microseconds{250}, .amplitude_rad = 0.01});
  ASSERT_EQ(operation.master().image().places()[76].input_datagram, 1U);
  drives.line().set_power(79, false);
  operation.run(milliseconds{5});
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kQuickStop);
  EXPECT_EQ(operation.motion().failure().cause, Cause::kAxisLost);
  EXPECT_EQ(operation.motion().failure().axis, 79);
  EXPECT_TRUE(operation.master().core()->slave_report(76).valid) << "in the same datagram";
}

}  // namespace
}  // namespace driveline::bus_test
