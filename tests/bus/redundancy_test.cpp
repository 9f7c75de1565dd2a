// A ring over two interfaces: a break anywhere costs at most the frames in flight.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "drive_line.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/port/redundant_port.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::ImageLayout;
using motion::MotionFailure;
using motion::MotionPhase;
using port::RedundantPort;
using State = port::RingStatus::State;

constexpr std::size_t kDrives = 5;

/// Five drives in a ring, moving along their path.
class Ring : public testing::Test {
 protected:
  void start(const RunOptions& options = {}) {
    operation = std::make_unique<LineOperation>(drives, port, options);
    ASSERT_EQ(sentence(operation->to_motion()), "");
    ASSERT_TRUE(operation->run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
    operation->run(milliseconds{30});
  }
  /// Cable n precedes slave n; cable kDrives leads back to the master.
  void cut(std::size_t cable, bool broken = true) {
    const slaves::PortId end = cable == 0 ? slaves::PortId{0, 0} : slaves::PortId{cable - 1, 1};
    ASSERT_TRUE(drives.line().break_cable(end, broken));
  }
  void expect_undisturbed(const std::string& when) {
    EXPECT_EQ(operation->statistics().lost_frames, 0U) << when;
    EXPECT_EQ(operation->statistics().wkc_errors, 0U) << when;
    EXPECT_EQ(operation->statistics().stale_frames, 0U) << when;
    EXPECT_EQ(operation->motion().failure().cause, MotionFailure::Cause::kNone) << when;
    for (std::size_t i = 0; i < kDrives; ++i) {
      EXPECT_TRUE(operation->master().core()->slave_report(i).operational) << when << ", slave " << i;
      EXPECT_NEAR(operation->motion().setpoints()[i].position, drives.drive(i).position_rad(), 0.1) << when;
    }
  }

  DriveLine drives{kDrives, {}, {}, slaves::Wiring::ring(kDrives, nanoseconds{5})};
  RedundantPort port{drives.line(), drives.line().secondary(), drives.clock};
  std::unique_ptr<LineOperation> operation;
};

TEST_F(Ring, RunsLikeALineWhileItIsWhole) {
  start();
  operation->run(milliseconds{100});
  expect_undisturbed("whole");
  EXPECT_EQ(port.status().state, State::kClosed);
  EXPECT_EQ(port.merged(), 0U);
  EXPECT_EQ(port.halves(), 0U);
}

TEST_F(Ring, ABreakAnywhereCostsNotOneCycleAndIsLocated) {
  start(RunOptions{.repeat = true});
  for (std::size_t cable = 0; cable <= kDrives; ++cable) {
    const auto where = "cable " + std::to_string(cable);
    cut(cable);
    for (int cycle = 0; cycle < 200; ++cycle) {
      operation->cycle();
      ASSERT_EQ(operation->master().core()->bad_cycles(), 0U) << where << ", cycle " << cycle;
    }
    expect_undisturbed(where);
    EXPECT_EQ(port.status().state, State::kOpen) << where;
    EXPECT_EQ(port.status().primary_slaves, cable) << where;
    EXPECT_EQ(port.status().secondary_slaves, kDrives - cable) << where;
    cut(cable, false);
    for (int cycle = 0; cycle < 200; ++cycle) {
      operation->cycle();
      ASSERT_EQ(operation->master().core()->bad_cycles(), 0U) << where << " healed, cycle " << cycle;
    }
    expect_undisturbed(where + " healed");
    EXPECT_EQ(port.status().state, State::kClosed) << where;
  }
}

TEST_F(Ring, EveryLayoutSurvivesABreak) {
  for (const auto layout : {ImageLayout::kOverlapped, ImageLayout::kSequential, ImageLayout::kSeparate}) {
    RunOptions options{.repeat = true};
    options.layout.layout = layout;
    options.groups = 2;
    start(options);
    cut(2);
    operation->run(milliseconds{50});
    expect_undisturbed("layout " + std::to_string(static_cast<int>(layout)));
    EXPECT_GT(port.merged(), 0U);
    cut(2, false);
    operation->run(milliseconds{5});
    operation->motion().request_stop();
    ASSERT_TRUE(operation->run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
    ASSERT_EQ(sentence(operation->master().shut_down()), "");
  }
}

TEST_F(Ring, MailboxesOfBothSidesAnswerWhileItIsBroken) {
  start(RunOptions{.repeat = true});
  cut(2);
  for (std::size_t i = 0; i < kDrives; ++i) {
    ecat_master::CoeClient coe(*operation->master().mailbox(i));
    EXPECT_EQ(sentence(coe.upload(0x1008, 0)), "") << i;
    EXPECT_EQ(sentence(coe.download_as<std::uint32_t>(0x6065, 0, 1'000'000)), "") << i;
  }
  expect_undisturbed("with mailbox traffic");
}

TEST_F(Ring, StatesOfAllSlavesAreReadWhileItIsBroken) {
  start();
  cut(3);
  operation->run(milliseconds{1});
  const auto states = operation->master().al_status();
  ASSERT_EQ(sentence(states), "");
  for (const auto& report : *states) EXPECT_EQ(report.status.state, wire::AlState::kOp);
  EXPECT_TRUE(operation->master().core()->al_status().all_op(kDrives)) << "the broadcast counts both sides";
}

TEST_F(Ring, TwoBreaksLoseWhatLiesBetween) {
  start();
  cut(1);
  operation->run(milliseconds{5});
  expect_undisturbed("first break");
  cut(3);
  operation->run(milliseconds{20});
  for (const std::size_t reached : {0U, 3U, 4U}) {
    EXPECT_TRUE(operation->master().core()->slave_report(reached).valid) << reached;
  }
  for (const std::size_t cut_off : {1U, 2U}) {
    EXPECT_FALSE(operation->master().core()->slave_report(cut_off).valid) << cut_off;
  }
  EXPECT_EQ(operation->motion().failure().cause, MotionFailure::Cause::kAxisLost);
  EXPECT_EQ(operation->motion().failure().axis, 1);
}

TEST_F(Ring, HalfAnAnswerIsHandedOverInTimeWhenTheOtherHalfIsLost) {
  start();
  cut(3);
  operation->run(milliseconds{5});
  // Frames that return to the secondary end are lost from now on, which must not affect slaves 0 to 2.
  EXPECT_EQ(port.halves(), 0U);
  drives.line().drop_frames(1);
  operation->cycle();
  EXPECT_EQ(port.halves(), 1U);
  EXPECT_EQ(port.late_halves(), 1U) << "it was waited for";
  operation->run(milliseconds{5});
  EXPECT_EQ(operation->motion().failure().cause, MotionFailure::Cause::kNone);
}

/// A late half does not tell where the ring is broken; a missing half does.
TEST_F(Ring, LateHalvesCutNobodyOffUntilThereAreSeveralInARow) {
  start();
  cut(3);
  operation->run(milliseconds{5});
  const auto reached = [this] {
    const auto status = port.status();
    return std::pair{status.primary_slaves, status.secondary_slaves};
  };
  const auto both = reached();
  EXPECT_EQ(both, (std::pair<std::uint16_t, std::uint16_t>{3, 2}));
  for (unsigned time = 0; time < 3 * RedundantPort::kLoneHalves; ++time) {
    drives.line().drop_frames(1);
    operation->cycle();
    EXPECT_EQ(reached(), both) << time;
    operation->cycle();
  }
  EXPECT_EQ(port.late_halves(), 3 * RedundantPort::kLoneHalves);
  for (unsigned time = 0; time < RedundantPort::kLoneHalves; ++time) {
    EXPECT_EQ(reached(), both) << time;
    drives.line().drop_frames(1);
    operation->cycle();
  }
  EXPECT_NE(reached(), both);
  EXPECT_EQ(port.status().state, State::kOpen);
  operation->cycle();
  EXPECT_EQ(reached(), both) << "both halves again";
}

/// The two ends of a ring, with an action between the two copies of a frame: one copy has passed the line, the other
/// has not.
class MomentBetween {
 public:
  MomentBetween(slaves::SimulatedLine& line, rt::Clock& clock) : clock_(clock), line_(line) {}

  [[nodiscard]] port::Port& primary() noexcept { return primary_; }
  [[nodiscard]] port::Port& secondary() noexcept { return secondary_; }
  /// Applies to the next frame; afterwards the primary copy is the first again.
  void arrange(bool secondary_first, std::function<void()> moment) {
    secondary_first_ = secondary_first;
    moment_ = std::move(moment);
  }

 private:
  struct Primary final : PassingPort {
    Primary(MomentBetween& both, port::Port& inner) : PassingPort(inner), both_(both) {}
    [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
      sent_ = both_.clock_.now();
      if (!both_.secondary_first_) return inner_.send(frame);
      both_.waiting_.assign(frame.begin(), frame.end());
      return port::SendStatus::kSent;
    }
    [[nodiscard]] nanoseconds last_send_time() const noexcept override { return sent_; }
    MomentBetween& both_;
    nanoseconds sent_{};
  };
  struct Secondary final : PassingPort {
    Secondary(MomentBetween& both, port::Port& inner) : PassingPort(inner), both_(both) {}
    [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
      if (!both_.secondary_first_) both_.take_moment();
      const auto status = inner_.send(frame);
      if (std::exchange(both_.secondary_first_, false)) {
        both_.take_moment();
        // If the break is on its own cable, the copy is lost.
        static_cast<void>(both_.line_.send(both_.waiting_));
      }
      return status;
    }
    MomentBetween& both_;
  };

  void take_moment() {
    if (const auto moment = std::exchange(moment_, nullptr)) moment();
  }

  rt::Clock& clock_;
  slaves::SimulatedLine& line_;
  bool secondary_first_ = false;
  std::function<void()> moment_;
  std::vector<std::byte> waiting_;
  Primary primary_{*this, line_};
  Secondary secondary_{*this, line_.secondary()};
};

TEST_F(Ring, WhatMeetsABreakWithOneCopyOnlyIsMissedByOneSideForOneCycle) {
  MomentBetween ends(drives.line(), drives.clock);
  RedundantPort split(ends.primary(), ends.secondary(), drives.clock);
  operation = std::make_unique<LineOperation>(drives, split, RunOptions{.repeat = true});
  ASSERT_EQ(sentence(operation->to_motion()), "");
  ASSERT_TRUE(operation->run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  for (std::size_t cable = 0; cable <= kDrives; ++cable) {
    for (const bool secondary_first : {false, true}) {
      for (const bool breaks : {true, false}) {
        const auto what = (breaks ? "break of cable " : "mending of cable ") + std::to_string(cable) +
                          (secondary_first ? ", secondary copy first" : ", primary copy first");
        ends.arrange(secondary_first, [&] { cut(cable, breaks); });
        operation->cycle();
        // The primary copy is processed as long as it has a path, so it must not meet the open ring alone. There is no
        // slave behind the last cable.
        const unsigned cost = breaks == secondary_first && cable < kDrives ? 1 : 0;
        EXPECT_EQ(operation->master().core()->bad_cycles(), cost) << what;
        for (int cycle = 0; cycle < 20; ++cycle) {
          operation->cycle();
          ASSERT_EQ(operation->master().core()->bad_cycles(), 0U) << what << ", cycle " << cycle << " after it";
        }
        EXPECT_EQ(split.status().state, breaks ? State::kOpen : State::kClosed) << what;
      }
    }
  }
  EXPECT_EQ(operation->statistics().lost_frames + operation->statistics().wkc_errors, 2 * kDrives);
  EXPECT_EQ(split.late_halves(), 0U) << "nobody waited for what cannot come";
  EXPECT_EQ(operation->motion().failure().cause, MotionFailure::Cause::kNone);
  for (std::size_t i = 0; i < kDrives; ++i) {
    EXPECT_TRUE(operation->master().core()->slave_report(i).operational) << i;
    EXPECT_NEAR(operation->motion().setpoints()[i].position, drives.drive(i).position_rad(), 0.1) << i;
  }
  operation.reset();  // before its port
}

TEST_F(Ring, TheSupervisorTellsWhereItBroke) {
  start(RunOptions{.repeat = true});
  ecat_master::LineSupervisor supervisor(operation->master(), &port);
  std::vector<std::string> told;
  for (const std::size_t cable : {0U, 4U, 5U}) {
    for (const bool broken : {true, false}) {
      cut(cable, broken);
      operation->run(milliseconds{1});
      supervisor.poll();
    }
  }
  for (const auto& event : supervisor.history()) {
    const auto text = describe(event);
    told.push_back(text.substr(text.find(" s ") + 3));
  }
  const std::string closed = "the ring is closed again";
  const std::string on = "; process data continue over both interfaces";
  EXPECT_THAT(told,
              testing::ElementsAre("the ring is broken between the primary interface and slave 0" + on, closed,
                                   "the ring is broken between slave 3 and slave 4" + on, closed,
                                   "the ring is broken between slave 4 and the secondary interface" + on, closed));
  expect_undisturbed("all the time");
}

TEST_F(Ring, TheSupervisorTellsWhoIsCutOff) {
  start(RunOptions{.repeat = true});
  ecat_master::LineSupervisor::Settings settings;
  settings.recover = false;
  ecat_master::LineSupervisor supervisor(operation->master(), &port, settings);
  const auto told_after = [&](std::initializer_list<std::pair<std::size_t, bool>> switched) {
    for (const auto& [slave, on] : switched) drives.line().set_power(slave, on);
    const auto before = supervisor.history().size();
    operation->run(milliseconds{2});
    supervisor.poll();
    std::string text;
    for (auto i = before; i < supervisor.history().size(); ++i) {
      const auto& event = supervisor.history()[i];
      if (event.kind != ecat_master::LineEvent::Kind::kGone) text += what_happened(event) + "\n";
    }
    return text;
  };
  const std::string on = "; process data continue over both interfaces\n";
  EXPECT_EQ(told_after({{1, false}, {2, false}}),
            "the ring is broken between slave 0 and slave 3, slaves 1 to 2 are cut off" + on);
  EXPECT_EQ(told_after({{2, true}}), "the ring is broken between slave 0 and slave 2, slave 1 is cut off" + on);
  EXPECT_EQ(told_after({{1, true}}), "the ring is closed again\n");
  EXPECT_EQ(told_after({{0, false}}),
            "the ring is broken between the primary interface and slave 1, slave 0 is cut off" + on);
  EXPECT_EQ(told_after({{0, true}, {3, false}, {4, false}}),
            "the ring is broken between slave 2 and the secondary interface, slaves 3 to 4 are cut off" + on);
}

TEST_F(Ring, TwoNeighboursThatWereSwitchedOffComeBackInEitherOrder) {
  for (const auto& [first, second] : {std::pair<std::size_t, std::size_t>{1, 2}, {2, 1}}) {
    start(RunOptions{.repeat = true, .on_loss = motion::LossPolicy::kContinue});
    ecat_master::LineSupervisor supervisor(operation->master(), &port);
    const auto live = [&](int rounds) {
      for (int i = 0; i < rounds; ++i) {
        operation->run(milliseconds{5});
        supervisor.poll();
      }
    };
    for (const auto slave : {first, second}) drives.line().set_power(slave, false);
    live(20);
    drives.line().set_power(first, true);
    live(100);
    EXPECT_FALSE(supervisor.operational(second));
    const auto station = drives.slave(first).esc().memory().get(wire::reg::kStationAddress);
    EXPECT_NE(station, operation->master().slaves()[second].info.ref.station);
    drives.line().set_power(second, true);
    live(200);
    EXPECT_TRUE(supervisor.all_operational());
    EXPECT_TRUE(drives.all_in(wire::AlState::kOp));
    EXPECT_EQ(port.status().state, State::kClosed);
    operation->motion().request_stop();
    ASSERT_TRUE(operation->run_until(MotionPhase::kIdle, std::chrono::seconds{3}));
    ASSERT_EQ(sentence(operation->master().shut_down()), "");
  }
}

TEST_F(Ring, ADriveThatWasSwitchedOffIsRecoveredInARingToo) {
  start(RunOptions{.repeat = true});
  ecat_master::LineSupervisor supervisor(operation->master(), &port);
  drives.line().set_power(2, false);
  operation->run(milliseconds{20});
  supervisor.poll();
  EXPECT_EQ(port.status().primary_slaves, 2);
  EXPECT_EQ(port.status().secondary_slaves, 2);
  for (const std::size_t left : {0U, 1U, 3U, 4U}) {
    EXPECT_TRUE(operation->master().core()->slave_report(left).operational) << left;
  }
  drives.line().set_power(2, true);
  for (int i = 0; i < 400 && !supervisor.all_operational(); ++i) {
    operation->run(milliseconds{5});
    supervisor.poll();
  }
  EXPECT_TRUE(supervisor.all_operational());
  EXPECT_EQ(supervisor.recoveries(), 1U) << "the others did not even notice";
  EXPECT_EQ(port.status().state, State::kClosed);
}

}  // namespace
}  // namespace driveline::bus_test
