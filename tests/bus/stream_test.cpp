// Setpoints from another process, followed by axes of simulated drives: whatever the client writes, and whenever it
// dies, the demands of the drives stay within the limits of their axes.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "counted_cycle.hpp"
#include "demand_judge.hpp"
#include "drive_line.hpp"
#include "driveline/rt/shared_broadcast.hpp"
#include "driveline/rt/shared_mapping.hpp"
#include "driveline/rt/shared_ring.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/stream/records.hpp"
#include "fault_ports.hpp"
#include "startup_objects.hpp"
#include "stream/single_axes_access.hpp"
#include "stream/stream_bounds.hpp"
#include "stream/stream_hub.hpp"
#include "stream/stream_session.hpp"

namespace driveline::bus_test {
namespace {

using motion::AxisCommand;
using motion::PlcopenState;
using runtime::StreamSession;
using stream::EndReason;
using stream::Refusal;
using stream::SessionState;
using stream::SetpointRecord;
using stream::StatusRecord;

constexpr nanoseconds kStreamPeriod = microseconds{125};
constexpr nanoseconds kKeepAlive = milliseconds{10};

/// Forwards to axes that are created later.
class LateAxes final : public runtime::StreamAxes {
 public:
  void lead_to(motion::SingleAxes& axes) { axes_access_.emplace(axes); }
  [[nodiscard]] View view(std::size_t axis) const noexcept override { return axes_access_->view(axis); }
  void follow(std::size_t axis) noexcept override { axes_access_->follow(axis); }
  void halt(std::size_t axis) noexcept override { axes_access_->halt(axis); }
  void power_on(std::size_t axis) noexcept override { axes_access_->power_on(axis); }

 private:
  std::optional<runtime::SingleAxesAccess> axes_access_;
};

RunOptions stream_options(motion::CycleTask& task) {
  RunOptions options;
  options.single_axes = true;
  options.task = &task;
  limit_quick_stops(options);
  return options;
}

/// The client end of a session, without the socket.
class FarEnd {
 public:
  explicit FarEnd(const StreamSession& session, rt::SharedSealing sealing = rt::SharedSealing::kComplete)
      : ring_memory(open(session.setpoints().descriptor(), stream::setpoint_ring(), sealing)),
        broadcast_memory(open(session.status().descriptor(), stream::status_broadcast())),
        ring(ring_memory),
        broadcast(broadcast_memory) {}

  void send(SetpointRecord record) {
    record.kind = stream::RecordKind::kSetpoint;
    record.number = ++number;
    EXPECT_TRUE(ring.try_push(record));
  }
  void say(stream::RecordKind kind) {
    SetpointRecord record;
    record.kind = kind;
    ring.try_push(record);
  }
  [[nodiscard]] StatusRecord status() const {
    StatusRecord record;
    EXPECT_TRUE(broadcast.latest(record));
    return record;
  }

  static rt::SharedMapping open(int descriptor, const rt::SharedLayout& layout,
                                rt::SharedSealing sealing = rt::SharedSealing::kComplete) {
    auto opened = rt::SharedMapping::open(descriptor, layout, sealing);
    return std::move(std::get<rt::SharedMapping>(opened));
  }

  rt::SharedMapping ring_memory;
  rt::SharedMapping broadcast_memory;
  rt::SharedRingWriter<SetpointRecord> ring;
  rt::SharedBroadcastReader<StatusRecord> broadcast;
  std::uint64_t number = 0;
};

/// A line in OP whose axes accept streams.
class StreamLine {
 public:
  explicit StreamLine(std::size_t axes = 2)
      : authority(axes),
        hub(late_axes, axes),
        options(stream_options(hub)),
        drives(axes),
        port(drives.line(), LossyPort::Direction::kBack, [this](auto, auto) { return lose; }),
        counted(port, page_faults),
        operation(drives, counted, options) {
    for (std::size_t i = 0; i < axes; ++i) judges.emplace_back(drives, i, LineOperation::axis(i, options).limits);
    EXPECT_EQ(sentence(operation.to_safe_op()), "");
    operation.start_cycle([this, axes](ecat_master::CyclicCore& core) -> std::unique_ptr<motion::CycleRunner> {
      late_axes.lead_to(operation.single_axes());
      for (std::size_t i = 0; i < axes; ++i) operation.single_axes().add_feed(hub.feed(i), {i});
      return std::make_unique<CountedRunner<PageFaultLedger>>(core, drives.clock, page_faults);
    });
    EXPECT_EQ(sentence(operation.master().go_operational()), "");
    cycles(100);
  }

  void cycle() {
    operation.cycle();
    const auto place = drives.clock.now() / kStreamPeriod * kStreamPeriod + microseconds{110};
    drives.leave_alone(std::max(place - drives.clock.now(), nanoseconds{0}));
    for (auto& judge : judges) judge.look();
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  /// Lets `periods` pass without a cycle.
  void stall(int periods) {
    for (int i = 0; i < periods; ++i) {
      drives.leave_alone(kStreamPeriod);
      for (auto& judge : judges) judge.look();
    }
    drives.leave_alone(microseconds{15});
    cycle();
  }
  [[nodiscard]] PlcopenState state(std::size_t axis) { return operation.single_axes().axis_report(axis).state; }
  [[nodiscard]] double setpoint(std::size_t axis) { return operation.single_axes().axis_report(axis).setpoint; }

  /// Gives an axis to a new owner, taking it over if necessary. Returns the number of the lease.
  std::uint64_t take_over(std::size_t axis, const std::string& owner) {
    runtime::LeaseTerms terms;
    terms.owner = owner;
    terms.take_over = true;
    return authority.take(axis, terms).value();
  }
  void ask(std::size_t axis, AxisCommand command, double target = 0.0) {
    motion::AxisRequest request;
    request.command = command;
    request.target_si = target;
    ASSERT_NE(operation.single_axes().submit(axis, request), 0U);
  }
  /// Makes the session of a client, which takes over its axes from any owner. It does not belong to the cycle yet.
  void make_session(std::size_t axes, trajectory::StreamMethod method,
                    rt::SharedSealing sealing = rt::SharedSealing::kComplete) {
    std::vector<StreamSession::Member> members;
    for (std::size_t i = 0; i < axes; ++i) {
      const bool moved = !authority.owner_of(i).empty();
      members.push_back({i, runtime::stream_bounds(LineOperation::axis(i, options)), take_over(i, "stream"), moved});
    }
    auto made = StreamSession::make(std::move(members), true, {.method = method, .keep_alive = kKeepAlive},
                                    kStreamPeriod, authority, sealing);
    ASSERT_TRUE(made);
    session = std::move(*made);
    client.emplace(*session, sealing);
    streamed = 0;
  }
  /// Admits a client, which takes over its axes from any owner.
  void admit(std::size_t axes, trajectory::StreamMethod method) {
    make_session(axes, method);
    ASSERT_TRUE(hub.add(*session));
  }
  /// Admits a client, and enables its axes.
  void let_in(std::size_t axes, trajectory::StreamMethod method = trajectory::StreamMethod::kHermite) {
    admit(axes, method);
    enable(axes);
  }
  /// Lets the client enable its axes.
  void enable(std::size_t axes) {
    for (int i = 0; i < 8000; ++i) {
      client->say(stream::RecordKind::kHeartbeat);
      cycle();
      bool ready = true;
      for (std::size_t axis = 0; axis < axes; ++axis) ready = ready && state(axis) == PlcopenState::kStandstill;
      if (ready) break;
    }
    for (std::size_t axis = 0; axis < axes; ++axis) {
      ASSERT_EQ(state(axis), PlcopenState::kStandstill);
      start[axis] = setpoint(axis);
    }
  }
  /// Runs cycles until its axes are free.
  void see_out(int at_most = 4000) {
    for (int i = 0; i < at_most && hub.holds(*session); ++i) cycle();
    ASSERT_FALSE(hub.holds(*session));
    authority.release_all("stream");
    for (std::size_t i = 0; i < session->members().size(); ++i) EXPECT_EQ(state(i), PlcopenState::kStandstill);
  }
  /// Raised cosines of 2 rad in 0.4 s, within all limits.
  [[nodiscard]] SetpointRecord swing(nanoseconds time, std::size_t axes) const {
    constexpr double kOmega = 2.0 * std::numbers::pi / 0.4;
    const double angle = kOmega * std::chrono::duration<double>(time).count();
    SetpointRecord record;
    record.time_ns = time.count();
    record.axis_count = static_cast<std::uint32_t>(axes);
    for (std::size_t i = 0; i < axes; ++i) {
      record.targets[i] = {start[i] + 1.0 - std::cos(angle), kOmega * std::sin(angle),
                           kOmega * kOmega * std::cos(angle)};
    }
    return record;
  }
  /// Streams the motion for `count` cycles, a setpoint every `step` cycles.
  void stream_swing(int count, int step) {
    for (int i = 0; i < count; ++i, ++streamed) {
      if (streamed % step == 0) client->send(swing(streamed * kStreamPeriod, session->members().size()));
      cycle();
    }
  }
  void expect_obedience() const {
    for (const auto& judge : judges) judge.expect_obedience();
  }
  void forget() {
    for (auto& judge : judges) judge.forget();
  }

  bool lose = false;
  LateAxes late_axes;
  runtime::AxisAuthority authority;
  runtime::StreamHub hub;
  RunOptions options;
  DriveLine drives;
  LossyPort port;
  PageFaultLedger page_faults;
  UncountedLine<PageFaultLedger> counted;
  LineOperation operation;
  std::vector<DemandJudge> judges;
  std::unique_ptr<StreamSession> session;
  std::optional<FarEnd> client;
  std::array<double, 4> start{};
  int streamed = 0;
};

/// A line that has let a client in, which now leads all axes.
struct LedLine : StreamLine {
  explicit LedLine(std::size_t axes = 2, trajectory::StreamMethod method = trajectory::StreamMethod::kHermite)
      : StreamLine(axes) {
    let_in(axes, method);
    forget();
  }
};

class StreamRate : public testing::TestWithParam<int> {};

TEST_P(StreamRate, AxesFollowOnTime) {
  LedLine line;
  line.stream_swing(4000, GetParam());
  const auto status = line.client->status();
  EXPECT_EQ(status.state, SessionState::kStreaming);
  EXPECT_EQ(status.starved + status.detours, 0U);
  for (const auto refused : status.refused) EXPECT_EQ(refused, 0U);
  // The status describes the previous setpoints.
  const auto expected = line.swing(nanoseconds{status.stream_ns} - kStreamPeriod, 2);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(line.state(i), PlcopenState::kSynchronizedMotion);
    EXPECT_EQ(status.axes[i].following, 1U);
    EXPECT_NEAR(status.axes[i].setpoint, expected.targets[i].position, 1e-5);
    EXPECT_NEAR(line.drives.drive(i).position_rad(), expected.targets[i].position, 0.05);
  }
  line.client->say(stream::RecordKind::kEnd);
  line.see_out();
  EXPECT_EQ(line.client->status().reason, EndReason::kEnded);
  line.expect_obedience();
}

// 8 kHz, 1 kHz, and a rate that fits no grid.
INSTANTIATE_TEST_SUITE_P(Rates, StreamRate, testing::Values(1, 8, 13));

/// Position of an axis that follows positions without velocities, by the law of docs/motion.md: its velocity is 50/s
/// times the distance, but never higher than it can brake with a quarter of its acceleration.
double behind_the_swing(const StreamLine& line, nanoseconds time) {
  const double braking = 0.5 * LineOperation::axis(0, line.options).limits.max_acceleration;
  double position = line.start[0];
  for (nanoseconds at{0}; at < time; at += kStreamPeriod) {
    const double distance = line.swing(at, 1).targets[0].position - position;
    const double speed = std::min(50.0 * std::abs(distance), std::sqrt(braking * std::abs(distance)));
    position += std::copysign(speed, distance) * std::chrono::duration<double>(kStreamPeriod).count();
  }
  return position;
}

class StreamMethods : public testing::TestWithParam<trajectory::StreamMethod> {};

TEST_P(StreamMethods, NoneBreaksALimit) {
  LedLine line(1, GetParam());
  line.stream_swing(3000, 8);
  EXPECT_EQ(line.state(0), PlcopenState::kSynchronizedMotion);
  const nanoseconds now{line.client->status().stream_ns};
  // Held steps have no velocity, so the axis lags behind them.
  const double expected = GetParam() == trajectory::StreamMethod::kHold ? behind_the_swing(line, now)
                                                                        : line.swing(now, 1).targets[0].position;
  EXPECT_NEAR(line.setpoint(0), expected, 0.05);
  line.expect_obedience();
}

using Method = trajectory::StreamMethod;
INSTANTIATE_TEST_SUITE_P(All, StreamMethods,
                         testing::Values(Method::kHold, Method::kLinear, Method::kHermite, Method::kCubic,
                                         Method::kQuintic, Method::kBSpline));

TEST(Stream, JitterWithinTheDelayIsNotSeen) {
  LedLine line;
  std::mt19937_64 random(21);
  int sent = 0;
  for (int i = 0; i < 4000; ++i) {
    // Up to 4 ms late, in bursts; the first one is on time.
    const int due = i / 8;
    const int late = static_cast<int>(random() % 5);
    for (; sent <= due - (sent == 0 ? 0 : late); ++sent) line.client->send(line.swing(milliseconds{sent}, 2));
    line.cycle();
  }
  const auto status = line.client->status();
  EXPECT_EQ(status.starved + status.detours, 0U);
  EXPECT_EQ(status.count(Refusal::kLate), 0U);
  line.expect_obedience();
}

TEST(Stream, LossesAndNonsenseBetweenSetpointsCostOnlyThose) {
  LedLine line;
  std::mt19937_64 random(22);
  for (int i = 0; i < 8000; ++i) {
    if (i % 8 == 0) {
      auto record = line.swing(i * kStreamPeriod, 2);
      switch (random() % 8) {
        case 0:
          ++line.client->number;
          break;
        case 1:
          record.targets[random() % 2].position = std::nan("");
          break;
        case 2:
          record.targets[random() % 2].position += 5.0;
          break;
        case 3:
          record.time_ns -= 20'000'000;
          break;
        default:
          break;
      }
      line.client->send(record);
    }
    line.cycle();
  }
  EXPECT_EQ(line.state(0), PlcopenState::kSynchronizedMotion);
  const auto status = line.client->status();
  for (const auto reason : {Refusal::kNotFinite, Refusal::kGap, Refusal::kTooFast, Refusal::kOutOfOrder}) {
    EXPECT_GT(status.count(reason), 50U) << to_text(reason);
  }
  line.expect_obedience();
}

/// What a client may try with memory that it shares with the cycle. Returns how much of it succeeded.
int misuse_of(const rt::SharedRegion& region, std::span<std::uint64_t> mapped) {
  const auto bytes = static_cast<off_t>(region.words().size_bytes());
  int done = 0;
  done += ::fallocate(region.descriptor(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, bytes) == 0 ? 1 : 0;
  done += ::ftruncate(region.descriptor(), 0) == 0 ? 1 : 0;
  done += ::madvise(mapped.data(), mapped.size_bytes(), MADV_REMOVE) == 0 ? 1 : 0;
  return done;
}

/// Wrong, old and impossible indexes, records of all rounds, and random words.
void scribble(std::span<std::uint64_t> words, std::mt19937_64& random, int round) {
  const auto record_words = (sizeof(SetpointRecord) + 7) / 8;
  for (int i = 0; i < 200; ++i) words[random() % words.size()] = random();
  const auto tail = words[rt::shared_detail::kTailWord];
  words[rt::shared_detail::kHeadWord] = round % 3 == 0 ? random() : tail + random() % 9;
  if (round % 2 == 0) return;
  for (auto at = rt::shared_detail::kRecordsWord; at + record_words <= words.size(); at += record_words) {
    words[at] = static_cast<std::uint64_t>(round);
    words[at + 1] = 1 | std::uint64_t{2} << 32U;
    words[at + 2] = random() % 100'000'000;
  }
}

TEST(Stream, AClientThatMisusesItsMemoryCausesNoPageFault) {
  StreamLine line;
  const LockedMemory locked;
  if (!locked.refusal().empty()) GTEST_SKIP() << locked.refusal();
  line.make_session(2, Method::kHermite, rt::SharedSealing::kSizeOnly);
  const auto words = line.client->ring_memory.words();
  EXPECT_GT(misuse_of(line.session->setpoints(), words), 0) << "not prevented before the client has mapped its memory";
  ASSERT_TRUE(line.session->close_to_writers());
  ASSERT_TRUE(line.hub.add(*line.session));
  line.page_faults = {};
  line.enable(2);
  std::mt19937_64 random(33);
  for (int round = 0; round < 400; ++round) {
    scribble(words, random, round);
    EXPECT_EQ(misuse_of(line.session->setpoints(), words), 0);
    EXPECT_EQ(misuse_of(line.session->status(), line.client->broadcast_memory.words()), 0);
    line.cycles(8);
  }
  EXPECT_GT(line.client->status().count(Refusal::kImpossibleIndex), 100U) << "the cycle has read that memory";
  EXPECT_GE(line.page_faults.cycles, 3200U);
  EXPECT_EQ(line.page_faults.minor, 0);
  EXPECT_EQ(line.page_faults.major, 0);
}

TEST(Stream, AnAxisElsewhereOrInMotionIsBroughtOntoTheStream) {
  StreamLine line;
  line.let_in(2);
  motion::AxisRequest jog;
  jog.command = AxisCommand::kMoveVelocity;
  jog.target_si = -20.0;
  static_cast<void>(line.operation.single_axes().submit(0, jog));
  for (int i = 0; i < 800; ++i) {
    line.client->say(stream::RecordKind::kHeartbeat);
    line.cycle();
  }
  ASSERT_EQ(line.state(0), PlcopenState::kContinuousMotion);
  line.forget();
  line.stream_swing(8000, 8);
  const auto status = line.client->status();
  const auto expected = line.swing(nanoseconds{status.stream_ns} - kStreamPeriod, 2);
  EXPECT_NEAR(status.axes[0].setpoint, expected.targets[0].position, 1e-5);
  EXPECT_NEAR(status.axes[1].setpoint, expected.targets[1].position, 1e-5);
  line.expect_obedience();
}

TEST(Stream, ByHandAnAxisIsTakenAndOnlyGivenBackWhenAsked) {
  LedLine line;
  line.stream_swing(1000, 8);
  motion::AxisRequest halt;
  halt.command = AxisCommand::kHalt;
  static_cast<void>(line.operation.single_axes().submit(1, halt));
  line.stream_swing(1000, 8);
  EXPECT_EQ(line.state(0), PlcopenState::kSynchronizedMotion);
  EXPECT_EQ(line.state(1), PlcopenState::kStandstill);
  EXPECT_EQ(line.client->status().axes[1].following, 0U);
  line.client->say(stream::RecordKind::kFollow);
  line.stream_swing(4000, 8);
  EXPECT_EQ(line.state(1), PlcopenState::kSynchronizedMotion);
  const auto status = line.client->status();
  const auto expected = line.swing(nanoseconds{status.stream_ns} - kStreamPeriod, 2);
  EXPECT_NEAR(status.axes[1].setpoint, expected.targets[1].position, 1e-5);
  line.expect_obedience();
}

TEST(Stream, ByHandAnAxisIsTakenOverInMotionAndGivenBack) {
  LedLine line;
  std::mt19937_64 random(26);
  for (int i = 0; i < 12; ++i) {
    line.stream_swing(static_cast<int>(200 + random() % 1000), 8);
    ASSERT_EQ(line.state(0), PlcopenState::kSynchronizedMotion) << "round " << i;
    line.take_over(0, "hand");
    // The request of the new owner comes some cycles later, or before the stream has noticed the loss of the axis.
    line.stream_swing(static_cast<int>(random() % 4), 8);
    if (i % 2 == 0) {
      line.ask(0, AxisCommand::kMoveVelocity, i % 4 == 0 ? 10.0 : -10.0);
    } else {
      line.ask(0, AxisCommand::kMoveAbsolute, line.start[0]);
    }
    line.stream_swing(static_cast<int>(2 + random() % 400), 8);
    EXPECT_NE(line.state(0), PlcopenState::kSynchronizedMotion) << "round " << i;
    EXPECT_EQ(line.client->status().axes[0].leased, 0U);
    EXPECT_EQ(line.state(1), PlcopenState::kSynchronizedMotion) << "each axis by itself";
    line.client->say(stream::RecordKind::kFollow);
    line.stream_swing(static_cast<int>(2 + random() % 100), 8);
    EXPECT_NE(line.state(0), PlcopenState::kSynchronizedMotion) << "it is his, round " << i;
    EXPECT_TRUE(line.session->asks_for(0));
    line.authority.release(0, "hand");
    line.session->give(0, line.take_over(0, "stream"));
    line.stream_swing(6000, 8);
    const auto status = line.client->status();
    const auto expected = line.swing(nanoseconds{status.stream_ns} - kStreamPeriod, 2);
    EXPECT_NEAR(status.axes[0].setpoint, expected.targets[0].position, 1e-5) << "round " << i;
  }
  line.expect_obedience();
}

TEST(Stream, FromTheHandAnAxisIsTakenOverInMotion) {
  LedLine line;
  line.client->say(stream::RecordKind::kEnd);
  line.see_out();
  std::mt19937_64 random(27);
  for (int i = 0; i < 12; ++i) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      line.take_over(axis, "hand");
      line.ask(axis, AxisCommand::kMoveVelocity, static_cast<double>(random() % 80) - 40.0);
    }
    line.cycles(static_cast<int>(random() % 500));
    line.admit(2, trajectory::StreamMethod::kHermite);
    line.stream_swing(static_cast<int>(400 + random() % 4000), i % 2 == 0 ? 1 : 8);
    EXPECT_EQ(line.state(0), PlcopenState::kSynchronizedMotion) << "round " << i;
    EXPECT_EQ(line.state(1), PlcopenState::kSynchronizedMotion) << "round " << i;
    line.client->say(stream::RecordKind::kEnd);
    line.see_out();
  }
  line.expect_obedience();
}

TEST(Stream, AMasterThatIsAwayAndLostFramesBreakNoLimit) {
  LedLine line;
  std::mt19937_64 random(23);
  for (int i = 0; i < 40; ++i) {
    line.stream_swing(static_cast<int>(50 + random() % 100), 8);
    if (i % 2 == 0) {
      const int away = static_cast<int>(1 + random() % 6);
      line.stall(away);
      line.streamed += away + 1;
    } else {
      line.lose = true;
      line.stream_swing(static_cast<int>(1 + random() % 4), 8);
      line.lose = false;
    }
  }
  EXPECT_EQ(line.state(0), PlcopenState::kSynchronizedMotion);
  EXPECT_EQ(line.state(1), PlcopenState::kSynchronizedMotion);
  line.expect_obedience();
}

TEST(Stream, AClientThatDiesAtAnyTimeBreaksNoLimit) {
  StreamLine line;
  std::mt19937_64 random(24);
  for (int death = 0; death < 100; ++death) {
    line.let_in(2);
    ASSERT_FALSE(testing::Test::HasFailure()) << "death " << death;
    if (death == 0) line.forget();
    const int step = death % 2 == 0 ? 1 : 8;
    line.stream_swing(static_cast<int>(random() % 400), step);
    // For half of the clients the closed connection is noticed, the others are only silent.
    if (death % 4 < 2) line.session->request_end(EndReason::kGone);
    line.see_out();
    ASSERT_EQ(line.client->status().state, SessionState::kOver) << "death " << death;
  }
  line.expect_obedience();
}

TEST(Stream, NothingInItsMemoryBreaksALimit) {
  StreamLine line;
  line.let_in(1);
  line.forget();
  std::mt19937_64 random(25);
  const auto words = line.client->ring_memory.words();
  constexpr std::size_t kRecordWords = sizeof(SetpointRecord) / 8;
  for (int i = 0; i < 20'000; ++i) {
    for (int k = 0; k < 20; ++k) words[random() % words.size()] = random();
    if (i % 3 != 0) {
      // Almost correct records: setpoints of an axis at random positions, with increasing numbers and times.
      auto record = line.swing(i * kStreamPeriod, 1);
      record.kind = stream::RecordKind::kSetpoint;
      record.number = static_cast<std::uint64_t>(i) + 1;
      record.targets[0].position += 1e-3 * static_cast<double>(random() % 1000);
      record.targets[0].velocity = 0.1 * static_cast<double>(random() % 500) - 25.0;
      record.targets[0].acceleration = 1e6;
      const auto tail = words[rt::shared_detail::kTailWord] % StreamSession::kRingRecords;
      rt::shared_detail::store_record<std::memory_order_relaxed>(
          &words[rt::shared_detail::kRecordsWord + tail * kRecordWords], record);
      words[rt::shared_detail::kHeadWord] = words[rt::shared_detail::kTailWord] + 1;
    }
    line.cycle();
  }
  EXPECT_GT(line.client->status().taken, 1000U);
  EXPECT_NE(line.state(0), PlcopenState::kErrorStop);
  EXPECT_NE(line.state(1), PlcopenState::kErrorStop);
  EXPECT_EQ(line.operation.statistics().missed_periods, 0U);
  line.expect_obedience();
}

}  // namespace
}  // namespace driveline::bus_test
