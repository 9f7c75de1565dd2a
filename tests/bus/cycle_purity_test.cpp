#include <gmock/gmock.h>
#include <sys/mman.h>
#include <unistd.h>

#include <random>
#include <span>

#include "counted_cycle.hpp"
#include "drive_line.hpp"
#include "driveline/ecat_master/coe/sdo_request.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/motion/group/axis_groups.hpp"
#include "driveline/port/redundant_port.hpp"
#include "driveline/rt_guard/rt_guard.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::CyclicCore;
using ecat_master::ReceiveStrategy;
using motion::MotionFailure;
using motion::MotionPhase;
using rt::RtGuard;

/// Counters of the guarded code so far: page faults, and what RtGuard counts.
struct Ledger : PageFaultLedger {
  RtGuard::Counts counts;

  void open() noexcept {
    PageFaultLedger::open();
    RtGuard::enter();
  }
  void close() noexcept {
    const auto more = RtGuard::leave();
    PageFaultLedger::close();
    counts.allocations += more.allocations;
    counts.frees += more.frees;
    counts.locks += more.locks;
  }
};

using GuardedRunner = CountedRunner<Ledger>;
/// Its drives may allocate for mailboxes, the master may not.
using UnguardedLine = UncountedLine<Ledger>;

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
  ConfiguredOperation operation(drives, line, RunOptions{.repeat = true});
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
  using motion::AxisCommand;
  UnguardedLine line(drives.line(), ledger);
  RunOptions options;
  options.single_axes = true;
  ConfiguredOperation operation(drives, line, options);
  operation.start_cycle(guarded());
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  ledger = {};
  auto& axes = operation.single_axes();
  const auto ask = [&](AxisCommand command, double target, motion::BufferMode buffer) {
    motion::AxisRequest request;
    request.command = command;
    request.target_si = target;
    request.buffer = buffer;
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NE(axes.submit(axis, request), 0U);
    operation.run(milliseconds{20});
  };
  ask(AxisCommand::kPower, 0.0, {});
  operation.run(milliseconds{100});
  for (int round = 0; round < 20; ++round) {
    ask(AxisCommand::kMoveAbsolute, round % 2 == 0 ? 3.0 : -3.0, {});
    ask(AxisCommand::kMoveRelative, round % 3 == 0 ? 2.0 : -2.0, motion::BufferMode::kBlendingLow);
    ask(AxisCommand::kSetOverride, 0.1 * round, {});
    ask(AxisCommand::kMoveVelocity, round, {});
    drives.line().drop_frames(3);
    drives.clock.advance(microseconds{500});
    ask(AxisCommand::kHalt, 0.0, {});
  }
  operation.run(milliseconds{200});
  EXPECT_EQ(axes.axis_report(0).state, motion::PlcopenState::kStandstill);
  drives.drive(1).set_dc_link(false);
  operation.run(milliseconds{100});
  EXPECT_EQ(axes.axis_report(1).state, motion::PlcopenState::kErrorStop);
  EXPECT_GE(ledger.cycles, 10'000U);
  EXPECT_EQ(ledger.counts.total(), 0U);
}

// Planning outside the cycle may allocate.
TEST_F(CyclePurity, GroupsFollowTheirPathsWithoutEither) {
  using motion::AxisGroups;
  using motion::GroupCommand;
  using motion::GroupMove;
  using motion::GroupState;
  constexpr std::size_t kAxes = 12;
  DriveLine many(kAxes);
  UnguardedLine line(many.line(), ledger);
  RunOptions options;
  options.single_axes = true;
  options.samples = false;
  ConfiguredOperation operation(many, line, options);
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
    EXPECT_NE(operation.single_axes().submit(axis, {.command = motion::AxisCommand::kPower}), 0U);
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
  ConfiguredOperation operation(drives, RunOptions{.repeat = true});
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
  motion::FlightRecorder recorder(3);
  RunOptions options{.repeat = true};
  options.layout = {ecat_master::ImageLayout::kSeparate, {{1, 0, 50}, {2, 0, 50}, {1, 0, 50}}};
  options.groups = 3;
  options.recorder = &recorder;
  motion::CycleTrace trace;
  options.trace = &trace;
  options.amplitude_rad = 0.1;
  ConfiguredOperation operation(drives, line, options);
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
  EXPECT_GE(trace.cycles().size(), motion::CycleTrace::kCycles);
  EXPECT_GE(ledger.cycles, 100'000U);
  EXPECT_EQ(ledger.counts.total(), 0U);
}

TEST_F(CyclePurity, ARedundantPortIsPureWholeAndBroken) {
  DriveLine ring(4, {}, {}, slaves::Wiring::ring(4, nanoseconds{5}));
  UnguardedLine primary(ring.line(), ledger);
  UnguardedLine secondary(ring.line().secondary(), ledger);
  port::RedundantPort port(primary, secondary, ring.clock);
  ConfiguredOperation operation(ring, port, RunOptions{.repeat = true});
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
    ConfiguredOperation operation(far, line, RunOptions{.period = milliseconds{1}, .receive = receive, .repeat = true});
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
class AskingTask final : public motion::CycleTask {
 public:
  using State = ecat_master::SdoRequest::State;
  void update(const motion::TaskCycle&) noexcept override {
    if (!read || !written || !refused) return;
    if (look(*read, reads)) static_cast<void>(read->start_upload());
    if (look(*written, writes)) static_cast<void>(written->start_download(bytes::to_le_bytes(++value_)));
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
    return std::vector<motion::ProcessDataCopy>{
        {0, 8 * places[0].input_offset + 56, 8 * places[2].output_offset + 56, 32},
        {1, 8 * places[1].input_offset + 61, 8 * places[2].output_offset + 121, 7}};
  };
  ConfiguredOperation operation(drives, line, options);
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

/// More requests than the queue takes, of every kind, while axes move and frames are lost.
TEST_F(CyclePurity, TenThousandRequestsCauseNoPageFault) {
  using motion::AxisCommand;
  UnguardedLine line(drives.line(), ledger);
  RunOptions options;
  options.single_axes = true;
  ConfiguredOperation operation(drives, line, options);
  operation.start_cycle(guarded());
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  auto& axes = operation.single_axes();
  const auto ask = [&axes](std::size_t axis, AxisCommand command, double target, motion::BufferMode buffer = {}) {
    motion::AxisRequest request;
    request.command = command;
    request.target_si = target;
    request.buffer = buffer;
    return axes.submit(axis, request) != 0;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_TRUE(ask(axis, AxisCommand::kPower, 0.0));
  operation.run(milliseconds{200});
  ASSERT_EQ(axes.axis_report(2).state, motion::PlcopenState::kStandstill);
  const LockedMemory locked;
  if (!locked.refusal().empty()) GTEST_SKIP() << locked.refusal();
  ledger = {};
  int accepted = 0;
  for (int i = 0; i < 2500; ++i) {
    const auto axis = static_cast<std::size_t>(i % 3);
    accepted += ask(axis, AxisCommand::kMoveAbsolute, i % 2 == 0 ? 3.0 : -3.0) ? 1 : 0;
    accepted += ask(axis, AxisCommand::kMoveRelative, 0.5, motion::BufferMode::kBlendingLow) ? 1 : 0;
    accepted += ask(axis, AxisCommand::kSetOverride, 0.2 + 0.3 * (i % 4)) ? 1 : 0;
    accepted += ask(axis, i % 50 == 49 ? AxisCommand::kHalt : AxisCommand::kMoveVelocity, i % 7) ? 1 : 0;
    if (i % 10 == 0) operation.cycle();
    if (i % 500 == 0) drives.line().drop_frames(1);
  }
  EXPECT_LT(accepted, 9000) << "the queue was never full";
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_TRUE(ask(axis, AxisCommand::kStop, 0.0));
  operation.cycle();
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(axes.axis_report(axis).state, motion::PlcopenState::kStopping);
  operation.run(milliseconds{200});
  EXPECT_GE(ledger.cycles, 1500U);
  EXPECT_EQ(ledger.minor, 0);
  EXPECT_EQ(ledger.major, 0);
  EXPECT_EQ(ledger.counts.total(), 0U);
}

/// Delivers forged frames among the answers of the line: its own ones, changed anywhere, cut and extended.
class ForgingPort final : public PassingPort {
 public:
  using PassingPort::PassingPort;

  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override {
    if (hostile && !seen_.empty() && random_() % 3 != 0) return forge();
    auto frame = inner_.receive();
    if (frame) seen_.assign(frame->bytes.begin(), frame->bytes.end());
    return frame;
  }

  bool hostile = false;
  std::uint64_t forged = 0;

 private:
  port::ReceivedFrame forge() {
    ++forged;
    forgery_ = seen_;
    // Most often its headers: numbers, commands, addresses, lengths, working counters.
    for (auto changes = random_() % 9; changes > 0; --changes) {
      const auto within = random_() % 3 != 0 ? std::min<std::size_t>(forgery_.size(), 48) : forgery_.size();
      forgery_[random_() % within] = static_cast<std::byte>(random_());
    }
    if (random_() % 4 == 0) forgery_.resize(random_() % (port::kMaxFrameBytes + 1), std::byte{0xA5});
    return {forgery_, {}};
  }

  std::mt19937 random_{33};
  std::vector<std::byte> seen_;
  std::vector<std::byte> forgery_;
};

TEST_F(CyclePurity, HostileFramesCauseNoPageFault) {
  ForgingPort forging(drives.line());
  UnguardedLine line(forging, ledger);
  ConfiguredOperation operation(drives, line, RunOptions{.repeat = true});
  operation.start_cycle(guarded());
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  const LockedMemory locked;
  if (!locked.refusal().empty()) GTEST_SKIP() << locked.refusal();
  ledger = {};
  forging.hostile = true;
  operation.run(milliseconds{1500});
  EXPECT_GE(ledger.cycles, 10'000U);
  EXPECT_GT(forging.forged, 10'000U);
  EXPECT_GT(operation.statistics().stale_frames + operation.statistics().foreign_frames, 1000U);
  EXPECT_EQ(ledger.minor, 0);
  EXPECT_EQ(ledger.major, 0);
  EXPECT_EQ(ledger.counts.total(), 0U);
}

/// Writes to a page that the kernel has reserved but not mapped, in every cycle.
class FaultingTask final : public motion::CycleTask {
 public:
  FaultingTask() : page_(::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)) {
    EXPECT_NE(page_, MAP_FAILED);
  }
  ~FaultingTask() override { ::munmap(page_, kBytes); }
  FaultingTask(const FaultingTask&) = delete;
  FaultingTask& operator=(const FaultingTask&) = delete;

  void update(const motion::TaskCycle&) noexcept override {
    ::madvise(page_, kBytes, MADV_DONTNEED);
    *static_cast<volatile char*>(page_) = 1;
  }

 private:
  static constexpr std::size_t kBytes = 4096;
  void* page_;
};

TEST_F(CyclePurity, APageFaultInsideTheCycleWouldBeSeen) {
  FaultingTask task;
  RunOptions options;
  options.task = &task;
  ConfiguredOperation operation(drives, options);
  operation.start_cycle(guarded());
  ledger = {};
  operation.run(milliseconds{10});
  EXPECT_GE(ledger.minor, static_cast<std::int64_t>(ledger.cycles));
}

TEST_F(CyclePurity, AnAllocationInsideTheCycleWouldBeSeen) {
  WastefulPort port(drives.line());
  ConfiguredOperation operation(drives, port);
  operation.start_cycle(guarded());
  ledger = {};
  operation.run(milliseconds{10});
  EXPECT_GE(ledger.counts.allocations, ledger.cycles);
}

}  // namespace
}  // namespace driveline::bus_test
