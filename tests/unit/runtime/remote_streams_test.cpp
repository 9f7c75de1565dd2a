// Streams of setpoints from remote clients: ownership of the axes, checks, and the end of a stream.
#include "stream/remote_streams.hpp"

#include <gmock/gmock.h>

#include <cstring>
#include <limits>
#include <random>

#include "stream_line.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using snapshot::SetpointKind;
using snapshot::StreamedSetpoint;
using snapshot::StreamReport;
using snapshot::StreamReportState;
using stream::MotionState;
using testing::Contains;
using testing::HasSubstr;

constexpr const char* kPanel = "dds panel (participant 01)";

class RemoteStreamsTest : public testing::Test {
 protected:
  RemoteStreamsTest() {
    for (std::size_t i = 0; i < 3; ++i) line.axes.all[i].view.state = MotionState::kStandstill;
  }
  static std::vector<StreamAxis> offered() {
    std::vector<StreamAxis> axes;
    for (std::size_t i = 0; i < 3; ++i) {
      axes.push_back({std::string(1, static_cast<char>('x' + i)),
                      i,
                      {-100.0, 100.0, 10.0, 100.0},
                      *trajectory::find_position_unit("deg")});
    }
    return axes;
  }
  std::uint64_t acquire(std::size_t axis, const char* owner = kPanel) { return line.take(axis, owner).value(); }
  /// A record of the client "panel" for these axes, without a setpoint.
  static StreamedSetpoint record(const std::vector<std::pair<std::string, std::uint64_t>>& axes,
                                 SetpointKind kind = SetpointKind::kGo) {
    StreamedSetpoint record;
    record.participant[0] = 1;
    record.client.set("panel");
    record.kind = static_cast<std::uint32_t>(kind);
    for (const auto& [name, lease] : axes) {
      record.axes[record.axis_count].name.set(name);
      record.axes[record.axis_count++].lease = lease;
    }
    return record;
  }
  static StreamedSetpoint at(StreamedSetpoint record, std::uint64_t number, std::chrono::nanoseconds time,
                             double position, double velocity = 0.0) {
    record.number = number;
    record.time_ns = time.count();
    record.target_count = record.axis_count;
    for (std::size_t i = 0; i < record.axis_count; ++i) record.targets[i] = {position, velocity, 0.0};
    return record;
  }
  bool take(const StreamedSetpoint& record, const char* owner = kPanel) { return streams.take(record, owner, now); }
  void run(std::chrono::nanoseconds duration) {
    line.run(duration);
    now += duration;
    look();
  }
  void look() {
    streams.poll(now);
    for (auto& facts : streams.take_events()) told.push_back(describe(Event{std::move(facts)}));
    for (const auto& report : streams.take_reports()) last = report;
  }
  [[nodiscard]] StreamReportState state() const { return static_cast<StreamReportState>(last.state); }
  std::string refusal(const StreamedSetpoint& record, const char* owner = kPanel) {
    EXPECT_FALSE(take(record, owner));
    now += RemoteStreams::kReportInterval;
    look();
    EXPECT_EQ(state(), StreamReportState::kRefused);
    return std::string(last.text.view());
  }
  /// Streams a motion setpoint by setpoint for `milliseconds`.
  void swing_for(const StreamedSetpoint& axes, int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) {
      const auto target = swing(1e-3 * static_cast<double>(sent));
      EXPECT_TRUE(take(at(axes, sent + 1, sent * 1ms, target.position, target.velocity)));
      ++sent;
      run(1ms);
    }
  }

  StreamLine line;
  RemoteStreams streams{line.hub, line.authority, {}, offered(), kPeriod};
  std::chrono::nanoseconds now{};
  std::vector<std::string> told;
  StreamReport last{};
  std::uint64_t sent = 0;
};

TEST_F(RemoteStreamsTest, MoveTheAxesOfTheirLeases) {
  const auto axes = record({{"x", acquire(0)}, {"z", acquire(2)}});
  swing_for(axes, 400);
  now += RemoteStreams::kReportInterval;
  look();
  EXPECT_EQ(state(), StreamReportState::kStreaming);
  EXPECT_THAT(told, Contains("the stream of dds panel (participant 01) has x, z"));
  EXPECT_EQ(last.taken, 400U);
  EXPECT_EQ(last.refused, 0U);
  ASSERT_EQ(last.axis_count, 2U);
  EXPECT_EQ(last.axes[1].name.view(), "z");
  EXPECT_EQ(last.axes[1].following, 1U);
  EXPECT_GT(std::abs(line.axes.all[2].view.setpoint), 0.05);
  EXPECT_EQ(line.axes.all[1].view.setpoint, 0.0);
  EXPECT_LE(largest_step(line.axes.all[0].demands), 6.3 * 125e-6);
  // The axes come to rest, and the leases continue.
  EXPECT_TRUE(take(record({{"x", axes.axes[0].lease}, {"z", axes.axes[1].lease}}, SetpointKind::kEnd)));
  run(50ms);
  EXPECT_EQ(state(), StreamReportState::kOver);
  EXPECT_THAT(told.back(),
              HasSubstr("the stream of dds panel (participant 01) has ended, it has ended the session: 400"));
  EXPECT_EQ(line.authority.owner_of(0), kPanel);
  // The next stream may restart.
  sent = 0;
  EXPECT_TRUE(take(at(axes, 1, 0ms, line.axes.all[0].view.setpoint)));
  run(30ms);
  EXPECT_EQ(line.axes.all[0].view.state, MotionState::kSynchronizedMotion);
}

TEST_F(RemoteStreamsTest, AreRefusedWithoutTheLeases) {
  const auto* const sentence = "axis x: the caller does not hold the lease of the axis; acquire the axis first";
  EXPECT_EQ(refusal(record({{"x", 7}})), sentence);
  const auto lease = acquire(0);
  EXPECT_EQ(refusal(record({{"x", lease}}), "dds other (participant 02)"), sentence) << "who has heard its number";
  EXPECT_EQ(refusal(record({{"x", lease + 1}})), sentence);
  EXPECT_EQ(refusal(record({{"x", lease}, {"x", lease}})), "axis x is named twice");
  EXPECT_EQ(refusal(record({{"q\n", lease}})), "there is no axis \"q?\" for streams");
  EXPECT_EQ(refusal(record({})), "a stream has 1 to 16 axes, not 0");
  auto many = record({{"x", lease}});
  many.axis_count = 4'000'000'000U;
  EXPECT_EQ(refusal(many), "a stream has 1 to 16 axes, not 4000000000");
  EXPECT_FALSE(line.hub.full());
  EXPECT_THAT(
      told.front(),
      HasSubstr("the stream of dds panel (participant 01) was rejected: axis x: the caller does not hold the lease"));
  EXPECT_LE(told.size(), 2U) << "one a second";
  EXPECT_FALSE(take(record({{"x", lease}}, SetpointKind::kEnd))) << "there is none";
  streams.close();
  EXPECT_EQ(refusal(record({{"x", lease}})), "the line ends");
}

TEST_F(RemoteStreamsTest, AnAxisWhoseLeaseEndsComesToRestAndTheOthersGoOn) {
  const auto x = acquire(0);
  const auto y = acquire(1);
  swing_for(record({{"x", x}, {"y", y}}), 100);
  line.authority.release(1, kPanel);
  ASSERT_TRUE(line.take(1, "hand"));
  for (int i = 0; i < 20; ++i) {
    const auto target = swing(1e-3 * static_cast<double>(sent));
    EXPECT_FALSE(take(at(record({{"x", x}, {"y", y}}), sent + 1, sent * 1ms, target.position, target.velocity)))
        << "not all of them are his";
    ++sent;
    run(1ms);
  }
  EXPECT_EQ(line.axes.all[1].view.state, MotionState::kStandstill);
  EXPECT_EQ(line.axes.all[0].view.state, MotionState::kSynchronizedMotion);
  EXPECT_EQ(last.axes[1].leased, 0U);
  // After it is acquired again, the axis follows again when the client requests it.
  line.authority.release(1, "hand");
  const auto again = acquire(1);
  ASSERT_NE(again, y);
  EXPECT_TRUE(take(record({{"x", x}, {"y", again}}, SetpointKind::kFollow)));
  swing_for(record({{"x", x}, {"y", again}}), 20);
  EXPECT_EQ(line.axes.all[1].view.state, MotionState::kSynchronizedMotion);
}

TEST_F(RemoteStreamsTest, EndWithTheirLastLeaseAndWithTheBridge) {
  swing_for(record({{"x", acquire(0)}}), 100);
  line.authority.release(0, kPanel);
  run(1ms);
  run(50ms);
  EXPECT_EQ(state(), StreamReportState::kOver);
  EXPECT_EQ(line.axes.all[0].view.state, MotionState::kStandstill);
  sent = 0;
  line.axes.all[0].view.setpoint = 0.0;
  swing_for(record({{"x", acquire(0)}}), 100);
  streams.end_all(stream::EndReason::kGone);
  run(50ms);
  EXPECT_EQ(state(), StreamReportState::kOver);
  EXPECT_LE(largest_step(line.axes.all[1].demands), 0.0);
}

TEST_F(RemoteStreamsTest, ASilentClientLosesItsStream) {
  swing_for(record({{"x", acquire(0)}}), 100);
  run(101ms);
  run(20ms);
  EXPECT_EQ(state(), StreamReportState::kOver);
  EXPECT_EQ(last.text.view(), "it was silent for longer than the keep-alive time");
  EXPECT_EQ(line.axes.all[0].view.state, MotionState::kStandstill);
}

TEST_F(RemoteStreamsTest, WhatIsRefusedIsToldWithAxisValueAndLimit) {
  const auto axes = record({{"x", acquire(0)}});
  swing_for(axes, 50);
  EXPECT_TRUE(take(at(axes, ++sent, 51ms, 101.0)));
  run(20ms);
  EXPECT_THAT(
      std::string(last.text.view()),
      HasSubstr("outside the range of an axis: axis x: position 5786.87 deg, allowed are -5729.58 deg to 5729.58 deg"));
  EXPECT_EQ(last.refused, 1U);
  EXPECT_TRUE(take(at(axes, ++sent, 52ms, 0.1, -11.0)));
  run(20ms);
  EXPECT_THAT(std::string(last.text.view()), HasSubstr("axis x: velocity -630.254 deg/s, "));
  EXPECT_TRUE(take(at(axes, ++sent, 53ms, std::numeric_limits<double>::quiet_NaN())));
  run(20ms);
  EXPECT_THAT(std::string(last.text.view()), HasSubstr("is not finite: axis x: position nan deg"));
  auto other = at(record({{"y", axes.axes[0].lease}}), ++sent, 54ms, 0.1);
  take(other);
  run(20ms);
  EXPECT_THAT(std::string(last.text.view()), HasSubstr("is for another number of axes"));
  EXPECT_EQ(last.refused, 4U);
}

TEST_F(RemoteStreamsTest, GarbageMovesNothing) {
  std::mt19937_64 chance(1);
  acquire(0);
  for (int i = 0; i < 20'000; ++i) {
    StreamedSetpoint garbage;
    std::array<std::uint64_t, sizeof(garbage) / 8> words{};
    for (auto& word : words) word = chance();
    std::memcpy(static_cast<void*>(&garbage), words.data(), sizeof(garbage));
    if (i % 2 == 0) {
      garbage.axes[0].name.set("x");
      garbage.axis_count = 1;
      garbage.kind = static_cast<std::uint32_t>(i % 5);
    }
    take(garbage);
    if (i % 100 == 0) run(1ms);
  }
  run(50ms);
  for (const auto& axis : line.axes.all) EXPECT_LE(largest_step(axis.demands), 0.0);
}

}  // namespace
}  // namespace driveline::runtime
