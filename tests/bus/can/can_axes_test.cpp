// Axes on a CAN bus under the cycle of the master: eight simulated drives at 2 ms, in interpolated position mode.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "axis_line.hpp"
#include "demand_watch.hpp"
#include "drive_line.hpp"
#include "driveline/canopen_client/sdo_client.hpp"
#include "driveline/motion/axis/startup_sdos.hpp"

namespace driveline::bus_test {
namespace {

using canopen::Frame;
using motion::AxisCommand;
using motion::AxisRequest;
using motion::MotionPhase;
using motion::RequestPhase;
using namespace std::chrono_literals;

double worst_following_error(const std::vector<snapshot::AxisSample>& samples) {
  double worst = 0.0;
  for (const auto& sample : samples) worst = std::max(worst, std::abs(sample.following_error));
  return worst;
}

/// A line that follows its path.
class CanPathLine : public CanAxisLine {
 public:
  explicit CanPathLine(const CanAxesOptions& options = {}) : CanAxisLine(options) {
    EXPECT_EQ(configure(), "");
    start_cycle();
    run(20ms);
    motion().request_start();
    EXPECT_TRUE(run_until(MotionPhase::kFollowing, 3s)) << to_text(motion().phase());
    axis_samples.clear();
    line_samples.clear();
    for (std::size_t axis = 0; axis < size(); ++axis) watches_.emplace_back(drive(axis), options.limits);
  }
  void judged_cycle() {
    cycle();
    look();
  }
  /// Whole periods without a cycle, and a part of one.
  void stay_away(int periods, nanoseconds part) {
    for (int i = 0; i < periods; ++i) {
      leave_alone(plan().period);
      look();
    }
    leave_alone(part);
  }
  /// Runs to the end of the path, and some cycles beyond it.
  [[nodiscard]] bool finish() {
    for (int i = 0; i < 2500 && motion().phase() != MotionPhase::kHolding; ++i) judged_cycle();
    const bool held = motion().phase() == MotionPhase::kHolding;
    for (int i = 0; i < 20; ++i) judged_cycle();
    return held && motion().phase() == MotionPhase::kHolding;
  }
  /// The first demand of a drive beyond the limits of its axis; empty: there is none.
  [[nodiscard]] std::string finding() const {
    for (std::size_t axis = 0; axis < watches_.size(); ++axis) {
      if (!watches_[axis].finding().empty()) return "axis " + std::to_string(axis) + ": " + watches_[axis].finding();
    }
    return {};
  }
  [[nodiscard]] std::uint64_t judged() const {
    std::uint64_t sum = 0;
    for (const auto& watch : watches_) sum += watch.judged();
    return sum;
  }

 private:
  void look() {
    for (auto& watch : watches_) watch.look(clock.now());
  }
  std::vector<DemandWatch> watches_;
};

// The path has 1 rad in 0.4 s: 7.9 rad/s and 123 rad/s^2 at the most.
TEST(CanAxes, FollowAPathInInterpolatedPosition) {
  CanPathLine line;
  ASSERT_TRUE(line.finish()) << to_text(line.motion().phase());
  for (const auto& sample : line.axis_samples) ASSERT_EQ(sample.mode, 7);
  EXPECT_LT(worst_following_error(line.axis_samples), 2e-3);
  const auto& figures = line.statistics();
  EXPECT_EQ(figures.lost_frames, 0U);
  EXPECT_EQ(figures.stale_frames, 0U);
  EXPECT_EQ(figures.wkc_errors, 0U);
  EXPECT_EQ(line.can_cycle().counters().rpdos_unsent, 0U);
  for (const auto& sample : line.line_samples) {
    ASSERT_EQ(sample.working_counter, 8);
    ASSERT_EQ(sample.expected_working_counter, 8);
    // Between the sum without stuff bits and that of the worst case, control words that are repeated included.
    ASSERT_GT(sample.bus_load, 0.7195F);
    ASSERT_LT(sample.bus_load, 0.8675F);
  }
}

/// The same path and drives over EtherCAT in CSP, at the same cycle time.
double worst_following_error_of_csp() {
  RunOptions options;
  options.period = 2ms;
  DriveLine drives(8);
  LineOperation operation(drives, options);
  EXPECT_EQ(sentence(operation.to_motion()), "");
  EXPECT_TRUE(operation.run_until(MotionPhase::kFollowing, 3s));
  operation.axis_samples.clear();
  EXPECT_TRUE(operation.run_until(MotionPhase::kHolding, 5s));
  return worst_following_error(operation.axis_samples);
}

TEST(CanAxes, FollowAsCloselyAsOnEtherCat) {
  CanAxesOptions options;
  options.limits = {50.0, 1000.0};
  CanPathLine line(options);
  ASSERT_TRUE(line.finish());
  const double on_can = worst_following_error(line.axis_samples);
  const double on_ether_cat = worst_following_error_of_csp();
  std::printf("worst following error at 2 ms: %.6f rad on CAN, %.6f rad on EtherCAT\n", on_can, on_ether_cat);
  EXPECT_LE(on_can, 1.5 * on_ether_cat);
}

/// A sum over all frames, and all samples.
std::pair<std::uint64_t, double> outcome_of_a_run() {
  CanPathLine line;
  EXPECT_TRUE(line.finish());
  double sum = 0.0;
  for (const auto& sample : line.axis_samples) sum += sample.actual_position;
  return {line.port().sum(), sum};
}

TEST(CanAxes, TwoRunsHaveTheSameFramesAtTheSameTime) {
  const auto first = outcome_of_a_run();
  const auto second = outcome_of_a_run();
  EXPECT_EQ(first.first, second.first);
  EXPECT_EQ(first.second, second.second);
}

struct HarmRow {
  const char* what;
  /// Harms cycle `n` of the path, before it runs.
  void (*harm)(CanPathLine& line, int n);
  std::uint64_t lost;  ///< TPDOs that the figures must show as lost
  std::int64_t missed;
};

class CanAxesHarmed : public testing::TestWithParam<HarmRow> {};

bool is_tpdo(const Frame& frame, std::uint32_t node) {
  return frame.identifier.value == 0x180 + node;
}

// What is lost now and then costs accuracy, never a leap: the path goes on, and no target asks for more than its axis
// may.
TEST_P(CanAxesHarmed, TheTargetsObeyTheLimitsAndThePathIsFinished) {
  const auto& row = GetParam();
  CanAxesOptions options;
  options.limits = {50.0, 1000.0};
  CanPathLine line(options);
  const auto lost = line.statistics().lost_frames;
  const auto missed = line.statistics().missed_periods;
  for (int n = 0; n < 1000 && line.motion().phase() == MotionPhase::kFollowing; ++n) {
    row.harm(line, n);
    line.judged_cycle();
    line.port().lose_sent = line.port().lose_received = nullptr;
  }
  ASSERT_TRUE(line.finish()) << to_text(line.motion().phase());
  EXPECT_EQ(line.finding(), "");
  EXPECT_GT(line.judged(), 8U * 150U);
  EXPECT_EQ(line.statistics().lost_frames - lost, row.lost);
  EXPECT_EQ(static_cast<std::int64_t>(line.statistics().missed_periods - missed), row.missed);
  for (std::size_t axis = 0; axis < line.size(); ++axis) {
    EXPECT_FALSE(line.drive(axis).fault()) << axis;
    EXPECT_NEAR(line.axis_samples[line.axis_samples.size() - line.size() + axis].target_position, 0.1, 1e-6) << axis;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Harm, CanAxesHarmed,
    testing::Values(HarmRow{"AnswerLost",
                            [](CanPathLine& line, int n) {
                              if (n == 70) line.port().lose_received = [](const Frame& f) { return is_tpdo(f, 5); };
                            },
                            1, 0},
                    HarmRow{"ThreeAnswersLost",
                            [](CanPathLine& line, int n) {
                              if (n >= 70 && n < 73) {
                                line.port().lose_received = [](const Frame& f) { return is_tpdo(f, 5); };
                              }
                            },
                            3, 0},
                    HarmRow{"SyncLost",
                            [](CanPathLine& line, int n) {
                              if (n == 70)
                                line.port().lose_sent = [](const Frame& f) { return f.identifier.value == 0x080; };
                            },
                            8, 0},
                    HarmRow{"SetpointLost",
                            [](CanPathLine& line, int n) {
                              if (n == 70)
                                line.port().lose_sent = [](const Frame& f) { return f.identifier.value == 0x305; };
                            },
                            0, 0},
                    HarmRow{"LateCycle",
                            [](CanPathLine& line, int n) {
                              if (n == 70) line.stay_away(1, 150us);
                            },
                            0, 0},
                    HarmRow{"MissedPeriods",
                            [](CanPathLine& line, int n) {
                              if (n == 70) line.stay_away(4, 150us);
                            },
                            0, 3}),
    [](const auto& row) { return row.param.what; });

// The drives have their setpoints, and go on.
TEST(CanAxes, AnswersThatAreLostDoNotHoldUpThePath) {
  CanPathLine line;
  for (int n = 0; n < 60; ++n) line.judged_cycle();
  line.port().lose_received = [](const Frame& f) { return is_tpdo(f, 5) || is_tpdo(f, 6); };
  for (int n = 0; n < 4; ++n) line.judged_cycle();
  line.port().lose_received = nullptr;
  ASSERT_TRUE(line.finish()) << to_text(line.motion().phase());
  EXPECT_EQ(line.finding(), "");
  EXPECT_EQ(line.statistics().lost_frames, 8U);
  EXPECT_EQ(line.motion().path_late(), 0ns);
}

/// Axes that are commanded one by one.
class CanSingleLine : public CanAxisLine {
 public:
  explicit CanSingleLine(CanAxesOptions options) : CanAxisLine(with_requests(std::move(options))) {
    EXPECT_EQ(configure(), "");
    start_cycle();
    run(100ms);
  }
  [[nodiscard]] static CanAxesOptions with_requests(CanAxesOptions options) {
    options.single_axes = true;
    return options;
  }
  motion::RequestReport ask(AxisRequest request, std::size_t axis = 0) {
    const auto id = single_axes().submit(axis, request);
    for (int i = 0; i < 4000 && !single_axes().report(id).over(); ++i) cycle();
    return single_axes().report(id);
  }
  motion::RequestReport ask(AxisCommand command, double target = 0.0, std::size_t axis = 0) {
    AxisRequest request;
    request.command = command;
    request.target_si = target;
    request.on = true;
    return ask(request, axis);
  }
  void enable(std::size_t axis = 0) {
    ASSERT_EQ(ask(AxisCommand::kPower, 0.0, axis).phase, RequestPhase::kDone);
    run(50ms);
  }
  [[nodiscard]] motion::AxisReport now(std::size_t axis = 0) { return single_axes().axis_report(axis); }
};

/// What an axis that moves evenly gets instead of its setpoints.
struct LackRow {
  const char* what;
  int refused;       ///< setpoints that the adapter refuses, before the master is away
  int missed;        ///< periods without a cycle
  int missed_again;  ///< the same after the next cycles
  motion::AxisError error;
};

class CanAbsences : public testing::TestWithParam<LackRow> {};

/// A drive bridges eight setpoints. Behind an absence it lacks one more than periods were missed, because the last
/// setpoint waited for SYNC (CiA 301 7.2.2.2), which is withheld until there is a new one.
TEST_P(CanAbsences, AnAxisIsStoppedWhenItsDriveLacksMoreThanItBridges) {
  const auto& row = GetParam();
  CanAxesOptions options;
  options.axes = 2;
  options.limits = {50.0, 1000.0};
  CanSingleLine line(options);
  line.enable();
  AxisRequest request;
  request.command = AxisCommand::kMoveVelocity;
  request.target_si = -30.0;
  ASSERT_NE(line.single_axes().submit(0, request), 0U);
  line.run(100ms);
  ASSERT_EQ(line.now().state, motion::PlcopenState::kContinuousMotion);
  DemandWatch watch(line.drive(0), options.limits);
  const auto look = [&] { watch.look(line.clock.now()); };
  const auto refuse = [&](int count) {
    line.port().refuse = [](const Frame& frame) { return frame.identifier.value == 0x303; };
    for (; count > 0; --count, look()) line.cycle();
    line.port().refuse = nullptr;
  };
  const auto stay_away = [&](int periods) {
    for (int i = 0; i < periods; ++i, look()) line.leave_alone(options.period);
    line.leave_alone(150us);
  };
  const auto missed = line.statistics().missed_periods;
  refuse(row.refused);
  for (const int periods : {row.missed, row.missed_again}) {
    if (periods == 0) continue;
    stay_away(periods + 1);
    line.cycle();
  }
  for (int i = 0; i < 100; ++i, look()) line.cycle();
  EXPECT_EQ(static_cast<int>(line.statistics().missed_periods - missed), row.missed + row.missed_again);
  const bool stopped = row.error != motion::AxisError::kNone;
  EXPECT_EQ(line.now().state, stopped ? motion::PlcopenState::kErrorStop : motion::PlcopenState::kContinuousMotion);
  EXPECT_EQ(line.now().error, row.error) << to_text(line.now().error) << ", " << line.drive(0).display();
  EXPECT_NEAR(line.drive(0).velocity_rad_s(), stopped ? 0.0 : -30.0, 0.3);
  EXPECT_EQ(watch.finding(), "");
}

INSTANTIATE_TEST_SUITE_P(Rows, CanAbsences,
                         testing::Values(LackRow{"FivePeriodsBehindRefusals", 3, 5, 0, motion::AxisError::kNone},
                                         LackRow{"SixPeriodsBehindRefusals", 3, 6, 0, motion::AxisError::kMasterAway},
                                         LackRow{"TwiceThreePeriods", 0, 3, 3, motion::AxisError::kNone}),
                         [](const auto& row) { return row.param.what; });

TEST(CanAxes, MoveByRequests) {
  CanSingleLine line({.axes = 3});
  for (std::size_t axis = 0; axis < 3; ++axis) line.enable(axis);
  EXPECT_EQ(line.now().mode, 7);
  EXPECT_EQ(line.ask(AxisCommand::kMoveAbsolute, 5.0, 1).phase, RequestPhase::kDone);
  line.run(100ms);
  EXPECT_NEAR(line.now(1).position, 5.0, 1e-3);
  EXPECT_EQ(line.ask(AxisCommand::kMoveRelative, -2.0, 1).phase, RequestPhase::kDone);
  line.run(100ms);
  EXPECT_NEAR(line.now(1).position, 3.0, 1e-3);
  EXPECT_NEAR(line.now(2).position, 0.02, 1e-3);
}

// Homing method 37: the present position is home.
TEST(CanAxes, HomeByTheDriveAndReturnToInterpolatedPosition) {
  CanAxesOptions options;
  options.axes = 2;
  options.startup.push_back(motion::startup_sdo(0x6098, 0, std::int8_t{37}));
  CanSingleLine line(options);
  line.enable();
  EXPECT_EQ(line.ask(AxisCommand::kMoveAbsolute, 2.0).phase, RequestPhase::kDone);
  line.run(100ms);
  const auto homed = line.ask(AxisCommand::kHome);
  EXPECT_EQ(homed.phase, RequestPhase::kDone) << to_text(homed.error);
  line.run(100ms);
  EXPECT_EQ(line.now().mode, 7);
  EXPECT_NEAR(line.now().position, 0.0, 1e-3);
  EXPECT_EQ(line.ask(AxisCommand::kMoveAbsolute, 1.0).phase, RequestPhase::kDone);
  line.run(100ms);
  EXPECT_NEAR(line.now().position, 1.0, 1e-3);
}

TEST(CanAxes, MoveByTheProfilesOfTheDriveAndReturn) {
  CanAxesOptions options;
  options.axes = 2;
  options.profile = true;
  CanSingleLine line(options);
  line.enable();
  const auto moved = line.ask(AxisCommand::kDriveMoveAbsolute, 3.0);
  EXPECT_EQ(moved.phase, RequestPhase::kDone) << to_text(moved.error);
  line.run(100ms);
  EXPECT_EQ(line.now().mode, 7);
  EXPECT_NEAR(line.now().position, 3.0, 1e-3);
  EXPECT_EQ(line.ask(AxisCommand::kMoveAbsolute, 1.0).phase, RequestPhase::kDone);
  line.run(100ms);
  EXPECT_NEAR(line.now().position, 1.0, 1e-3);
}

// Modes that exist on EtherCAT only.
TEST(CanAxes, HaveNoCyclicModes) {
  CanSingleLine line({.axes = 1});
  line.enable();
  for (const auto mode : {std::int8_t{8}, std::int8_t{9}, std::int8_t{10}}) {
    AxisRequest request;
    request.command = AxisCommand::kSetMode;
    request.mode = mode;
    EXPECT_EQ(line.ask(request).error, motion::AxisError::kNoSuchMode) << int{mode};
  }
  EXPECT_EQ(line.now().mode, 7);
}

// An owner reads and writes objects while the cycle runs at 87 % of the bus.
TEST(CanAxes, SdosPassWhileTheAxesMove) {
  CanPathLine line;
  canopen::AcyclicPort port(line.channel(), line.clock, line.plan().period,
                            [&](nanoseconds duration) { line.runner().pass(duration); });
  canopen::BusLink link(port, line.clock);
  canopen::SdoClient client(link, 4);
  for (int i = 0; i < 20; ++i) {
    const auto type = client.upload_number({0x1000, 0});
    ASSERT_TRUE(type) << describe(type.error());
    EXPECT_EQ(*type & 0xFFFFU, 402U);
  }
  ASSERT_TRUE(line.finish());
  EXPECT_EQ(line.statistics().lost_frames, 0U);
}

}  // namespace
}  // namespace driveline::bus_test
