// Set of setpoints in profile position mode: the drive gets its next target while it moves (MSD manual 12.2.1).
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "profile_line.hpp"

namespace driveline::bus_test {
namespace {

using slaves::msd::Variant;

constexpr int kTimeout = 20'000;                 ///< cycles
constexpr std::uint16_t kAcknowledged = 0x1000;  ///< bit 12 of the status word

AxisRequest then(AxisRequest asked) {
  asked.buffer = BufferMode::kBuffered;
  return asked;
}

std::uint16_t status_word(ProfileLine& line) {
  return line.axes().axes()[0].inputs().status_word;
}

class EverySetpointSet : public testing::TestWithParam<Variant> {};

TEST_P(EverySetpointSet, TheNextTargetFollowsWhereTheOneBeforeIsReached) {
  ProfileLine line(profile_options(GetParam()));
  const double from = line.setpoint();
  const std::vector<std::uint64_t> asked{line.submit(to(from + 4.0)), line.submit(then(to(from + 6.0))),
                                         line.submit(then(by(-3.0)))};
  const std::vector<double> ends{4.0, 6.0, 3.0};
  int held = 0;
  int elsewhere = 0;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    for (int cycle = 0; cycle < kTimeout && !line.axes().report(asked[i]).over(); ++cycle) {
      line.cycle();
      if ((status_word(line) & kAcknowledged) != 0 && std::abs(line.now().velocity) > 5.0) ++held;
      if (line.phase(asked[0]) == RequestPhase::kDone && i < 2 && line.now().mode != 1) ++elsewhere;
    }
    EXPECT_EQ(line.phase(asked[i]), RequestPhase::kDone);
    EXPECT_NEAR(line.now().position, from + ends[i], 0.02) << i;
    EXPECT_LT(std::abs(line.now().velocity), 1.0) << "it has stopped there";
    for (std::size_t later = i + 1; later < asked.size(); ++later)
      EXPECT_EQ(line.phase(asked[later]), later == i + 1 ? RequestPhase::kActive : RequestPhase::kWaiting);
  }
  EXPECT_GT(held, 1000) << "the drive had its next target while it moved";
  EXPECT_EQ(elsewhere, 0) << "it stays in its mode";
  line.expect_use();
  line.expect_obedience();
}

TEST_P(EverySetpointSet, AnotherTargetAtOnceReplacesThoseThatWait) {
  ProfileLine line(profile_options(GetParam()));
  const double from = line.setpoint();
  std::vector<std::uint64_t> asked{line.submit(to(from + 8.0)), line.submit(then(to(from + 9.0))),
                                   line.submit(then(to(from + 10.0)))};
  line.cycles(1500);
  EXPECT_NE(status_word(line) & kAcknowledged, 0) << "the drive has no room";
  const auto back = line.submit(to(from - 1.0));
  line.cycles(2);
  for (const auto id : asked) EXPECT_EQ(line.phase(id), RequestPhase::kAborted);
  double farthest = from;
  for (int cycle = 0; cycle < kTimeout && !line.axes().report(back).over(); ++cycle) {
    line.cycle();
    farthest = std::max(farthest, line.now().position);
  }
  EXPECT_EQ(line.phase(back), RequestPhase::kDone);
  EXPECT_LT(farthest, from + 5.0);
  line.cycles(2000);
  EXPECT_NEAR(line.now().position, from - 1.0, 0.01);
  line.expect_use();
  line.expect_obedience();
}

INSTANTIATE_TEST_SUITE_P(OfDrives, EverySetpointSet, testing::Values(Variant::kMsd, Variant::kServoOne),
                         [](const auto& row) { return std::string(row.param == Variant::kMsd ? "Msd" : "ServoOne"); });

TEST(SetpointSet, EachTargetHasItsVelocityWhereThatIsMapped) {
  ProfileLine line(mapped_options());
  auto first = by(1.0);
  first.velocity_si = 4.0;
  auto second = then(by(3.0));
  second.velocity_si = 20.0;
  const auto slow = line.submit(first);
  const auto fast = line.submit(second);
  double fastest = 0.0;
  for (int cycle = 0; cycle < kTimeout && !line.axes().report(slow).over(); ++cycle) {
    line.cycle();
    fastest = std::max(fastest, std::abs(line.now().velocity));
  }
  EXPECT_NEAR(fastest, 4.0, 0.2);
  EXPECT_NEAR(line.fastest(4000), 20.0, 0.5);
  EXPECT_EQ(line.phase(fast), RequestPhase::kDone);
}

TEST(SetpointSet, AStopAtAnyMomentEndsAllAndLeavesTheAxisAtRest) {
  for (const int moment : {0, 1, 5, 9, 12, 20, 24, 40, 400}) {
    SCOPED_TRACE(moment);
    ProfileLine line;
    const std::vector<std::uint64_t> asked{line.submit(by(10.0)), line.submit(then(by(10.0))),
                                           line.submit(then(by(10.0)))};
    line.cycles(moment);
    EXPECT_EQ(line.ask(request(AxisCommand::kStop)).phase, RequestPhase::kDone);
    for (const auto id : asked) EXPECT_EQ(line.phase(id), RequestPhase::kAborted);
    EXPECT_EQ(line.ask(request(AxisCommand::kReleaseStop)).phase, RequestPhase::kDone);
    const double from = line.setpoint();
    EXPECT_EQ(line.ask(by(0.5)).phase, RequestPhase::kDone);
    line.cycles(1000);
    EXPECT_NEAR(line.now().position, from + 0.5, 0.02) << "the drive has forgotten the others";
    line.expect_use();
  }
}

/// Whether the drive moves, has arrived, or returns to its cyclic mode.
TEST(SetpointSet, OneThatComesLateIsReachedAllTheSame) {
  int cycles_of_first = 0;
  {
    ProfileLine line;
    const auto first = line.submit(by(1.0));
    for (; !line.axes().report(first).over(); ++cycles_of_first) line.cycle();
  }
  for (int moment = cycles_of_first - 60; moment <= cycles_of_first + 2; ++moment) {
    SCOPED_TRACE(moment - cycles_of_first);
    ProfileLine line;
    const double from = line.setpoint();
    const auto first = line.submit(by(1.0));
    line.cycles(moment);
    EXPECT_EQ(line.ask(then(to(from + 1.5))).phase, RequestPhase::kDone);
    EXPECT_EQ(line.phase(first), RequestPhase::kDone);
    line.cycles(200);
    EXPECT_NEAR(line.now().position, from + 1.5, 0.01);
    EXPECT_EQ(line.now().mode, 8);
  }
}

TEST(SetpointSet, SingleLostFramesAreNoMatter) {
  ProfileLine line;
  const double from = line.setpoint();
  std::vector<std::uint64_t> asked{line.submit(by(1.0))};
  for (const double way : {-2.0, 0.5, 1.5}) asked.push_back(line.submit(then(by(way))));
  for (int cycle = 0; cycle < 40'000 && !line.axes().report(asked.back()).over(); ++cycle) {
    line.lose_out = cycle % 3 == 1;
    line.lose_back = cycle % 5 == 1;
    line.cycle();
  }
  line.lose_out = line.lose_back = false;
  for (const auto id : asked) EXPECT_EQ(line.phase(id), RequestPhase::kDone);
  line.cycles(200);
  EXPECT_NEAR(line.now().position, from + 1.0, 0.01) << "each distance once";
  line.expect_use();
}

TEST(SetpointSet, EightWaitBesideTheOneThatTheDriveHolds) {
  ProfileLine line;
  line.submit(by(20.0));
  std::vector<std::uint64_t> waiting;
  for (int i = 0; i < 3; ++i) waiting.push_back(line.submit(then(by(0.1))));
  line.cycles(400);
  for (int i = 0; i < 7; ++i) waiting.push_back(line.submit(then(by(0.1))));
  line.cycles(4);
  EXPECT_EQ(line.phase(waiting[8]), RequestPhase::kWaiting);
  EXPECT_EQ(line.axes().report(waiting[9]).error, AxisError::kBufferFull);
}

TEST(SetpointSet, EachTargetHasItsTimeToBeReached) {
  auto options = profile_options();
  options.target_timeout = milliseconds{500};
  ProfileLine line(options);
  const auto first = line.submit(by(4.0));
  EXPECT_EQ(line.ask(then(by(4.0))).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(first), RequestPhase::kDone);
}

TEST(SetpointSet, IsRefusedWithTheReason) {
  auto options = profile_options();
  options.software_limits = trajectory::PositionRange{-5.0, 5.0};
  ProfileLine line(options);
  line.submit(to(4.0));
  line.cycles(100);
  const auto within = line.submit(then(by(0.9)));
  const auto beyond = line.submit(then(by(0.2)));
  auto blended = to(1.0);
  blended.buffer = BufferMode::kBlendingLow;
  const auto never = line.submit(blended);
  line.cycles(2);
  EXPECT_EQ(line.phase(within), RequestPhase::kWaiting);
  EXPECT_EQ(line.axes().report(beyond).error, AxisError::kOutsideRange) << "from the target before";
  EXPECT_EQ(line.axes().report(never).error, AxisError::kMode) << "the drive stops at each";
  line.submit(request(AxisCommand::kHalt));
  line.cycles(10);
  EXPECT_EQ(line.ask(then(to(1.0))).error, AxisError::kNotAtRest) << "the drive is halted";
}

TEST(SetpointSet, AFaultOfTheDriveEndsAll) {
  ProfileLine line;
  const auto driven = line.submit(by(10.0));
  const auto held = line.submit(then(by(1.0)));
  const auto waiting = line.submit(then(by(1.0)));
  line.cycles(500);
  line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
  EXPECT_EQ(line.finish(driven).error, AxisError::kFault);
  for (const auto id : {held, waiting}) {
    EXPECT_EQ(line.phase(id), RequestPhase::kAborted);
    EXPECT_EQ(line.axes().report(id).error, AxisError::kFault);
  }
  line.cycles(8000);
  EXPECT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
  line.enable();
  line.expect_use();
}

}  // namespace
}  // namespace driveline::bus_test
