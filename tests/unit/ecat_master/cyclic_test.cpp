#include <gmock/gmock.h>

#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"
#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/ecat_master/cyclic/cyclic_exchange.hpp"
#include "driveline/ecat_master/cyclic/cyclic_frame.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/trajectory/path.hpp"
#include "driveline/wire/wire_time.hpp"
#include "support/bytes.hpp"
#include "support/fake_port.hpp"

namespace driveline::ecat_master {
namespace {

using bytes_test::copy_of;
using bytes_test::hex;
using ecat_master_test::FakePort;
using std::chrono::microseconds;

class CyclicFrameTest : public testing::Test {
 protected:
  CyclicFrameTest() {
    ProcessDataDemand demand;
    demand.channels = {{true, 2, 0x1100, 4}, {false, 3, 0x1400, 4}};
    image = ProcessImage::lay_out({&demand, 1}).value();
    conditions.resize(1);
    const auto outputs = hex("11223344");
    std::copy(outputs.begin(), outputs.end(), image.outputs().begin());
    frame.emplace(image, 0);
    EXPECT_EQ(frame->send(port, image, {0, 7}), port::SendStatus::kSent);
    // One slave in OP has read and written.
    answer = port.sent.at(0);
    answer[6] = std::byte{0x02};
    answer[26] = std::byte{0x08};
    answer[28] = std::byte{1};
    const auto inputs = hex("A1A2A3A4");
    std::copy(inputs.begin(), inputs.end(), answer.begin() + 40);
    answer[44] = std::byte{3};
  }
  void expect_refused(const std::vector<std::byte>& bytes, FrameTag tag, const char* why) {
    EXPECT_FALSE(frame->accept(bytes, tag, image, conditions)) << why;
    EXPECT_FALSE(frame->received()) << why;
    EXPECT_EQ(copy_of(image.inputs()), hex("00000000")) << why;
  }

  rt::VirtualClock clock;
  FakePort port{clock};
  ProcessImage image;
  std::vector<SlaveCondition> conditions;
  std::optional<CyclicFrame> frame;
  std::vector<std::byte> answer;
};

TEST_F(CyclicFrameTest, IsLaidOutAsTheStandardSays) {
  // BRD index 0 of 0130h, 2 bytes, more to come; LRW index 1 of 00010000h, 4 bytes; padding to 60 bytes.
  auto expected =
      hex("FFFFFFFFFFFF 000007000000 88A4 1E10"
          "07 00 0000 3001 0280 0000 0000 0000"
          "0C 01 00000100 0400 0000 11223344 0000");
  expected.resize(60);
  EXPECT_EQ(port.sent.at(0), expected);
}

TEST_F(CyclicFrameTest, TakesItsAnswerOnce) {
  ASSERT_TRUE(frame->accept(answer, {0, 7}, image, conditions));
  EXPECT_TRUE(frame->valid());
  EXPECT_EQ(copy_of(image.inputs()), hex("A1A2A3A4"));
  ASSERT_TRUE(frame->al_status());
  EXPECT_TRUE(frame->al_status()->all_op(1));
  EXPECT_FALSE(frame->al_status()->all_op(2));
  EXPECT_FALSE(frame->accept(answer, {0, 7}, image, conditions)) << "a second time";
}

TEST_F(CyclicFrameTest, RefusesOtherAndDamagedFrames) {
  expect_refused(answer, {0, 6}, "the cycle before");
  expect_refused(answer, {1, 7}, "another master");
  auto damaged = [&](std::size_t at, std::byte value) {
    auto bytes = answer;
    bytes[at] = value;
    return bytes;
  };
  expect_refused(damaged(13, std::byte{0xA5}), {0, 7}, "EtherType");
  expect_refused(damaged(16, std::byte{8}), {0, 7}, "command of the first datagram");
  expect_refused(damaged(30, std::byte{11}), {0, 7}, "command of the second datagram");
  expect_refused(damaged(31, std::byte{2}), {0, 7}, "index");
  expect_refused(damaged(36, std::byte{5}), {0, 7}, "length");
  expect_refused({answer.begin(), answer.begin() + 59}, {0, 7}, "too short");
}

TEST_F(CyclicFrameTest, KeepsTheInputsWhenTheWorkingCounterIsWrong) {
  answer[44] = std::byte{2};
  ASSERT_TRUE(frame->accept(answer, {0, 7}, image, conditions));
  EXPECT_TRUE(frame->received());
  EXPECT_FALSE(frame->valid());
  EXPECT_EQ(frame->working_counter(), 2);
  EXPECT_EQ(copy_of(image.inputs()), hex("00000000"));
}

/// An unplanned slave, or a wrong FMMU, has put its own bytes into the image.
TEST_F(CyclicFrameTest, KeepsTheInputsWhenTheWorkingCounterIsTooHigh) {
  answer[44] = std::byte{4};
  ASSERT_TRUE(frame->accept(answer, {0, 7}, image, conditions));
  EXPECT_TRUE(frame->received());
  EXPECT_FALSE(frame->valid());
  EXPECT_FALSE(frame->results()[0].complete);
  EXPECT_FALSE(frame->results()[0].good);
  EXPECT_TRUE(frame->results()[0].disturbed);
  EXPECT_EQ(copy_of(image.inputs()), hex("00000000"));
}

TEST_F(CyclicFrameTest, ForgetsTheAnswerWithTheNextSend) {
  ASSERT_TRUE(frame->accept(answer, {0, 7}, image, conditions));
  ASSERT_EQ(frame->send(port, image, {0, 8}), port::SendStatus::kSent);
  EXPECT_FALSE(frame->received());
  EXPECT_FALSE(frame->valid());
  EXPECT_FALSE(frame->al_status());
  EXPECT_FALSE(frame->accept(answer, {0, 7}, image, conditions));
}

TEST_F(CyclicFrameTest, IsNotTakenForOneThatIsMoreThanASecondYounger) {
  // The datagram index of the standard repeats every 256 frames: these two have the same one, 1.28 s apart at 8 kHz.
  constexpr std::uint32_t kLater = 7 + 40 * 256;
  ASSERT_EQ(frame->send(port, image, {0, kLater}), port::SendStatus::kSent);
  EXPECT_FALSE(frame->accept(answer, FrameTag{0, 7}, image, conditions));
  EXPECT_FALSE(frame->received());
  EXPECT_TRUE(frame->accept(answer, FrameTag{0, kLater}, image, conditions)) << "its own answer has the same bytes";
}

/// Two slaves with AL status and mailbox status bytes in one LRW; processes answers and reports whether they were
/// steady.
class SteadyAnswers : public testing::Test {
 protected:
  SteadyAnswers() {
    ProcessDataDemand demand;
    demand.channels = {{true, 2, 0x1100, 4}, {false, 3, 0x1400, 4}};
    demand.al_status = true;
    demand.mailbox_status = 0x080D;
    image = ProcessImage::lay_out(std::vector{demand, demand}).value();
    inputs.resize(image.datagrams()[0].bytes);
    for (const auto& place : image.places()) inputs.at(place.al_status_offset) = std::byte{0x08};
    working_counter = static_cast<std::uint8_t>(image.datagrams()[0].expected_working_counter);
    frame.emplace(image, 0);
  }
  bool steady_after_answer() {
    const FrameTag tag{0, ++sequence};
    EXPECT_EQ(frame->send(port, image, tag), port::SendStatus::kSent);
    auto answer = port.sent.back();
    std::copy(inputs.begin(), inputs.end(), answer.begin() + 40);
    answer[40 + inputs.size()] = std::byte{working_counter};
    EXPECT_TRUE(frame->accept(answer, tag, image, conditions));
    return frame->steady();
  }

  rt::VirtualClock clock;
  FakePort port{clock};
  ProcessImage image;
  std::array<SlaveCondition, 2> conditions{};
  std::vector<std::byte> inputs;
  std::uint8_t working_counter = 0;
  std::uint32_t sequence = 100;
  std::optional<CyclicFrame> frame;
};

TEST_F(SteadyAnswers, AreThoseThatRepeatWhatTheLastOneSaidOfTheSlaves) {
  EXPECT_FALSE(steady_after_answer()) << "the first";
  EXPECT_TRUE(steady_after_answer());
  inputs.at(image.places()[1].input_offset) = std::byte{0x77};
  EXPECT_TRUE(steady_after_answer()) << "process data are not status";
  EXPECT_EQ(image.inputs()[image.places()[1].input_offset], std::byte{0x77});
  ASSERT_EQ(frame->send(port, image, {0, ++sequence}), port::SendStatus::kSent);
  EXPECT_FALSE(frame->steady()) << "nothing came back";
}

TEST_F(SteadyAnswers, EndWithAStatusByteOrAWorkingCounterThatDiffers) {
  static_cast<void>(steady_after_answer());
  ASSERT_TRUE(steady_after_answer());
  inputs.at(image.places()[1].al_status_offset) = std::byte{0x14};
  EXPECT_FALSE(steady_after_answer()) << "AL status";
  EXPECT_EQ(conditions[1].al_status, 0x14);
  EXPECT_TRUE(steady_after_answer());
  inputs.at(image.places()[0].mailbox_offset) = std::byte{0x08};
  EXPECT_FALSE(steady_after_answer()) << "mailbox";
  EXPECT_TRUE(steady_after_answer());
  --working_counter;
  EXPECT_FALSE(steady_after_answer()) << "somebody is missing";
  EXPECT_FALSE(steady_after_answer()) << "and still is";
  ++working_counter;
  EXPECT_FALSE(steady_after_answer()) << "back, but not so before";
  EXPECT_TRUE(steady_after_answer());
}

/// Result of the datagram for each working counter, as bits of good, disturbed and valid.
using CountersOfTwoSlaves = SteadyAnswers;

TEST_F(CountersOfTwoSlaves, AreGoodUpToWhatTheSlavesCanAddAndNoFurther) {
  struct Expected {
    std::uint8_t counter;
    bool good;
    bool disturbed;
  };
  ASSERT_EQ(working_counter, 6) << "each reads (1) and writes (2)";
  const auto expect = [&](const char* who, const std::vector<Expected>& all) {
    for (const auto& expected : all) {
      SCOPED_TRACE(testing::Message() << who << ", working counter " << int{expected.counter});
      working_counter = expected.counter;
      static_cast<void>(steady_after_answer());
      EXPECT_EQ(frame->results()[0].good, expected.good);
      EXPECT_EQ(frame->results()[0].disturbed, expected.disturbed);
      EXPECT_EQ(frame->valid(), !expected.disturbed);
    }
  };
  expect("both are there", {{5, false, true}, {6, true, false}, {7, false, true}, {255, false, true}});
  conditions[1].recovering = true;
  expect("one may answer or not",
         {{2, false, true}, {3, true, false}, {4, true, false}, {6, true, false}, {7, false, true}, {9, false, true}});
  conditions[1].recovering = false;
  inputs.at(image.places()[1].al_status_offset) = std::byte{0x14};
  expect("one has left OP by an error and may refuse outputs",
         {{3, false, true}, {4, true, false}, {6, true, false}, {7, false, true}});
  inputs.at(image.places()[1].al_status_offset) = std::byte{0x04};
  expect("its error is acknowledged", {{4, false, true}, {6, true, false}});
  inputs.at(image.places()[1].al_status_offset) = std::byte{0};
  // A steady answer of the remaining slave is accepted if it alone has added; the missing slave is an error all the
  // same.
  expect("one is gone", {{2, false, true}, {3, true, true}, {4, false, true}, {5, false, true}, {7, false, true}});
}

AcyclicJob job(std::uint64_t id) {
  AcyclicJob made;
  made.id = id;
  made.size = 60;
  return made;
}

/// The tag of the last frame that was sent.
std::uint32_t send_due(AcyclicChannel& channel, FakePort& port, std::uint32_t last) {
  return channel.send_due(port, {0, last}).sequence;
}

TEST(AcyclicChannel, HasSeveralFramesOnTheWireAndTakesTheirAnswersInAnyOrder) {
  rt::VirtualClock clock;
  FakePort port(clock);
  AcyclicChannel channel;
  EXPECT_FALSE(channel.in_flight());
  EXPECT_EQ(send_due(channel, port, 4), 4U) << "no number is used for nothing";
  for (const std::uint64_t id : {1U, 2U, 3U}) ASSERT_TRUE(channel.submit(job(id)));
  EXPECT_EQ(send_due(channel, port, 4), 7U);
  ASSERT_EQ(port.sent.size(), 3U);
  EXPECT_FALSE(channel.accept(port.sent[0], {0, 4})) << "another number";
  EXPECT_FALSE(channel.accept(port.sent[0], {1, 5})) << "another master";
  EXPECT_FALSE(channel.accept(std::span(port.sent[0]).first(59), {0, 5})) << "too short";
  EXPECT_TRUE(channel.accept(port.sent[2], {0, 7}));
  EXPECT_TRUE(channel.accept(port.sent[0], {0, 5}));
  EXPECT_FALSE(channel.accept(port.sent[0], {0, 5})) << "a second time";
  EXPECT_TRUE(channel.in_flight());
  AcyclicJob answer;
  for (const std::uint64_t id : {3U, 1U}) {
    ASSERT_TRUE(channel.take_answer(answer));
    EXPECT_EQ(answer.id, id);
    EXPECT_TRUE(answer.answered);
  }
  EXPECT_FALSE(channel.take_answer(answer));
  EXPECT_TRUE(channel.accept(port.sent[1], {0, 6}));
  EXPECT_FALSE(channel.in_flight());
}

TEST(AcyclicChannel, HasNoMoreFramesOnTheWireThanItsPlaces) {
  rt::VirtualClock clock;
  FakePort port(clock);
  AcyclicChannel channel;
  std::uint32_t last = 0;
  for (std::uint64_t id = 1; id <= AcyclicChannel::kMaxFrames; ++id) {
    ASSERT_TRUE(channel.submit(job(id)));
    last = send_due(channel, port, last);
  }
  ASSERT_EQ(port.sent.size(), AcyclicChannel::kMaxFrames);
  ASSERT_TRUE(channel.submit(job(100)));
  last = send_due(channel, port, last);
  EXPECT_EQ(port.sent.size(), AcyclicChannel::kMaxFrames);
  ASSERT_TRUE(channel.accept(port.sent[3], {0, 4}));
  EXPECT_EQ(send_due(channel, port, last), last + 1) << "a place has become free";
}

TEST(AcyclicChannel, GivesUpLostFramesOneByOneAfterTheirCycles) {
  rt::VirtualClock clock;
  FakePort port(clock);
  AcyclicChannel channel(3);
  ASSERT_TRUE(channel.submit(job(1)));
  auto last = send_due(channel, port, 4);
  channel.end_cycle();
  ASSERT_TRUE(channel.submit(job(2)));
  last = send_due(channel, port, last);
  AcyclicJob answer;
  channel.end_cycle();
  EXPECT_FALSE(channel.take_answer(answer));
  channel.end_cycle();
  ASSERT_TRUE(channel.take_answer(answer));
  EXPECT_EQ(answer.id, 1U);
  EXPECT_FALSE(answer.answered);
  EXPECT_FALSE(channel.take_answer(answer)) << "the other one has a cycle left";
  EXPECT_FALSE(channel.accept(port.sent[0], {0, 5})) << "too late";
  EXPECT_TRUE(channel.accept(port.sent[1], {0, 6}));
}

TEST(AcyclicChannel, SavesUpForAFrameLongerThanItsBudget) {
  rt::VirtualClock clock;
  FakePort port(clock);
  AcyclicChannel channel(AcyclicChannel::kLostAfterCycles, 100);
  auto large = job(1);
  large.size = 350;
  ASSERT_TRUE(channel.submit(large));
  std::uint32_t cycles = 0;
  for (; port.sent.empty() && cycles < 20; ++cycles) static_cast<void>(send_due(channel, port, 0));
  EXPECT_EQ(cycles, 4U);
  ASSERT_TRUE(channel.accept(port.sent[0], {0, 1}));
  // 50 bytes of credit are left: a frame within the budget is sent in the next cycle.
  ASSERT_TRUE(channel.submit(job(2)));
  EXPECT_EQ(send_due(channel, port, 1), 2U);
}

TEST(AcyclicChannel, SavesNothingForABurst) {
  rt::VirtualClock clock;
  FakePort port(clock);
  AcyclicChannel channel(AcyclicChannel::kLostAfterCycles, 2 * 60 + 24 + 59);
  for (int cycle = 0; cycle < 100; ++cycle) EXPECT_EQ(send_due(channel, port, 0), 0U);
  for (std::uint64_t id = 1; id <= 5; ++id) ASSERT_TRUE(channel.submit(job(id)));
  EXPECT_EQ(send_due(channel, port, 0), 2U) << "preamble and gap of the second one are within the budget";
}

TEST(AcyclicChannel, ALongCycleHasRoomForSeveralOfTheLongestFrames) {
  rt::VirtualClock clock;
  FakePort port(clock);
  AcyclicChannel channel(AcyclicChannel::kLostAfterCycles, 3 * port::kMaxFrameBytes + 2 * wire::kPreambleFcsGap);
  auto longest = job(1);
  longest.size = port::kMaxFrameBytes;
  for (; longest.id <= 5; ++longest.id) ASSERT_TRUE(channel.submit(longest));
  EXPECT_EQ(send_due(channel, port, 0), 3U);
  EXPECT_EQ(send_due(channel, port, 3), 5U) << "the budget of the next cycle";
}

TEST(CyclicExchange, PacksNoMoreThanTheBudgetIntoAFrame) {
  rt::VirtualClock clock;
  FakePort port(clock);
  AcyclicChannel channel(AcyclicChannel::kLostAfterCycles, 200);
  std::uint32_t sequence = 0;
  CyclicExchange exchange(channel, clock, [&](std::chrono::nanoseconds duration) {
    clock.advance(duration);
    const auto before = port.sent.size();
    sequence = send_due(channel, port, sequence);
    ASSERT_LE(port.sent.size(), before + 1) << "no second one fits into the cycle";
    if (port.sent.size() > before) {
      EXPECT_TRUE(channel.accept(ecat_master_test::answered(port.sent.back(), std::byte{1}), {0, sequence}));
    }
  });
  std::array<std::array<std::byte, 64>, 5> data{};
  std::vector<Request> requests;
  for (auto& bytes : data) {
    requests.push_back({wire::Command::kFprd, wire::DatagramAddress::physical(0x1001, 0x1000), bytes});
  }
  ASSERT_TRUE(exchange.exchange(requests));
  ASSERT_EQ(port.sent.size(), 3U) << "two datagrams of 76 bytes in a frame";
  for (const auto& frame : port.sent) EXPECT_LE(frame.size(), 200U);
}

TEST(CyclicExchange, SaysThatTheWayIsFull) {
  rt::VirtualClock clock;
  AcyclicChannel channel;
  while (channel.submit(job(1))) {
  }
  CyclicExchange exchange(channel, clock, [&](std::chrono::nanoseconds duration) { clock.advance(duration); });
  std::array<std::byte, 2> data{};
  Request request{wire::Command::kFprd, {}, data};
  EXPECT_TRUE(exchange.exchange({&request, 1}).error().is<facts::ExchangeFull>());
}

TEST(AcyclicChannel, RefusesMoreJobsThanItHolds) {
  AcyclicChannel channel;
  int taken = 0;
  while (channel.submit(job(1))) ++taken;
  EXPECT_EQ(taken, 8);
}

TEST(CyclicExchange, SkipsAnswersOfJobsThatWereGivenUp) {
  rt::VirtualClock clock;
  FakePort port(clock);
  // The channel waits longer than the exchange, so jobs are answered after they have been abandoned.
  AcyclicChannel channel(1'000'000);
  std::uint32_t sequence = 0;
  bool silent = true;
  std::size_t returned = 0;
  const CyclicExchange::Pass pass = [&](std::chrono::nanoseconds duration) {
    clock.advance(duration);
    sequence = send_due(channel, port, sequence);
    for (; !silent && returned < port.sent.size(); ++returned) {
      const auto answer = ecat_master_test::answered(port.sent[returned], static_cast<std::byte>(returned + 1));
      EXPECT_TRUE(channel.accept(answer, {0, static_cast<std::uint32_t>(returned + 1)}));
    }
  };
  CyclicExchange exchange(channel, clock, pass);
  std::array<std::byte, 1> data{};
  Request request{wire::Command::kFprd, wire::DatagramAddress::physical(0x1001, 0x0130), data};
  const auto failed = exchange.exchange({&request, 1});
  ASSERT_FALSE(failed);
  EXPECT_TRUE(failed.error().is<facts::NoAnswer>());
  ASSERT_EQ(port.sent.size(), 7U);
  silent = false;
  ASSERT_TRUE(exchange.exchange({&request, 1}));
  EXPECT_EQ(std::to_integer<std::size_t>(data[0]), port.sent.size()) << "not the answer to an earlier frame";
}

/// Three requests that need a frame each.
struct Batch {
  explicit Batch(AcyclicChannel& channel, rt::VirtualClock& clock, CyclicExchange::Pass pass)
      : exchange(channel, clock, std::move(pass)) {
    for (auto& bytes : data) {
      requests.push_back({wire::Command::kFprd, wire::DatagramAddress::physical(0x1001, 0x1000), bytes});
    }
  }
  std::array<std::array<std::byte, 1000>, 3> data{};
  std::vector<Request> requests;
  CyclicExchange exchange;
};

TEST(CyclicExchange, RepeatsOnlyTheFramesOfABatchThatWereLost) {
  rt::VirtualClock clock;
  FakePort port(clock);
  AcyclicChannel channel(2);
  std::uint32_t sequence = 0;
  std::vector<std::uint32_t> waiting;
  Batch batch(channel, clock, [&](std::chrono::nanoseconds duration) {
    clock.advance(duration);
    const auto before = sequence;
    sequence = send_due(channel, port, sequence);
    for (auto one = before + 1; one <= sequence; ++one) {
      // The second frame never comes back.
      if (one == 2) continue;
      EXPECT_TRUE(
          channel.accept(ecat_master_test::answered(port.sent[one - 1], static_cast<std::byte>(one)), {0, one}));
    }
    channel.end_cycle();
  });
  ASSERT_TRUE(batch.exchange.exchange(batch.requests));
  EXPECT_EQ(port.sent.size(), 4U);
  EXPECT_EQ(batch.data[0][0], std::byte{1});
  EXPECT_EQ(batch.data[1][0], std::byte{4});
  EXPECT_EQ(batch.data[2][0], std::byte{3});
}

TEST(CyclicExchange, RefusesARequestThatFitsNoFrame) {
  rt::VirtualClock clock;
  AcyclicChannel channel;
  CyclicExchange exchange(channel, clock, [&](std::chrono::nanoseconds duration) { clock.advance(duration); });
  std::vector<std::byte> data(1487);
  Request request{wire::Command::kFprd, {}, data};
  EXPECT_TRUE(exchange.exchange({&request, 1}).error().is<facts::ProcessDataSize>());
}

/// Outputs of the frame that was sent last.
std::vector<std::byte> outputs_sent(const FakePort& port) {
  const auto& frame = port.sent.back();
  return {frame.begin() + 40, frame.begin() + 44};
}

TEST_F(CyclicFrameTest, FramesThatWerePreparedAreSentAsTheyAre) {
  CyclicCore core(port, clock, std::move(image), nullptr, {}, CyclicCore::Settings{});
  const auto set_outputs = [&core](const char* bytes) {
    const auto outputs = hex(bytes);
    std::copy(outputs.begin(), outputs.end(), core.image().outputs().begin());
  };
  const auto run = [&core, this](std::int64_t cycle) { core.cycle({cycle, clock.now(), clock.now(), 0}); };
  set_outputs("0A0B0C0D");
  core.prepare();
  set_outputs("01020304");
  run(0);
  EXPECT_EQ(outputs_sent(port), hex("0A0B0C0D"));
  run(1);
  EXPECT_EQ(outputs_sent(port), hex("01020304")) << "each is sent once";
}

}  // namespace
}  // namespace driveline::ecat_master
