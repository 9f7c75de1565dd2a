#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/sdo_request.hpp"
#include "driveline/ecat_master/group/axis_groups.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/port/redundant_port.hpp"
#include "driveline/rt_guard/rt_guard.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::CycleRunner;
using ecat_master::CyclicCore;
using ecat_master::MotionFailure;
using ecat_master::MotionPhase;
using ecat_master::ReceiveStrategy;
using rt::RtGuard;

/// Counters of the guarded code so far.
struct Ledger {
  RtGuard::Counts counts;
  std::uint64_t cycles = 0;

  void close() {
    const auto more = RtGuard::leave();
    counts.allocations += more.allocations;
    counts.frees += more.frees;
    counts.locks += more.locks;
  }
};

/// Runs every cycle under guard.
class GuardedRunner final : public CycleRunner {
 public:
  GuardedRunner(CyclicCore& core, rt::Clock& clock, Ledger& ledger)
      : core_(core), clock_(clock), timer_(clock, core.settings().period), ledger_(ledger) {}

  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override {
    timer_.start(core_.first_grid(clock_.now() + 4 * timer_.period()));
    return {};
  }
  void pass(nanoseconds duration) override {
    const auto end = clock_.now() + duration;
    do {
      RtGuard::enter();
      core_.cycle(timer_.wait_next());
      timer_.shift_phase(core_.grid_shift());
      ledger_.close();
      ++ledger_.cycles;
    } while (clock_.now() < end);
  }
  void stop() override {}

 private:
  CyclicCore& core_;
  rt::Clock& clock_;
  rt::CycleTimer timer_;
  Ledger& ledger_;
};

/// Suspends the guard while the simulated line works: its drives may allocate for mailboxes, the master may not.
class UnguardedLine final : public PassingPort {
 public:
  UnguardedLine(port::Port& inner, Ledger& ledger) : PassingPort(inner), ledger_(ledger) {}

  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    ledger_.close();
    const auto status = inner_.send(frame);
    RtGuard::enter();
    return status;
  }
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override {
    ledger_.close();
    const auto frame = inner_.receive();
    RtGuard::enter();
    return frame;
  }

 private:
  Ledger& ledger_;
};

class CyclePurity : public testing::Test {
 protected:
  void SetUp() override {
    if (!RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc and the locks in this build";
  }
  void TearDown() override { RtGuard::leave(); }

  ecat_master::Master::MakeRunner guarded() {
    return [this](CyclicCore& core) { return std::make_unique<GuardedRunner>(core, drives.clock, ledger); };
  }

  DriveLine drives{3};
  Ledger ledger;
};

TEST_F(CyclePurity, TheMasterNeitherAllocatesNorLocksWhateverHappens) {
  UnguardedLine line(drives.line(), ledger);
  LineOperation operation(drives, line, RunOptions{.repeat = true});
  ASSERT_EQ(sentence(operation.to_safe_op()), "");
  operation.start_cycle(guarded());
  ledger = {};
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));

  // Mailbox traffic during the motion.
  for (std::size_t i = 0; i < 300; ++i) {
    CoeClient coe(*operation.master().mailbox(i % 3));
    ASSERT_EQ(sentence(coe.upload(0x1008, 0)), "");
    ASSERT_EQ(sentence(coe.download_as<std::uint32_t>(0x6065, 0, 1'000'000)), "");
  }
  // Single lost frames, then enough of them for a loss of communication, and recovery.
  for (int i = 0; i < 20; ++i) {
    drives.line().drop_frames(1);
    operation.run(milliseconds{1});
  }
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kNone);
  drives.line().drop_frames(40);
  operation.run(milliseconds{400});
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kCommunication);
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  // A drive fault, and recovery.
  drives.drive(1).set_dc_link(false);
  operation.run(milliseconds{400});
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kAxisFault);
  drives.drive(1).set_dc_link(true);
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  // A stop on request, and a restart.
  operation.motion().request_stop();
  ASSERT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  // Missed periods.
  drives.clock.advance(milliseconds{3});
  operation.run(milliseconds{10});
  // A drive without power, a stopped motion, failing acyclic transfers.
  drives.line().set_power(2, false);
  operation.run(milliseconds{100});
  EXPECT_FALSE(operation.master().al_status().has_value());
  operation.run(milliseconds{2200});
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kIdle);
  drives.line().set_power(2, true);
  operation.run(milliseconds{100});

  EXPECT_GE(ledger.cycles, 10'000U);
  EXPECT_EQ(ledger.counts.allocations, 0U);
  EXPECT_EQ(ledger.counts.frees, 0U);
  EXPECT_EQ(ledger.counts.locks, 0U);
}

TEST_F(CyclePurity, SingleAxesPlanTheirMotionsWithoutEither) {
  using ecat_master::AxisCommand;
  UnguardedLine line(drives.line(), ledger);
  RunOptions options;
  options.single_axes = true;
  LineOperation operation(drives, line, options);
  ASSERT_EQ(sentence(operation.to_safe_op()), "");
  operation.start_cycle(guarded());
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  ledger = {};
  auto& axes = operation.single_axes();
  const auto ask = [&](AxisCommand command, double target, ecat_master::BufferMode buffer) {
    ecat_master::AxisRequest request;
    request.command = command;
    request.target = target;
    request.buffer = buffer;
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NE(axes.submit(axis, request), 0U);
    operation.run(milliseconds{20});
  };
  ask(AxisCommand::kPower, 0.0, {});
  operation.run(milliseconds{100});
  for (int round = 0; round < 20; ++round) {
    ask(AxisCommand::kMoveAbsolute, round % 2 == 0 ? 3.0 : -3.0, {});
    ask(AxisCommand::kMoveRelative, round % 3 == 0 ? 2.0 : -2.0, ecat_master::BufferMode::kBlendingLow);
    ask(AxisCommand::kSetOverride, 0.1 * round, {});
    ask(AxisCommand::kMoveVelocity, round, {});
    drives.line().drop_frames(3);
    drives.clock.advance(microseconds{500});
    ask(AxisCommand::kHalt, 0.0, {});
  }
  operation.run(milliseconds{200});
  EXPECT_EQ(axes.axis_report(0).state, ecat_master::PlcopenState::kStandstill);
  drives.drive(1).set_dc_link(false);
  operation.run(milliseconds{100});
  EXPECT_EQ(axes.axis_report(1).state, ecat_master::PlcopenState::kErrorStop);
  EXPECT_GE(ledger.cycles, 10'000U);
  EXPECT_EQ(ledger.counts.total(), 0U);
}

// Planning outside the cycle may allocate.
TEST_F(CyclePurity, GroupsFollowTheirPathsWithoutEither) {
  using ecat_master::AxisGroups;
  using ecat_master::GroupCommand;
  using ecat_master::GroupMove;
  using ecat_master::GroupState;
  constexpr std::size_t kAxes = 12;
  DriveLine many(kAxes);
  UnguardedLine line(many.line(), ledger);
  RunOptions options;
  options.single_axes = true;
  options.samples = false;
  LineOperation operation(many, line, options);
  ASSERT_EQ(sentence(operation.to_safe_op()), "");
  operation.start_cycle([&](CyclicCore& core) { return std::make_unique<GuardedRunner>(core, many.clock, ledger); });
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  AxisGroups groups(operation.single_axes(), {{"contour", {0, 1, 2}, 256}, {"lines", {3, 4, 5, 6, 7, 8, 9, 10, 11}}},
                    options.period);
  ledger = {};
  const auto run = [&](int planned_milliseconds) {
    for (int i = 0; i < planned_milliseconds; ++i) {
      groups.plan();
      operation.run(milliseconds{1});
    }
  };
  const auto ask = [&](GroupCommand command, double value = 0.0) {
    for (std::size_t group = 0; group < 2; ++group) EXPECT_NE(groups.submit(group, {command, value}), 0U);
    run(20);
  };
  const auto move = [&](double shift) {
    GroupMove there;
    there.path.target = {2.0 + shift, 1.0, -1.0};
    there.path.feed = 30.0;
    there.path.tolerance = 0.1;
    auto around = there;
    around.path.kind = trajectory::PathMove::Kind::kArcVia;
    around.path.via = {0.0, 2.0, 0.5};
    around.path.target = {-1.0, 0.0, shift};
    ASSERT_NE(groups.move_path(0, std::vector{there, around}), 0U);
    GroupMove line_of_all;
    line_of_all.target.assign(kAxes - 3, 1.0 + shift);
    line_of_all.path.feed = 40.0;
    ASSERT_NE(groups.move(1, line_of_all), 0U);
    run(60);
  };
  for (std::size_t axis = 0; axis < kAxes; ++axis)
    EXPECT_NE(operation.single_axes().submit(axis, {.command = ecat_master::AxisCommand::kPower}), 0U);
  run(100);
  ask(GroupCommand::kEnable);
  for (int round = 0; round < 8; ++round) {
    move(0.5 * round);
    ask(GroupCommand::kSetOverride, 0.2 * round);
    ask(GroupCommand::kReverse);
    many.line().drop_frames(3);
    ask(GroupCommand::kInterrupt);
    many.clock.advance(microseconds{500});
    ask(GroupCommand::kForward);
    move(-0.5 * round);
    ask(GroupCommand::kHalt);
    ask(GroupCommand::kStop);
    ask(GroupCommand::kReleaseStop);
  }
  ask(GroupCommand::kSetOverride, 1.0);
  move(1.0);
  EXPECT_EQ(groups.group_report(0).state, GroupState::kMoving);
  EXPECT_EQ(groups.group_report(1).state, GroupState::kMoving);
  many.drive(1).set_dc_link(false);
  many.drive(7).set_dc_link(false);
  run(300);
  EXPECT_EQ(groups.group_report(0).state, GroupState::kErrorStop);
  EXPECT_EQ(groups.group_report(1).state, GroupState::kErrorStop);
  EXPECT_GE(ledger.cycles, 10'000U);
  EXPECT_EQ(ledger.counts.total(), 0U);
}

TEST_F(CyclePurity, TheSimulatedLineIsAsPureWithoutMailboxTraffic) {
  LineOperation operation(drives, RunOptions{.repeat = true});
  ASSERT_EQ(sentence(operation.to_safe_op()), "");
  operation.start_cycle(guarded());
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  ledger = {};
  operation.run(milliseconds{1500});
  EXPECT_GE(ledger.cycles, 12'000U);
  EXPECT_EQ(ledger.counts.total(), 0U);
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kNone);
}

TEST_F(CyclePurity, GroupsRecoveryRecordingAndTracingDoNotChangeThat) {
  UnguardedLine line(drives.line(), ledger);
  ecat_master::FlightRecorder recorder(3);
  RunOptions options{.repeat = true};
  options.layout = {ecat_master::ImageLayout::kSeparate, {{1, 0, 50}, {2, 0, 50}, {1, 0, 50}}};
  options.groups = 3;
  options.recorder = &recorder;
  ecat_master::CycleTrace trace;
  options.trace = &trace;
  options.amplitude_rad = 0.1;
  LineOperation operation(drives, line, options);
  ASSERT_EQ(sentence(operation.to_safe_op()), "");
  operation.start_cycle(guarded());
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  ledger = {};
  operation.run(milliseconds{10});
  ecat_master::LineSupervisor supervisor(operation.master());
  for (int round = 0; round < 6; ++round) {
    operation.motion().request_start();
    ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2})) << round;
    // The middle drive disconnects the last one, too; both return while the first keeps cycling.
    drives.line().set_power(1, false);
    operation.run(milliseconds{100});
    supervisor.poll();
    drives.line().set_power(1, true);
    for (int i = 0; i < 400 && !supervisor.all_operational(); ++i) {
      operation.run(milliseconds{5});
      supervisor.poll();
    }
    ASSERT_TRUE(supervisor.all_operational()) << round;
    operation.run(milliseconds{2200});
    ASSERT_EQ(operation.motion().phase(), MotionPhase::kIdle);
    EXPECT_TRUE(recorder.frozen());
    recorder.rearm();
    for (std::size_t group = 0; group < 3; ++group) operation.master().core()->release_outputs(group);
  }
  EXPECT_EQ(supervisor.recoveries(), 12U);
  EXPECT_GE(trace.cycles().size(), ecat_master::CycleTrace::kCycles);
  EXPECT_GE(ledger.cycles, 100'000U);
  EXPECT_EQ(ledger.counts.total(), 0U);
}

TEST_F(CyclePurity, ARedundantPortIsPureWholeAndBroken) {
  DriveLine ring(4, {}, {}, slaves::Wiring::ring(4, nanoseconds{5}));
  UnguardedLine primary(ring.line(), ledger);
  UnguardedLine secondary(ring.line().secondary(), ledger);
  port::RedundantPort port(primary, secondary, ring.clock);
  LineOperation operation(ring, port, RunOptions{.repeat = true});
  ASSERT_EQ(sentence(operation.to_safe_op()), "");
  operation.start_cycle([&](CyclicCore& core) { return std::make_unique<GuardedRunner>(core, ring.clock, ledger); });
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  ledger = {};
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  for (int round = 0; round < 50; ++round) {
    ring.line().break_cable({static_cast<std::size_t>(round % 4), 1}, true);
    operation.run(milliseconds{15});
    ring.line().break_cable({static_cast<std::size_t>(round % 4), 1}, false);
    operation.run(milliseconds{15});
  }
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kNone);
  EXPECT_GT(port.merged(), 1000U);
  EXPECT_GE(ledger.cycles, 10'000U);
  EXPECT_EQ(ledger.counts.total(), 0U);
}

TEST_F(CyclePurity, NoWayOfWaitingForTheAnswersChangesThat) {
  for (const auto receive : {ReceiveStrategy::kSpin, ReceiveStrategy::kSleep, ReceiveStrategy::kBlock}) {
    SCOPED_TRACE(static_cast<int>(receive));
    DriveLine far(4, {}, {}, slaves::Wiring::line(4, microseconds{25}));  // answers take 200 us
    UnguardedLine line(far.line(), ledger);
    LineOperation operation(far, line, RunOptions{.period = milliseconds{1}, .receive = receive, .repeat = true});
    ASSERT_EQ(sentence(operation.to_safe_op()), "");
    operation.start_cycle([&](CyclicCore& core) { return std::make_unique<GuardedRunner>(core, far.clock, ledger); });
    ASSERT_EQ(sentence(operation.master().go_operational()), "");
    operation.motion().request_start();
    ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
    ledger = {};
    operation.run(milliseconds{1000});
    far.line().drop_frames(1);
    operation.run(milliseconds{100});
    EXPECT_GE(ledger.cycles, 1000U);
    EXPECT_EQ(ledger.counts.total(), 0U);
    EXPECT_EQ(operation.master().core()->statistics().lost_frames, 1U);
    EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kNone);
  }
}

TEST_F(CyclePurity, ClocksThatAreFollowedLostAndFoundDoNotChangeThat) {
  UnguardedLine line(drives.line(), ledger);
  LineOperation operation(drives, line, RunOptions{.repeat = true});
  ecat_master::dc::ClockPlan plan;
  plan.slaves.resize(3, {{ecat_master::dc::kActivateSync0, plan.period, {}, {}, {}}, {}});
  operation.master().use_clocks(plan);
  ASSERT_EQ(sentence(operation.to_safe_op()), "");
  operation.start_cycle(guarded());
  ledger = {};
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  auto& watch = *operation.master().clock_watch();
  for (int round = 0; round < 60; ++round) {
    operation.run(milliseconds{20});
    ASSERT_EQ(sentence(watch.poll()), "");
    drives.line().drop_frames(1);
  }
  ASSERT_EQ(sentence(watch.remeasure_delays(operation.master().topology())), "");
  // No frames until the lock is lost, then recovery.
  drives.line().drop_frames(500);
  operation.run(milliseconds{80});
  EXPECT_FALSE(operation.master().clock_follower()->status().locked);
  operation.run(milliseconds{300});
  EXPECT_TRUE(operation.master().clock_follower()->status().locked);
  EXPECT_GE(ledger.cycles, 10'000U);
  EXPECT_EQ(ledger.counts.total(), 0U);
}

/// Requests SDOs from within the cycle, one after the other, and checks whether they have ended.
class AskingTask final : public ecat_master::CycleTask {
 public:
  using State = ecat_master::SdoRequest::State;
  void update(const ecat_master::TaskCycle&) noexcept override {
    if (!read || !written || !refused) return;
    if (look(*read, reads)) static_cast<void>(read->start_upload());
    if (look(*written, writes)) static_cast<void>(written->start_download(wire::to_le_bytes(++value_)));
    if (look(*refused, refusals)) static_cast<void>(refused->start_upload());
  }
  std::shared_ptr<ecat_master::SdoRequest> read;
  std::shared_ptr<ecat_master::SdoRequest> written;
  std::shared_ptr<ecat_master::SdoRequest> refused;  ///< an object that does not exist
  std::uint64_t reads = 0;
  std::uint64_t writes = 0;
  std::uint64_t refusals = 0;

 private:
  /// True: the next request may be started.
  static bool look(const ecat_master::SdoRequest& request, std::uint64_t& ended) noexcept {
    const auto state = request.state();
    if (state == State::kPending || state == State::kBusy) return false;
    if (state == State::kDone || (state == State::kFailed && request.error().is<ecat_master::facts::SdoAbort>()))
      ++ended;
    return true;
  }
  std::uint32_t value_ = 1'000'000;  ///< value of the following error window
};

TEST_F(CyclePurity, RequestsOfTheCycleAndCopiedProcessDataDoNotChangeThat) {
  UnguardedLine line(drives.line(), ledger);
  AskingTask task;
  RunOptions options{.repeat = true};
  options.task = &task;
  options.amplitude_rad = 0.1;
  // Copies target velocity (60FFh) and, at an odd bit, target torque (6071h) of drive 2, which CSP ignores.
  options.copies = [](const ecat_master::Master& master) {
    const auto places = master.image().places();
    return std::vector<ecat_master::ProcessDataCopy>{
        {0, 8 * places[0].input_offset + 56, 8 * places[2].output_offset + 56, 32},
        {1, 8 * places[1].input_offset + 61, 8 * places[2].output_offset + 121, 7}};
  };
  LineOperation operation(drives, line, options);
  ASSERT_EQ(sentence(operation.to_safe_op()), "");
  operation.start_cycle(guarded());
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  auto& mailboxes = operation.master().mailboxes();
  task.read = make_request(mailboxes, 0, 0x6065, 0, 4);
  task.written = make_request(mailboxes, 1, 0x6065, 0, 4);
  task.refused = make_request(mailboxes, 2, 0x5FFF, 0, 4);
  ledger = {};
  operation.motion().request_start();
  const auto end = drives.clock.now() + std::chrono::seconds{2};
  while (drives.clock.now() < end) {
    if (!mailboxes.step()) operation.run(milliseconds{1});
  }
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kNone);
  EXPECT_GT(task.reads, 50U);
  EXPECT_GT(task.writes, 50U);
  EXPECT_GT(task.refusals, 50U);
  const auto places = operation.master().image().places();
  const auto& image = operation.master().core()->image();
  const auto from = image.inputs().subspan(places[0].input_offset + 7, 4);
  const auto to = image.outputs().subspan(places[2].output_offset + 7, 4);
  EXPECT_TRUE(std::equal(from.begin(), from.end(), to.begin())) << "the copy is made";
  EXPECT_GE(ledger.cycles, 10'000U);
  EXPECT_EQ(ledger.counts.total(), 0U);
}

/// A port that allocates.
class WastefulPort final : public PassingPort {
 public:
  using PassingPort::PassingPort;
  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    copy_ = std::vector<std::byte>(frame.begin(), frame.end());
    return inner_.send(copy_);
  }

 private:
  std::vector<std::byte> copy_;
};

TEST_F(CyclePurity, AnAllocationInsideTheCycleWouldBeSeen) {
  WastefulPort port(drives.line());
  LineOperation operation(drives, port);
  ASSERT_EQ(sentence(operation.to_safe_op()), "");
  operation.start_cycle(guarded());
  ledger = {};
  operation.run(milliseconds{10});
  EXPECT_GE(ledger.counts.allocations, ledger.cycles);
}

}  // namespace
}  // namespace driveline::bus_test
