// Profile position and profile velocity modes of the drives as seen by the master.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "driveline/slaves/msd/core/variant.hpp"
#include "profile_line.hpp"

namespace driveline::bus_test {
namespace {

using slaves::msd::Variant;

class EveryProfile : public testing::TestWithParam<Variant> {};

TEST_P(EveryProfile, GoesToPositionsAndComesBackIntoItsMode) {
  ProfileLine line(profile_options(GetParam()));
  ASSERT_EQ(line.ask(request(AxisCommand::kSetPosition, line.setpoint() + 100.0)).phase, RequestPhase::kDone);
  const auto first = line.submit(to(105.0));
  line.cycles(200);
  EXPECT_EQ(line.phase(first), RequestPhase::kActive);
  EXPECT_EQ(line.state(), PlcopenState::kDiscreteMotion);
  EXPECT_EQ(line.now().mode, 1);
  EXPECT_NEAR(line.fastest(2000), kOwnVelocity, 0.5);
  EXPECT_EQ(line.finish(first).phase, RequestPhase::kDone);
  line.cycles(200);
  EXPECT_NEAR(line.now().position, 105.0, 0.01);
  EXPECT_EQ(line.ask(by(-2.0)).phase, RequestPhase::kDone);
  line.cycles(200);
  EXPECT_NEAR(line.now().position, 103.0, 0.01);
  line.expect_use();
  line.expect_obedience();
}

TEST_P(EveryProfile, RunsAtAVelocityUntilItIsHalted) {
  ProfileLine line(profile_options(GetParam()));
  for (const double velocity : {20.0, -15.0}) {
    const auto running = line.submit(at(velocity));
    line.cycles(2000);
    EXPECT_EQ(line.phase(running), RequestPhase::kReached);
    EXPECT_EQ(line.state(), PlcopenState::kContinuousMotion);
    EXPECT_EQ(line.now().mode, 3);
    EXPECT_NEAR(line.now().velocity, velocity, 0.5);
    EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
    EXPECT_EQ(line.phase(running), RequestPhase::kAborted);
    line.expect_use();
  }
}

INSTANTIATE_TEST_SUITE_P(OfDrives, EveryProfile, testing::Values(Variant::kMsd, Variant::kServoOne),
                         [](const auto& row) { return std::string(row.param == Variant::kMsd ? "Msd" : "ServoOne"); });

TEST(DriveProfile, VelocityAndRampsAreGivenWhereTheyAreMapped) {
  ProfileLine line(mapped_options());
  auto slow = by(3.0);
  slow.velocity_si = 4.0;
  slow.acceleration_si = 100.0;
  const auto id = line.submit(slow);
  EXPECT_NEAR(line.fastest(6000), 4.0, 0.2);
  EXPECT_EQ(line.finish(id).phase, RequestPhase::kDone);
  slow.deceleration_si = 100.0;
  EXPECT_EQ(line.ask(slow).error, AxisError::kMode) << "6084h is not mapped";
  const auto fast = line.submit(by(10.0));
  EXPECT_NEAR(line.fastest(6000), 50.0, 1.0) << "the limit of the axis";
  EXPECT_EQ(line.finish(fast).phase, RequestPhase::kDone);
}

TEST(DriveProfile, ANewTargetReplacesTheOneUnderWay) {
  ProfileLine line;
  const double from = line.setpoint();
  const auto first = line.submit(to(from + 8.0));
  line.cycles(2000);
  const auto second = line.submit(to(from - 1.0));
  line.cycles(2);
  EXPECT_EQ(line.phase(first), RequestPhase::kAborted);
  EXPECT_EQ(line.finish(second, 20'000).phase, RequestPhase::kDone);
  line.cycles(200);
  EXPECT_NEAR(line.now().position, from - 1.0, 0.01);
  const auto running = line.submit(at(10.0));
  line.cycles(1000);
  const auto faster = line.submit(at(30.0));
  line.cycles(1500);
  EXPECT_EQ(line.phase(running), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(faster), RequestPhase::kReached);
  EXPECT_NEAR(line.now().velocity, 30.0, 1.0);
  EXPECT_EQ(line.ask(to(0.0)).error, AxisError::kNotAtRest) << "the other mode";
}

TEST(DriveProfile, AMotionOfTheMasterFollowsBehindAHalt) {
  for (const auto& before : {by(10.0), at(20.0)}) {
    ProfileLine line;
    const auto driven = line.submit(before);
    line.cycles(1000);
    EXPECT_EQ(line.finish(line.submit(move(1.0, 20.0)), 20'000).phase, RequestPhase::kDone);
    EXPECT_EQ(line.phase(driven), RequestPhase::kAborted);
    EXPECT_NEAR(line.setpoint(), 1.0, 1e-9);
    EXPECT_EQ(line.now().mode, 8);
  }
}

TEST(DriveProfile, AStopAtAnyMomentLeavesTheAxisAtRest) {
  for (const auto& driven : {by(10.0), at(20.0)}) {
    for (const int moment : {0, 1, 5, 9, 12, 20, 24, 40, 400}) {
      SCOPED_TRACE(testing::Message() << to_text(driven.command) << ", cycle " << moment);
      ProfileLine line;
      line.submit(driven);
      line.cycles(moment);
      EXPECT_EQ(line.ask(request(AxisCommand::kStop)).phase, RequestPhase::kDone);
      EXPECT_EQ(line.state(), PlcopenState::kStopping);
      EXPECT_NEAR(line.now().velocity, 0.0, 0.3);
      EXPECT_EQ(line.ask(by(1.0)).error, AxisError::kNotAtRest);
      EXPECT_EQ(line.ask(request(AxisCommand::kReleaseStop)).phase, RequestPhase::kDone);
      line.expect_use();
    }
  }
}

TEST(DriveProfile, SwitchedOffMeanwhileItComesToRestFirst) {
  ProfileLine line;
  const auto driven = line.submit(at(20.0));
  line.cycles(1000);
  EXPECT_EQ(line.ask(power(false)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(driven), RequestPhase::kAborted);
  EXPECT_EQ(line.state(), PlcopenState::kDisabled);
  line.enable();
  line.expect_use();
}

TEST(DriveProfile, IsRefusedWithTheReason) {
  auto options = profile_options();
  options.supported_modes = 0x03E7U & ~(1U << 2U);  // no pv
  options.software_limits = trajectory::PositionRange{-5.0, 5.0};
  ProfileLine line(options);
  EXPECT_EQ(line.ask(at(1.0)).error, AxisError::kNoSuchMode);
  EXPECT_EQ(line.ask(to(5.1)).error, AxisError::kOutsideRange);
  EXPECT_EQ(line.ask(by(-6.0)).error, AxisError::kOutsideRange);
  EXPECT_EQ(line.ask(to(std::nan(""))).error, AxisError::kNotFinite);
  ProfileLine endless(profile_options());
  EXPECT_EQ(endless.ask(to(12'900.0)).error, AxisError::kTooFar) << "2053 revolutions are more than 2^31 increments";
  EXPECT_EQ(endless.ask(by(-12'900.0)).error, AxisError::kTooFar);
  EXPECT_EQ(endless.state(), PlcopenState::kStandstill);
  auto fast = to(1.0);
  fast.velocity_si = 51.0;
  EXPECT_EQ(line.ask(fast).error, AxisError::kOverLimit);
  fast.velocity_si = 5.0;
  EXPECT_EQ(line.ask(fast).error, AxisError::kMode) << "6081h is not mapped";
  line.submit(request(AxisCommand::kMoveVelocity, 1.0));
  line.cycles(100);
  EXPECT_EQ(line.ask(to(1.0)).error, AxisError::kNotAtRest);
  SingleLine off(1, profile_options());
  EXPECT_EQ(off.ask(to(1.0)).error, AxisError::kNotEnabled);
  EXPECT_EQ(off.ask(at(60.0)).error, AxisError::kNotEnabled);
}

TEST(DriveProfile, AVelocityEndsAtTheSoftwareLimits) {
  auto options = profile_options();
  options.software_limits = trajectory::PositionRange{-5.0, 5.0};
  ProfileLine line(options);
  EXPECT_EQ(line.ask(at(10.0)).error, AxisError::kOutsideRange);
  line.cycles(1000);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  EXPECT_LT(line.now().position, 5.1) << "as the drive halts";
  EXPECT_EQ(line.ask(move(0.0)).phase, RequestPhase::kDone);
}

TEST(DriveProfile, AFaultOfTheDriveEndsIt) {
  for (const auto& asked : {by(10.0), at(20.0)}) {
    ProfileLine line;
    const auto driven = line.submit(asked);
    line.cycles(500);
    line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
    EXPECT_EQ(line.finish(driven).error, AxisError::kFault);
    line.cycles(8000);
    EXPECT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
    line.enable();
    line.expect_use();
  }
}

TEST(DriveProfile, SingleLostFramesAreNoMatter) {
  ProfileLine line;
  const double from = line.setpoint();
  for (const auto& asked : {by(3.0), by(-1.0), by(-2.0)}) {
    const auto driven = line.submit(asked);
    for (int cycle = 0; cycle < 20'000 && !line.axes().report(driven).over(); ++cycle) {
      line.lose_out = cycle % 3 == 1;
      line.lose_back = cycle % 5 == 1;
      line.cycle();
    }
    line.lose_out = line.lose_back = false;
    EXPECT_EQ(line.phase(driven), RequestPhase::kDone);
    line.cycles(200);
  }
  EXPECT_NEAR(line.now().position, from, 0.01) << "each distance once";
  line.expect_use();
}

TEST(DriveProfile, LostCommunicationOrAnAbsenceOfTheMasterEndsIt) {
  for (const bool lost : {true, false}) {
    ProfileLine line;
    const auto driven = line.submit(at(10.0));
    line.cycles(1000);
    if (lost) {
      lose_inputs(line, 20);
    } else {
      line.stall(9);
    }
    EXPECT_EQ(line.axes().report(driven).error, lost ? AxisError::kLost : AxisError::kMasterAway);
    EXPECT_EQ(line.state(), PlcopenState::kErrorStop);
    line.cycles(20'000);
    EXPECT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
    line.enable();
    line.expect_use();
  }
}

TEST(DriveProfile, ATargetThatIsNotReachedInTimeStopsTheAxis) {
  auto options = profile_options();
  options.target_timeout = milliseconds{200};
  ProfileLine line(options);
  EXPECT_EQ(line.ask(by(10.0)).error, AxisError::kTargetTimeout);
  EXPECT_EQ(line.state(), PlcopenState::kErrorStop);
}

/// Hides bit 12 of the status word: a drive that accepts no target.
class Deaf final : public motion::CycleTask {
 public:
  void update(const motion::TaskCycle& cycle) noexcept override { cycle.outputs[0] &= std::byte{0xEF}; }
};

TEST(DriveProfile, ADriveThatDoesNotTakeItsTargetIsStopped) {
  Deaf deaf;
  auto options = profile_options();
  options.task = &deaf;
  options.task_order = motion::TaskTiming::Order::kAfterMotion;
  ProfileLine line(options);
  EXPECT_EQ(line.ask(by(1.0)).error, AxisError::kNoTarget);
  EXPECT_EQ(line.state(), PlcopenState::kErrorStop);
}

TEST(DriveProfile, FromEveryCyclicModeAndBack) {
  for (const auto mode : {std::int8_t{9}, std::int8_t{10}}) {
    ProfileLine line;
    auto change = request(AxisCommand::kSetMode);
    change.mode = mode;
    ASSERT_EQ(line.ask(change).phase, RequestPhase::kDone);
    line.cycles(400);
    const double from = line.setpoint();
    EXPECT_EQ(line.ask(by(2.0)).phase, RequestPhase::kDone);
    line.cycles(400);
    EXPECT_EQ(line.now().mode, mode);
    EXPECT_NEAR(line.now().position, from + 2.0, 0.05);
  }
}

}  // namespace
}  // namespace driveline::bus_test
