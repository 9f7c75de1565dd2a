#include <gmock/gmock.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "drive_line.hpp"
#include "driveline/ecat_master/state_machine.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::MotionFailure;
using motion::MotionPhase;
using motion::cia402::Mode;
using snapshot::AxisState;
using wire::AlState;

TEST(Configuration, TakesAllDrivesToSafeOp) {
  DriveLine drives(8);
  ConfiguredOperation operation(drives);
  EXPECT_TRUE(drives.all_in(AlState::kSafeOp));
  // 16 + 8 + 32 bits, 2 * 32, 2 * 16: 19 bytes each way (MSD manual 8.3.4); a byte of AL status, one of the mailbox.
  const auto& image = operation.master().image();
  EXPECT_EQ(image.outputs().size(), 8U * 21);
  ASSERT_EQ(image.datagrams().size(), 1U);
  EXPECT_EQ(image.datagrams()[0].expected_working_counter, 8 * 3);
  for (std::size_t i = 0; i < 8; ++i) {
    const auto& memory = drives.slave(i).esc().memory();
    EXPECT_EQ(bytes::load_le<std::uint16_t>(memory.at(wire::reg::kSyncManager.at(2) + 2U, 2)), 19);
    EXPECT_EQ(bytes::load_le<std::uint16_t>(memory.at(wire::reg::kSyncManager.at(3) + 2U, 2)), 19);
  }
}

/// The master takes the whole line through the states by itself, or an application asks for single transitions of
/// single slaves, of its choice and in its order.
TEST(Configuration, TransitionsAreTheMastersOrTheApplications) {
  DriveLine drives(3);
  ConfiguredOperation operation(drives);
  EXPECT_TRUE(drives.all_in(AlState::kSafeOp)) << "the master's";
  auto& bus = operation.master().bus();
  const auto states = [&] { return std::array{drives.state(0), drives.state(1), drives.state(2)}; };
  const auto take = [&](std::size_t drive, AlState state) {
    const auto slave = operation.master().slaves()[drive].info.ref;
    return sentence(ecat_master::change_state(bus, std::array{slave}, state, ecat_master::kOpTimeout));
  };
  EXPECT_EQ(take(1, AlState::kPreOp), "");
  EXPECT_EQ(states(), (std::array{AlState::kSafeOp, AlState::kPreOp, AlState::kSafeOp}));
  EXPECT_EQ(take(2, AlState::kInit), "");
  EXPECT_EQ(states(), (std::array{AlState::kSafeOp, AlState::kPreOp, AlState::kInit}));
  EXPECT_EQ(take(1, AlState::kSafeOp), "") << "step by step back up";
  EXPECT_EQ(take(2, AlState::kPreOp), "");
  EXPECT_EQ(states(), (std::array{AlState::kSafeOp, AlState::kSafeOp, AlState::kPreOp}));
}

TEST(Configuration, WritesStartupParametersIntoTheDrives) {
  DriveLine drives(1);
  ConfiguredOperation operation(drives, RunOptions{.period = milliseconds{2}});
  const auto& dictionary = drives.drive(0).dictionary();
  using slaves::msd::kValue;
  EXPECT_EQ(dictionary.get(kValue.interpolation_period_value), 2);
  EXPECT_EQ(dictionary.get(kValue.interpolation_period_index), -3);
  EXPECT_FLOAT_EQ(dictionary.get(kValue.reference_cycle), 2.0F) << "P 306, ms";
  EXPECT_EQ(dictionary.get(kValue.interpolation_type), 3) << "P 370, cubic spline";
}

TEST(Operation, BringsAllDrivesToOpWithoutAWorkingCounterError) {
  DriveLine drives(8);
  IdleOperation operation(drives);
  EXPECT_TRUE(drives.all_in(AlState::kOp));
  operation.run(milliseconds{50});
  const auto& statistics = operation.statistics();
  EXPECT_GE(statistics.cycles, 400U);
  EXPECT_EQ(statistics.wkc_errors, 0U);
  EXPECT_EQ(statistics.lost_frames, 0U);
  EXPECT_EQ(statistics.stale_frames, 0U);
  EXPECT_EQ(statistics.foreign_frames, 0U);
  EXPECT_EQ(statistics.missed_periods, 0U);
  EXPECT_TRUE(operation.master().core()->al_status().all_op(8));
  for (const auto& sample : operation.line_samples) {
    EXPECT_TRUE(sample.frame_received);
    EXPECT_EQ(sample.working_counter, 24);
    EXPECT_EQ(sample.expected_working_counter, 24);
  }
}

TEST(Operation, SixtyFourDrivesInOp) {
  DriveLine drives(64);
  IdleOperation operation(drives);
  EXPECT_TRUE(drives.all_in(AlState::kOp));
  EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  EXPECT_EQ(operation.statistics().lost_frames, 0U);
}

TEST(Operation, MoreDrivesThanOneFrameHolds) {
  DriveLine drives(80);
  // Half the delay of real controllers, or the answer would arrive after the end of a 125 us cycle.
  IdleOperation operation(drives, RunOptions{.period = microseconds{250}});
  EXPECT_EQ(operation.master().image().datagrams().size(), 2U);
  EXPECT_TRUE(drives.all_in(AlState::kOp));
  operation.run(milliseconds{5});
  EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  EXPECT_EQ(operation.statistics().lost_frames, 0U);
  ASSERT_FALSE(operation.line_samples.empty());
  EXPECT_EQ(operation.line_samples.back().working_counter, 240);
}

struct ModeCase {
  Mode mode;
  nanoseconds period;
  double tolerance_rad;  ///< lag of the drive behind the setpoint, friction in CST
  const char* name;
};

class Tracking : public testing::TestWithParam<ModeCase> {};

TEST_P(Tracking, TheMotorsGoWhereThePathLeads) {
  const auto& test = GetParam();
  DriveLine drives(3);
  LineOperation operation(drives, RunOptions{.period = test.period, .mode = test.mode});
  ASSERT_EQ(sentence(operation.to_motion()), "");
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}))
      << to_text(operation.motion().phase());
  double worst_rad = 0.0;
  double farthest_rad = 0.0;
  while (operation.motion().phase() == MotionPhase::kFollowing) {
    operation.cycle();
    for (std::size_t i = 0; i < drives.size(); ++i) {
      const double truth = drives.drive(i).position_rad();
      worst_rad = std::max(worst_rad, std::abs(truth - operation.motion().setpoints()[i].position));
      farthest_rad = std::max(farthest_rad, truth);
    }
  }
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kHolding);
  EXPECT_LT(worst_rad, test.tolerance_rad);
  EXPECT_GT(farthest_rad, 1.1 - test.tolerance_rad) << "the peak of axis 0's path is at 1.1 rad";
  EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  EXPECT_EQ(operation.statistics().lost_frames, 0U);
  operation.run(milliseconds{300});
  for (std::size_t i = 0; i < drives.size(); ++i) {
    EXPECT_NEAR(drives.drive(i).position_rad(), 0.1, test.tolerance_rad) << "end of the path, drive " << i;
    EXPECT_NEAR(operation.motion().axes()[i].inputs().position, drives.drive(i).position_rad(), 1e-4);
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, Tracking,
                         testing::Values(ModeCase{Mode::kCyclicPosition, microseconds{125}, 0.02, "Csp125us"},
                                         ModeCase{Mode::kCyclicPosition, milliseconds{1}, 0.04, "Csp1ms"},
                                         ModeCase{Mode::kCyclicVelocity, microseconds{125}, 0.05, "Csv"},
                                         ModeCase{Mode::kCyclicTorque, microseconds{125}, 0.06, "Cst"}),
                         [](const auto& test) { return std::string(test.param.name); });

/// Runs all drives along the path to its end; returns the farthest position of axis 0.
double peak_of_a_run(DriveLine& drives, const RunOptions& options) {
  FollowingOperation operation(drives, options);
  double peak = 0.0;
  while (operation.motion().phase() == MotionPhase::kFollowing) {
    operation.cycle();
    peak = std::max(peak, drives.drive(0).position_rad());
  }
  operation.run(milliseconds{300});
  EXPECT_EQ(sentence(operation.master().shut_down()), "");
  return peak;
}

TEST(RelativePath, BeginsWhereTheAxesStand) {
  // The path of the tests leads from 0.1 rad to 1.1 rad and back.
  DriveLine drives(2);
  EXPECT_NEAR(peak_of_a_run(drives, {.relative = true}), 1.0, 0.02);
  EXPECT_NEAR(drives.drive(0).position_rad(), 0.0, 0.01);
  EXPECT_NEAR(drives.drive(1).position_rad(), -0.25, 0.01) << "where it stood at power-on";
  EXPECT_NEAR(peak_of_a_run(drives, {}), 1.1, 0.02);
  EXPECT_NEAR(drives.drive(0).position_rad(), 0.1, 0.01);
  EXPECT_NEAR(peak_of_a_run(drives, {.relative = true}), 1.1, 0.02);
  EXPECT_NEAR(drives.drive(0).position_rad(), 0.1, 0.01) << "from 0.1 rad, not from 0.2";
}

TEST(RelativePath, StaysInItsPlaceWhenItIsRepeated) {
  DriveLine drives(1);
  FollowingOperation operation(drives, RunOptions{.repeat = true, .relative = true});
  double peak = 0.0;
  double lowest = 0.0;
  operation.axis_samples.clear();
  operation.run(milliseconds{2000});
  for (const auto& sample : operation.axis_samples) {
    peak = std::max(peak, sample.actual_position);
    lowest = std::min(lowest, sample.actual_position);
  }
  EXPECT_NEAR(peak, 1.0, 0.02);
  EXPECT_NEAR(lowest, 0.0, 0.02);
}

TEST(BringUp, PassesEveryStateOfCia402) {
  DriveLine drives(3);
  FollowingOperation operation(drives);
  for (std::uint16_t axis = 0; axis < 3; ++axis) {
    std::vector<AxisState> states;
    for (const auto& sample : operation.axis_samples) {
      if (sample.axis == axis && (states.empty() || states.back() != sample.state)) states.push_back(sample.state);
    }
    // The first cycles run in SAFEOP, but already have inputs.
    EXPECT_THAT(states, testing::ElementsAre(AxisState::kSwitchOnDisabled, AxisState::kReadyToSwitchOn,
                                             AxisState::kSwitchedOn, AxisState::kOperationEnabled))
        << "axis " << axis;
  }
}

TEST(BringUp, DoesNotMoveTheAxesBeforeTheApproach) {
  DriveLine drives(2);
  LineOperation operation(drives);
  const double start = drives.drive(1).position_rad();
  ASSERT_EQ(sentence(operation.to_motion()), "");
  ASSERT_TRUE(operation.run_until(MotionPhase::kApproach, std::chrono::seconds{2}));
  EXPECT_NEAR(drives.drive(1).position_rad(), start, 1e-4);
  EXPECT_NEAR(operation.motion().setpoints()[1].position, start, 1e-4);
}

TEST(ShutDown, SwitchesTheDrivesOffAndTakesThemToInit) {
  DriveLine drives(3);
  FollowingOperation operation(drives);
  operation.run(milliseconds{100});
  operation.motion().request_stop();
  ASSERT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
  operation.run(milliseconds{5});
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(drives.drive(i).state(), slaves::PowerState::kSwitchOnDisabled);
    EXPECT_NEAR(drives.drive(i).velocity_rad_s(), 0.0, 0.05);
  }
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kNone);
  EXPECT_EQ(sentence(operation.master().shut_down()), "");
  EXPECT_TRUE(drives.all_in(AlState::kInit));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_FALSE(drives.drive(i).fault()) << "an orderly end is no fault";
}

TEST(ShutDown, AStartInTheSameCycleDoesNotUndoTheStop) {
  DriveLine drives(1);
  FollowingOperation operation(drives);
  operation.run(milliseconds{100});
  operation.motion().request_stop();
  operation.motion().request_start();
  operation.cycle();
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kStopping);
  ASSERT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
  operation.motion().request_start();
  operation.motion().request_stop();
  operation.cycle();
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kIdle) << "the stop came later";
  operation.motion().request_stop();
  operation.motion().request_start();
  operation.cycle();
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kEnabling) << "there was nothing to stop";
}

TEST(ShutDown, BrakesOnARampInsteadOfStoppingDead) {
  DriveLine drives(1);
  FollowingOperation operation(drives);
  operation.run(milliseconds{100});
  const double speed = std::abs(operation.motion().setpoints()[0].velocity);
  ASSERT_GT(speed, 1.0);
  operation.motion().request_stop();
  operation.cycle();
  double last = operation.motion().setpoints()[0].velocity;
  while (operation.motion().phase() == MotionPhase::kStopping) {
    operation.cycle();
    const double now = operation.motion().setpoints()[0].velocity;
    EXPECT_LE(std::abs(now - last), 1000.0 * 125e-6 * 1.001) << "limit of the axis: 1000 rad/s^2";
    last = now;
  }
  EXPECT_EQ(last, 0.0);
}

TEST(ShutDown, TheFirstSetpointOfTheStopIsAPeriodAheadOfTheLastOneOfThePath) {
  DriveLine drives(1);
  FollowingOperation operation(drives);
  operation.run(milliseconds{100});
  operation.motion().request_stop();
  auto last = operation.motion().setpoints()[0];
  ASSERT_GT(std::abs(last.velocity), 1.0);
  do {
    operation.cycle();
    const auto now = operation.motion().setpoints()[0];
    // The position advances by the mean of the two velocities; an end in the middle of a period leaves a remainder.
    EXPECT_NEAR(now.position - last.position, (now.velocity + last.velocity) / 2.0 * 125e-6, 1000.0 * 125e-6 * 125e-6)
        << "at " << last.velocity << " rad/s";
    last = now;
  } while (operation.motion().phase() == MotionPhase::kStopping);
}

TEST(ShutDown, WorksFromEveryStepOfTheWayUp) {
  for (int step = 0; step < 5; ++step) {
    DriveLine drives(2);
    LineOperation operation(drives);
    auto& master = operation.master();
    if (step >= 1) {
      ASSERT_EQ(sentence(master.scan()), "");
    }
    if (step == 2) {
      ASSERT_EQ(sentence(master.enter_pre_op()), "");
    }
    if (step >= 3) {
      ASSERT_EQ(sentence(master.configure(operation.plans())), "");
    }
    if (step >= 4) operation.start_cycle();
    EXPECT_EQ(sentence(master.shut_down()), "") << "step " << step;
    EXPECT_TRUE(drives.all_in(AlState::kInit)) << "step " << step;
    EXPECT_EQ(sentence(master.shut_down()), "") << "once more, step " << step;
  }
}

TEST(ShutDown, TakesOneStateAfterTheOther) {
  DriveLine drives(1);
  std::vector<unsigned> asked;
  ChangingPort port(drives.line(),
                    [&](std::span<std::byte> frame) {
                      const auto datagram = first_datagram(frame);
                      if (datagram.command == wire::Command::kFpwr && datagram.ado == 0x0120) {
                        asked.push_back(std::to_integer<unsigned>(datagram.data[0]));
                      }
                    },
                    {});
  IdleOperation operation(drives, port);
  EXPECT_EQ(asked, (std::vector<unsigned>{1, 2, 4, 8}));
  asked.clear();
  ASSERT_EQ(sentence(operation.master().shut_down()), "");
  EXPECT_EQ(asked, (std::vector<unsigned>{4, 2, 1}));
}

TEST(ShutDown, MayBeFollowedByAnotherRun) {
  DriveLine drives(2);
  for (int run = 0; run < 3; ++run) {
    LineOperation operation(drives);
    ASSERT_EQ(sentence(operation.to_motion()), "") << run;
    ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2})) << run;
    operation.motion().request_stop();
    ASSERT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
    ASSERT_EQ(sentence(operation.master().shut_down()), "");
  }
}

TEST(SlowSlaves, AreWaitedForInEveryTransition) {
  slaves::SlaveOptions options;
  options.al.transition_delay = milliseconds{40};
  DriveLine drives(2, options);
  IdleOperation operation(drives);
  EXPECT_TRUE(drives.all_in(AlState::kOp));
  EXPECT_EQ(sentence(operation.master().shut_down()), "");
  EXPECT_TRUE(drives.all_in(AlState::kInit));
}

TEST(SlowSlaves, AreNamedWhenTheyAreTooSlow) {
  DriveLine drives(2);
  ConfiguredOperation operation(drives, RunOptions{.state_timeout = milliseconds{500}});
  drives.slave(1).al().set_transition_delay(std::chrono::seconds{1});
  operation.start_cycle();
  EXPECT_EQ(sentence(operation.master().go_operational()),
            "slave 1: requested OP, is in SAFEOP and did not change within 500 ms, AL status code 0x0000 (no error)");
}

/// The samples of a run, for a comparison of all bytes.
std::vector<snapshot::AxisSample> recorded_run() {
  DriveLine drives(3);
  FollowingOperation operation(drives);
  operation.run(milliseconds{200});
  drives.line().drop_frames(3);
  operation.run(milliseconds{50});
  operation.motion().request_stop();
  EXPECT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
  return operation.axis_samples;
}

TEST(Determinism, TheSameRunTwiceGivesTheSameSamplesBitByBit) {
  const auto first = recorded_run();
  const auto second = recorded_run();
  ASSERT_GT(first.size(), 3U * 2000);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    const auto& a = first[i];
    const auto& b = second[i];
    ASSERT_EQ(std::tie(a.cycle, a.time_ns, a.axis, a.control_word, a.status_word, a.mode, a.state),
              std::tie(b.cycle, b.time_ns, b.axis, b.control_word, b.status_word, b.mode, b.state));
    for (const auto member : {&snapshot::AxisSample::target_position, &snapshot::AxisSample::actual_position,
                              &snapshot::AxisSample::target_velocity, &snapshot::AxisSample::actual_velocity,
                              &snapshot::AxisSample::target_torque, &snapshot::AxisSample::actual_torque,
                              &snapshot::AxisSample::following_error}) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(a.*member), std::bit_cast<std::uint64_t>(b.*member)) << "sample " << i;
    }
  }
}

}  // namespace
}  // namespace driveline::bus_test
