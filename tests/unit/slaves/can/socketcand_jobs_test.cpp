// Cyclic jobs, subscriptions and statistics of socketcand, with the examples of its doc/protocol.md.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "driveline/slaves/can/socketcand_door.hpp"
#include "support/scripted_node.hpp"

namespace driveline::slaves::can {
namespace {

using bytes_test::hex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

class SocketcandJobs : public ::testing::Test {
 protected:
  SocketcandJobs() {
    bus.attach(node);
    bus.attach(door);
    door.open();
    say("< open can0 >");
  }
  /// What the client gets for these bytes, at once.
  std::string say(std::string_view bytes) {
    door.input(bytes, bus.now());
    return take();
  }
  std::string take() {
    std::string text(door.output());
    door.taken(text.size());
    return text;
  }
  /// What the client gets meanwhile.
  std::string run(nanoseconds time) {
    bus.advance(bus.now() + time);
    return take();
  }
  /// When frames with this identifier came, in milliseconds.
  [[nodiscard]] std::vector<std::int64_t> times_of(std::uint32_t identifier) const {
    std::vector<std::int64_t> times;
    for (const auto& one : node.received) {
      if (one.frame.identifier.value == identifier) times.push_back(one.time / 1ms);
    }
    return times;
  }

  Bus bus;
  ScriptedNode node;
  SocketcandDoor door{"can0"};
};

TEST_F(SocketcandJobs, AJobSendsAtOnceAndInEachPeriod) {
  EXPECT_EQ(say("< add 0 20000 123 4 42 42 42 42 >"), "");
  run(70ms);
  EXPECT_THAT(times_of(0x123), ElementsAre(0, 20, 40, 60));
  EXPECT_EQ(node.received[0].frame, Frame::of(0x123, hex("42 42 42 42")));
  EXPECT_EQ(node.received[3].time - node.received[0].time, 60ms) << "to the nanosecond";
  EXPECT_EQ(say("< update 123 3 11 22 33 >"), "");
  run(20ms);
  EXPECT_EQ(node.received.back().frame, Frame::of(0x123, hex("11 22 33")));
  EXPECT_EQ(times_of(0x123).back(), 80) << "the timer is not touched";
  EXPECT_EQ(say("< delete 123 >"), "");
  run(1s);
  EXPECT_EQ(node.received.size(), 5U);
}

TEST_F(SocketcandJobs, EachIdentifierHasOneJob) {
  say("< add 1 0 123 1 01 >< add 1 0 00000123 1 02 >< add 0 500000 123 1 03 >");
  run(900ms);
  EXPECT_THAT(node.identifiers(), ElementsAre(0x123, 0x123, 0x123)) << "the base one twice, the extended one once";
  EXPECT_EQ(node.received[0].frame, Frame::of(canopen::Identifier{0x123, true}, hex("02"))) << "wins the arbitration";
  EXPECT_EQ(node.received[1].frame, Frame::of(0x123, hex("03")));
  EXPECT_EQ(node.received[2].time / 1ms, 500);
}

TEST_F(SocketcandJobs, PeriodsAndNumbersHaveLimits) {
  EXPECT_EQ(say("< add 0 0 123 0 >"), "< error the interval of a job is 0 >");
  EXPECT_EQ(say("< add 0 1000000001 123 0 >"), "< error syntax error in add command >");
  EXPECT_EQ(say("< add 0 20000 123 9 >"), "< error syntax error in add command >");
  EXPECT_EQ(say("< update 123 0 >"), "< error no job has this identifier >");
  EXPECT_EQ(say("< update 123 >"), "< error syntax error in update command >");
  EXPECT_EQ(say("< delete 123 >"), "< error no job has this identifier >");
  EXPECT_EQ(say("< delete 123 456 >"), "< error syntax error in delete command >");
  say("< add 0 10 123 0 >");
  run(10ms);
  EXPECT_EQ(times_of(0x123).size(), 100U) << "every 100 us at the most";
  EXPECT_EQ(say("< delete 123 >"), "");
  for (int i = 0; i < 64; ++i) EXPECT_EQ(say("< add 1 0 " + std::to_string(100 + i) + " 0 >"), "");
  EXPECT_EQ(say("< add 1 0 300 0 >"), "< error too many jobs >");
  EXPECT_EQ(say("< add 2 0 100 0 >"), "") << "one that is there";
}

TEST_F(SocketcandJobs, JobsEndWithTheirModeAndTheirClient) {
  say("< add 0 10000 123 0 >< rawmode >");
  run(100ms);
  EXPECT_THAT(times_of(0x123), IsEmpty());
  EXPECT_EQ(say("< add 0 10000 123 0 >"), "< error unknown command >");
  say("< bcmmode >< add 0 10000 123 0 >");
  run(1ms);
  door.leave();
  run(100ms);
  EXPECT_EQ(times_of(0x123).size(), 1U);
  EXPECT_EQ(door.next_wake(), kNever);
}

TEST_F(SocketcandJobs, SubscriptionsTellOfFrames) {
  node.send_at(1ms, Frame::of(0x123, hex("01")));
  EXPECT_EQ(run(2ms), "") << "none without a subscription";
  EXPECT_EQ(say("< subscribe 0 0 123 >"), "");
  node.send_at(3ms, Frame::of(0x123, hex("02")));
  node.send_at(3ms, Frame::of(0x124, hex("03")));
  node.send_at(3ms, Frame::remote({0x123, false}, 1));
  const auto text = run(5ms);
  EXPECT_TRUE(text.starts_with("< frame 123 0.00")) << text;
  EXPECT_TRUE(text.ends_with(" 02 >")) << text;
  EXPECT_EQ(say("< unsubscribe 123 >"), "");
  EXPECT_EQ(say("< unsubscribe 123 >"), "< error no subscription has this identifier >");
  node.send_at(bus.now(), Frame::of(0x123, hex("04")));
  EXPECT_EQ(run(5ms), "");
}

TEST_F(SocketcandJobs, AnIntervalPassesTheNewestFrame) {
  EXPECT_EQ(say("< subscribe 0 100000 123 >"), "");
  for (int i = 0; i < 25; ++i) node.send_at(i * 10ms, Frame::of(0x123, std::array{static_cast<std::byte>(i)}));
  EXPECT_THAT(run(50ms), HasSubstr(" 00 >"));
  const auto second = run(100ms);
  EXPECT_THAT(second, HasSubstr(" 0A >")) << "that of 100 ms";
  EXPECT_EQ(second.find('<'), second.rfind('<'));
  EXPECT_THAT(run(100ms), HasSubstr(" 14 >"));
  EXPECT_THAT(run(200ms), HasSubstr(" 18 >"));
  EXPECT_EQ(run(1s), "");
}

TEST_F(SocketcandJobs, AFilterPassesChanges) {
  EXPECT_EQ(say("< filter 0 0 123 2 FF 0F >"), "");
  const auto told = [this](std::string_view data) {
    node.send_at(bus.now(), Frame::of(0x123, hex(data)));
    return !run(1ms).empty();
  };
  EXPECT_TRUE(told("00 00 00")) << "the first one";
  EXPECT_FALSE(told("00 00 00"));
  EXPECT_FALSE(told("00 F0 77"));
  EXPECT_TRUE(told("00 01 77"));
  EXPECT_TRUE(told("80 01 77"));
  EXPECT_FALSE(told("80 01 78"));
  EXPECT_EQ(say("< filter 0 0 123 >"), "< error syntax error in filter command >");
  EXPECT_EQ(say("< subscribe 0 123 >"), "< error syntax error in subscribe command >");
}

TEST_F(SocketcandJobs, SubscriptionsAreCounted) {
  for (int i = 0; i < 64; ++i) EXPECT_EQ(say("< subscribe 0 0 " + std::to_string(100 + i) + " >"), "");
  EXPECT_EQ(say("< subscribe 0 0 300 >"), "< error too many subscriptions >");
}

TEST_F(SocketcandJobs, StatisticsInControlMode) {
  EXPECT_EQ(say("< statistics 1000 >"), "< error unknown command >");
  EXPECT_EQ(say("< send 123 2 1 2 >"), "");
  node.send_at(1ms, Frame::of(0x181, hex("01 02 03")));
  run(5ms);
  EXPECT_EQ(say("< controlmode >< statistics 1000 >"), "< ok >");
  EXPECT_EQ(say("< send 123 0 >"), "< error unknown command >");
  EXPECT_EQ(run(1005ms), "< stat 3 1 2 1 >");
  EXPECT_EQ(say("< rawmode >"), "< ok >");
  EXPECT_EQ(run(1s), "< stat 3 1 2 1 >") << "goes on in the other modes";
  say("< controlmode >");
  EXPECT_EQ(say("< statistics 0 >< statistics x >"), "< error syntax error in statistics command >");
  EXPECT_EQ(run(3s), "");
  say("< statistics 1 >");
  const auto text = run(100ms);
  EXPECT_EQ(text.size(), 10 * std::string_view("< stat 3 1 2 1 >").size()) << "every 10 ms at the most";
}

/// The client of python-can compares what it has read with "< ok >".
TEST_F(SocketcandJobs, TheAnswerToRawmodeIsAlone) {
  node.send_at(0ms, Frame::of(0x181, hex("01")));
  door.input("< rawmode >", bus.now());
  bus.advance(bus.now() + 49ms);
  EXPECT_EQ(take(), "< ok >");
  const auto text = run(2ms);
  EXPECT_TRUE(text.starts_with("< frame 181 0.0000")) << "with the time of its reception: " << text;
  EXPECT_EQ(door.statistics().received, 1U);
  say("< rawmode >");
  node.send_at(bus.now(), Frame::of(0x182, hex("02")));
  EXPECT_EQ(run(1ms), "");
  EXPECT_THAT(say("< echo >"), HasSubstr("< frame 182 ")) << "a client that sends has read the answer";
}

}  // namespace
}  // namespace driveline::slaves::can
