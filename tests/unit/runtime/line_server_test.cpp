// The serving loop of `simulate`, turn by turn on virtual time: two interfaces, faults, messages to its owner.
#include "driveline/runtime/served/line_server.hpp"

#include <gmock/gmock.h>

#include <array>
#include <deque>

#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/wire/frame.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using slaves::Fault;
using slaves::FaultKind;
using std::chrono::nanoseconds;
using Frame = std::vector<std::byte>;

/// An interface whose cable ends in the test.
class TestPort final : public port::Port {
 public:
  explicit TestPort(rt::Clock& clock) : clock_(clock) {}
  port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    sent.emplace_back(frame.begin(), frame.end());
    return status;
  }
  std::optional<port::ReceivedFrame> receive() noexcept override {
    if (incoming.empty()) return std::nullopt;
    current_ = std::move(incoming.front());
    incoming.pop_front();
    return port::ReceivedFrame{current_, clock_.now()};
  }
  bool wait_readable(nanoseconds deadline) noexcept override {
    if (incoming.empty()) clock_.sleep_until(deadline);
    return !incoming.empty();
  }
  nanoseconds last_send_time() const noexcept override { return {}; }

  std::deque<Frame> incoming;
  std::vector<Frame> sent;
  port::SendStatus status = port::SendStatus::kSent;

 private:
  rt::Clock& clock_;
  Frame current_;
};

Frame brd(std::size_t length = 2, std::uint8_t index = 0) {
  Frame buffer(port::kMaxFrameBytes);
  wire::FrameBuilder builder(buffer, {});
  builder.add(wire::Command::kBrd, index, wire::DatagramAddress::physical(0, 0x0130), length);
  const auto frame = builder.finish();
  return {frame.begin(), frame.end()};
}

/// A frame to the first slave; reads if there is nothing to write.
Frame access(std::uint16_t address, std::size_t length, std::span<const std::byte> write = {}) {
  Frame buffer(port::kMaxFrameBytes);
  wire::FrameBuilder builder(buffer, {});
  const auto command = write.empty() ? wire::Command::kAprd : wire::Command::kApwr;
  const auto place = builder.add(command, 0, wire::DatagramAddress::physical(0, address), length);
  std::copy(write.begin(), write.end(), builder.data(*place).begin());
  const auto frame = builder.finish();
  return {frame.begin(), frame.end()};
}

/// The value in a returned frame with one datagram.
std::uint64_t value_in(const Frame& frame) {
  std::uint64_t value = 0;
  const auto data = wire::DatagramCursor::open(frame)->next()->data;
  for (std::size_t i = data.size(); i-- > 0;) value = value << 8U | std::to_integer<std::uint64_t>(data[i]);
  return value;
}

std::uint16_t working_counter(const Frame& frame) {
  auto cursor = wire::DatagramCursor::open(frame);
  return cursor ? cursor->next()->working_counter() : 0xFFFF;
}

class LineServerTest : public testing::Test {
 protected:
  void serve(std::size_t count, std::optional<slaves::Wiring> wiring = std::nullopt, bool second = false) {
    std::vector<std::unique_ptr<slaves::Slave>> made;
    for (std::size_t i = 0; i < count; ++i) {
      made.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>()));
    }
    line = std::make_unique<slaves::SimulatedLine>(clock, std::move(made), slaves::LineOptions{}, std::move(wiring));
    server = std::make_unique<LineServer>(*line, primary, second ? &secondary : nullptr, clock, LineServer::Settings{});
  }
  /// Runs turns like run(), for `duration`.
  void run(nanoseconds duration) {
    const auto end = clock.now() + duration;
    while (clock.now() < end) {
      const auto next = server->turn();
      if (next > clock.now()) clock.sleep_until(std::min(next, end));
    }
    server->turn();
  }
  std::vector<StateChange> changes() {
    std::vector<StateChange> all;
    StateChange change;
    while (server->next_change(change)) all.push_back(change);
    return all;
  }
  LineOrder carried_out(LineOrder::Verb verb, const Fault& fault) {
    EXPECT_TRUE(server->order({.verb = verb, .fault = fault}));
    run(1ms);
    LineOrder answer;
    EXPECT_TRUE(server->next_answer(answer));
    return answer;
  }

  rt::VirtualClock clock{1s};
  TestPort primary{clock};
  TestPort secondary{clock};
  std::unique_ptr<slaves::SimulatedLine> line;
  std::unique_ptr<LineServer> server;
};

TEST_F(LineServerTest, AnswersAreAsLongAsTheirRequests) {
  serve(2);
  for (const std::size_t length : {1U, 33U, 500U, 1486U}) primary.incoming.push_back(brd(length));
  auto tagged = brd(2);
  tagged.insert(tagged.begin() + 12, {std::byte{0x81}, std::byte{0x00}, std::byte{0x00}, std::byte{0x05}});
  primary.incoming.push_back(tagged);
  const auto requests = primary.incoming;
  run(1ms);
  ASSERT_EQ(primary.sent.size(), requests.size());
  for (std::size_t i = 0; i < requests.size(); ++i) EXPECT_EQ(primary.sent[i].size(), requests[i].size());
  EXPECT_EQ(working_counter(primary.sent[0]), 2);
  EXPECT_EQ(server->frames(), 5U);
}

TEST_F(LineServerTest, AnUnpaddedFrameComesBackPadded) {
  serve(1);
  auto request = brd(2);
  request.resize(30);
  primary.incoming.push_back(request);
  run(1ms);
  ASSERT_EQ(primary.sent.size(), 1U);
  EXPECT_EQ(primary.sent[0].size(), 60U);
  EXPECT_EQ(working_counter(primary.sent[0]), 1);
  EXPECT_TRUE(
      std::all_of(primary.sent[0].begin() + 30, primary.sent[0].end(), [](auto b) { return b == std::byte{0}; }));
}

TEST_F(LineServerTest, AWholeRingLeadsFromEitherInterfaceToTheOther) {
  serve(3, slaves::Wiring::ring(3), true);
  primary.incoming.push_back(brd());
  run(1ms);
  ASSERT_EQ(secondary.sent.size(), 1U);
  EXPECT_TRUE(primary.sent.empty());
  EXPECT_EQ(working_counter(secondary.sent[0]), 3);
  secondary.incoming.push_back(brd());
  run(1ms);
  ASSERT_EQ(primary.sent.size(), 1U);
  EXPECT_EQ(working_counter(primary.sent[0]), 0) << "against the order of processing";
}

TEST_F(LineServerTest, ABrokenRingAnswersAtBothInterfaces) {
  serve(4, slaves::Wiring::ring(4), true);
  EXPECT_TRUE(carried_out(LineOrder::Verb::kBegin, {.kind = FaultKind::kCableBreak, .slave = 0, .port = 1}).done);
  primary.incoming.push_back(brd());
  secondary.incoming.push_back(brd());
  run(1ms);
  ASSERT_EQ(primary.sent.size(), 1U);
  ASSERT_EQ(secondary.sent.size(), 1U);
  EXPECT_EQ(working_counter(primary.sent[0]), 1);
  EXPECT_EQ(working_counter(secondary.sent[0]), 3);
}

TEST_F(LineServerTest, DelayedRepliesComeInOrderAtTheirTime) {
  serve(1);
  ASSERT_TRUE(line->inject({.kind = FaultKind::kDelay, .count = 1, .time = 400us}));
  primary.incoming = {brd(2, 1), brd(2, 2)};
  run(399us);
  EXPECT_TRUE(primary.sent.empty()) << "the second waits behind the first";
  run(2us);
  ASSERT_EQ(primary.sent.size(), 2U);
  EXPECT_EQ(primary.sent[0][17], std::byte{1});
  EXPECT_EQ(primary.sent[1][17], std::byte{2});
  primary.incoming.push_back(brd(2, 3));
  run(1us);
  EXPECT_EQ(primary.sent.size(), 3U) << "and then all is as before";
}

TEST_F(LineServerTest, MoreDelayedRepliesThanThereIsRoomForAreLost) {
  serve(1);
  ASSERT_TRUE(line->inject({.kind = FaultKind::kDelay, .time = 100ms}));
  for (int i = 0; i < 70; ++i) primary.incoming.push_back(brd());
  run(200ms);
  EXPECT_EQ(primary.sent.size(), 64U);
  EXPECT_EQ(server->send_failures(), 6U);
}

TEST_F(LineServerTest, DuplicatesGoOutTwiceAndDropsNotAtAll) {
  serve(1);
  ASSERT_TRUE(line->inject({.kind = FaultKind::kDuplicate, .count = 1}));
  primary.incoming.push_back(brd());
  run(100us);
  ASSERT_EQ(primary.sent.size(), 2U);
  EXPECT_EQ(primary.sent[0], primary.sent[1]);
  line->drop_frames(1);
  primary.incoming.push_back(brd());
  run(100us);
  EXPECT_EQ(primary.sent.size(), 2U);
}

TEST_F(LineServerTest, FramesThatCannotBeSentAreCounted) {
  serve(1);
  primary.status = port::SendStatus::kBusy;
  primary.incoming.push_back(brd());
  run(100us);
  EXPECT_EQ(server->send_failures(), 1U);
}

TEST_F(LineServerTest, TheOwnerHearsOfStatesAndPower) {
  serve(2);
  run(1ms);
  EXPECT_TRUE(changes().empty()) << "INIT is where all begin";
  const Fault off{.kind = FaultKind::kPowerOff, .slave = 1};
  EXPECT_TRUE(carried_out(LineOrder::Verb::kBegin, off).done);
  auto told = changes();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].slave, 1);
  EXPECT_EQ(told[0].status.state, wire::AlState::kNone);
  EXPECT_TRUE(carried_out(LineOrder::Verb::kHeal, off).done);
  told = changes();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].status.state, wire::AlState::kInit);
  EXPECT_FALSE(carried_out(LineOrder::Verb::kHeal, off).done) << "healed already";
  EXPECT_FALSE(carried_out(LineOrder::Verb::kBegin, {.kind = FaultKind::kPowerOff, .slave = 2}).done);
  EXPECT_TRUE(carried_out(LineOrder::Verb::kHealAll, {}).done);
}

TEST_F(LineServerTest, SlavesLiveOnWithoutFrames) {
  serve(1);
  const auto begin = clock.now();
  run(50ms);
  // A drive has its own time: its outputs' watchdog, its control loops and its script all run in the same advance().
  line->faults().schedule(begin + 60ms, {.kind = FaultKind::kPowerOff, .slave = 0});
  run(20ms);
  EXPECT_FALSE(line->slave(0).powered());
  const auto told = changes();
  ASSERT_EQ(told.size(), 1U);
}

/// The thread was descheduled when the frame arrived.
TEST_F(LineServerTest, AFrameMeetsSlavesThatAreNotBehindIt) {
  serve(1);
  ASSERT_TRUE(line->inject({.kind = FaultKind::kSlowTransition, .slave = 0, .time = 20ms}));
  primary.incoming.push_back(access(0x0120, 2, std::array{std::byte{2}, std::byte{0}}));
  run(1ms);
  clock.advance(50ms);
  primary.incoming.push_back(access(0x0130, 2));
  server->turn();
  ASSERT_EQ(primary.sent.size(), 2U);
  EXPECT_EQ(value_in(primary.sent[1]), 0x0011U) << "INIT and an error, for 30 ms";
}

/// Outputs that arrive after SYNC0 do not belong to this SYNC0, however short the delay.
TEST_F(LineServerTest, AFrameBehindSync0ComesBehindIt) {
  serve(1);
  run(1ms);
  const auto reply = [this](Frame frame) {
    primary.incoming.push_back(std::move(frame));
    server->turn();
    return value_in(primary.sent.back());
  };
  const auto write = [&reply](std::uint16_t address, std::uint64_t value, std::size_t length) {
    const auto bytes = bytes::to_le_bytes(value);
    static_cast<void>(reply(access(address, length, std::span(bytes).first(length))));
  };
  const auto now = reply(access(0x0910, 8));
  write(0x09A0, 1'000'000, 4);     // cycle of SYNC0
  write(0x0990, now + 30'000, 8);  // start time of SYNC0
  write(0x0981, 0x03, 1);          // activation
  EXPECT_EQ(reply(access(0x0984, 1)), 0x01U) << "the first pulse is to come";
  clock.advance(40us);
  EXPECT_EQ(reply(access(0x0984, 1)), 0x00U) << "it has come";
}

TEST_F(LineServerTest, AStateChangeTakesItsTimeWhileNobodyAsks) {
  serve(1);
  ASSERT_TRUE(line->inject({.kind = FaultKind::kSlowTransition, .slave = 0, .time = 20ms}));
  Frame buffer(port::kMaxFrameBytes);
  wire::FrameBuilder builder(buffer, {});
  const auto place = builder.add(wire::Command::kBwr, 0, wire::DatagramAddress::physical(0, 0x0120), 2);
  builder.data(*place)[0] = std::byte{2};  // PREOP, but no mailbox is set up for it
  const auto frame = builder.finish();
  primary.incoming.emplace_back(frame.begin(), frame.end());
  run(19ms);
  EXPECT_TRUE(changes().empty());
  run(2ms);
  const auto told = changes();
  ASSERT_EQ(told.size(), 1U) << "no frame has come since";
  EXPECT_EQ(told[0].status, (wire::AlStatus{wire::AlState::kInit, true, false}));
  EXPECT_EQ(told[0].code, wire::AlStatusCode::kInvalidMailboxConfigurationPreOp);
}

TEST_F(LineServerTest, NoSlaveOfALongLineIsForgottenUnderLoad) {
  // Frames arrive faster than all slaves can be advanced in between: a few slaves at a time, and finally all of them.
  serve(100);
  for (std::size_t i = 0; i < 100; ++i) {
    ASSERT_TRUE(
        line->inject({.kind = FaultKind::kSlowTransition, .slave = static_cast<std::uint16_t>(i % 60), .time = 1ms}));
  }
  Frame buffer(port::kMaxFrameBytes);
  wire::FrameBuilder builder(buffer, {});
  const auto place = builder.add(wire::Command::kBwr, 0, wire::DatagramAddress::physical(0, 0x0120), 2);
  builder.data(*place)[0] = std::byte{2};
  const auto request = builder.finish();
  primary.incoming.emplace_back(request.begin(), request.end());
  for (int i = 0; i < 200; ++i) {
    primary.incoming.push_back(brd());
    server->turn();
    clock.advance(10us);
  }
  EXPECT_EQ(primary.incoming.size(), 1U) << "one frame a turn";
  for (std::size_t i = 0; i < 100; ++i) EXPECT_TRUE(line->slave(i).esc().al_status().error) << "slave " << i;
}

TEST_F(LineServerTest, TurnAroundTimesComeInWindowsAndAsAWhole) {
  serve(1);
  rt::Histogram window;
  EXPECT_FALSE(server->take_window(window));
  for (int i = 0; i < 10; ++i) primary.incoming.push_back(brd());
  run(1ms);
  server->request_window();
  run(1ms);
  ASSERT_TRUE(server->take_window(window));
  EXPECT_EQ(window.count(), 10U);
  EXPECT_FALSE(server->take_window(window)) << "only when asked for";
  for (int i = 0; i < 5; ++i) primary.incoming.push_back(brd());
  run(1ms);
  server->request_window();
  run(1ms);
  ASSERT_TRUE(server->take_window(window));
  EXPECT_EQ(window.count(), 5U);
  primary.incoming.push_back(brd());
  run(1ms);
  EXPECT_EQ(server->turn_around().count(), 16U);
}

TEST_F(LineServerTest, SignalsOfADeviceAreSetAndRead) {
  using Direction = slaves::SignalId::Direction;
  serve(2);
  run(5ms);
  const auto carried_out = [this](LineOrder order) {
    EXPECT_TRUE(server->order(order));
    run(1ms);
    LineOrder answer;
    EXPECT_TRUE(server->next_answer(answer));
    return answer;
  };
  const auto* signals = line->slave(1).device().signals();
  const auto isdsh = signals->find_signal(Direction::kInput, "ISDSH");
  const auto relay = signals->find_signal(Direction::kOutput, "STO_RELAY");
  ASSERT_TRUE(isdsh && relay);
  LineOrder read;
  read.verb = LineOrder::Verb::kReadSignal;
  read.slave = 1;
  read.signal = *relay;
  EXPECT_EQ(carried_out(read).value, 0.0);
  LineOrder set = read;
  set.verb = LineOrder::Verb::kSetSignal;
  set.signal = *isdsh;
  set.value = 0.0;
  EXPECT_TRUE(carried_out(set).done);
  EXPECT_EQ(carried_out(read).value, 1.0) << "safe torque off is active";
  read.slave = 0;
  EXPECT_EQ(carried_out(read).value, 0.0) << "only at its slave";
}

}  // namespace
}  // namespace driveline::runtime
