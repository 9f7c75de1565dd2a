// Mailboxes between the sync managers and the device, including repetition (ETG.1000.4 6.6.3).
#include "bench_slave.hpp"

namespace driveline::slaves::test {
namespace {

class MailboxTransportTest : public BenchSlave {
 protected:
  MailboxTransportTest() { go_to(AlState::kPreOp); }
  std::vector<std::byte> mail(unsigned first) {
    std::vector<std::byte> data(kMailboxLength);
    data[0] = static_cast<std::byte>(first);
    data.back() = std::byte{0x99};
    return data;
  }
  std::uint16_t send(unsigned first) { return write(kMailboxOutAddress, mail(first)); }
  Answer fetch() { return read(kMailboxInAddress, kMailboxLength); }
  unsigned fetched() {
    const auto answer = fetch();
    return answer.working_counter == 1 ? std::to_integer<unsigned>(answer.data[0]) : 0xFFFF;
  }
  void toggle_repeat() {
    repeat_ = !repeat_;
    write(0x080E, bytes({repeat_ ? 3U : 1U}));
    slave().advance(now());
  }
  bool acknowledged() {
    const bool bit = (read(0x080F, 1).data[0] & std::byte{2}) != std::byte{0};
    return bit == repeat_;
  }

 private:
  bool repeat_ = false;
};

TEST_F(MailboxTransportTest, RequestReachesTheDeviceWhole) {
  EXPECT_EQ(send(5), 1);
  slave().advance(now());
  ASSERT_EQ(device().requests.size(), 1U);
  EXPECT_EQ(device().requests[0], mail(5));
  EXPECT_EQ(send(6), 1);
}

TEST_F(MailboxTransportTest, ReplyIsPaddedToTheMailbox) {
  device().replies.push_back(bytes({1, 2, 3}));
  send(5);
  slave().advance(now());
  const auto answer = fetch();
  EXPECT_EQ(answer.working_counter, 1);
  std::vector<std::byte> expected(kMailboxLength);
  std::copy_n(bytes({1, 2, 3}).begin(), 3, expected.begin());
  EXPECT_EQ(answer.data, expected);
  EXPECT_EQ(fetch().working_counter, 0);
}

TEST_F(MailboxTransportTest, WhatTheDeviceHasNoRoomForStaysInTheSyncManager) {
  device().mailbox_full = true;
  EXPECT_EQ(send(5), 1);
  pass(1ms);
  EXPECT_TRUE(device().requests.empty());
  EXPECT_EQ(send(6), 0) << "full";
  device().mailbox_full = false;
  slave().advance(now());
  pass(125us);
  ASSERT_EQ(device().requests.size(), 1U);
  EXPECT_EQ(device().requests[0], mail(5));
  EXPECT_EQ(send(6), 1);
}

TEST_F(MailboxTransportTest, SpontaneousMailComesWithTheNextStep) {
  device().replies.push_back(bytes({1}));
  EXPECT_EQ(fetch().working_counter, 0);
  pass(125us);
  EXPECT_EQ(fetched(), 1U);
}

TEST_F(MailboxTransportTest, RepliesQueueUpInTheDevice) {
  for (unsigned i = 1; i <= 3; ++i) device().replies.push_back(bytes({i}));
  pass(1ms);
  for (unsigned i = 1; i <= 3; ++i) {
    EXPECT_EQ(fetched(), i);
    slave().advance(now());
  }
  EXPECT_EQ(fetch().working_counter, 0);
}

TEST_F(MailboxTransportTest, LostReplyIsSentAgain) {
  device().replies.push_back(bytes({1}));
  pass(1ms);
  EXPECT_EQ(fetched(), 1U);
  slave().advance(now());
  toggle_repeat();
  EXPECT_TRUE(acknowledged());
  EXPECT_EQ(fetched(), 1U);
}

TEST_F(MailboxTransportTest, RepetitionDisplacesANewerReplyThatFollowsAfterwards) {
  device().replies.push_back(bytes({1}));
  pass(1ms);
  EXPECT_EQ(fetched(), 1U);  // but the frame is lost on its way back
  device().replies.push_back(bytes({2}));
  pass(1ms);
  toggle_repeat();
  EXPECT_TRUE(acknowledged());
  EXPECT_EQ(fetched(), 1U);
  slave().advance(now());
  EXPECT_EQ(fetched(), 2U);
  device().replies.push_back(bytes({3}));
  pass(1ms);
  EXPECT_EQ(fetched(), 3U);
}

TEST_F(MailboxTransportTest, RepeatRequestWithoutAnythingSentIsAcknowledged) {
  toggle_repeat();
  EXPECT_TRUE(acknowledged());
  EXPECT_EQ(fetch().working_counter, 0);
  toggle_repeat();
  EXPECT_TRUE(acknowledged());
}

TEST_F(MailboxTransportTest, NothingIsServedInInit) {
  device().replies.push_back(bytes({1}));
  request(AlState::kInit);
  EXPECT_EQ(send(5), 0);
  pass(1ms);
  EXPECT_EQ(fetch().working_counter, 0);
  EXPECT_TRUE(device().requests.empty());
}

TEST_F(MailboxTransportTest, MailIsForgottenInInit) {
  device().replies.push_back(bytes({1}));
  pass(1ms);
  request(AlState::kInit);
  request(AlState::kPreOp);
  EXPECT_EQ(fetch().working_counter, 0);
  toggle_repeat();
  EXPECT_EQ(fetch().working_counter, 0);
}

TEST_F(MailboxTransportTest, SilentSlaveTakesRequestsAndNeverAnswers) {
  slave().mailbox().set_fault(MailboxTransport::Fault::kSilent);
  device().replies.push_back(bytes({1}));
  EXPECT_EQ(send(5), 1);
  pass(1s);
  EXPECT_EQ(send(6), 1);
  EXPECT_EQ(fetch().working_counter, 0);
}

TEST_F(MailboxTransportTest, BusySlaveLeavesTheMailboxFull) {
  slave().mailbox().set_fault(MailboxTransport::Fault::kBusy);
  EXPECT_EQ(send(5), 1);
  pass(1s);
  EXPECT_EQ(send(6), 0);
  slave().mailbox().set_fault(MailboxTransport::Fault::kNone);
  pass(125us);
  EXPECT_EQ(send(6), 1);
  ASSERT_EQ(device().requests.size(), 1U);
}

TEST_F(MailboxTransportTest, SpoiltRepliesHaveAnotherLengthInTheirHeader) {
  const std::pair<MailboxTransport::Fault, std::vector<std::byte>> faults[] = {
      {MailboxTransport::Fault::kMalformed, bytes({3, 0})}, {MailboxTransport::Fault::kOversized, bytes({0xFF, 0xFF})}};
  for (const auto& [fault, length] : faults) {
    slave().mailbox().set_fault(fault);
    device().replies.push_back(bytes({4, 0, 0, 0, 0, 0x13, 9, 9, 9, 9}));
    pass(1ms);
    const auto data = fetch().data;
    EXPECT_EQ(std::vector<std::byte>(data.begin(), data.begin() + 2), length);
    EXPECT_EQ(data[5], std::byte{0x13}) << "the counter stays";
  }
}

TEST_F(MailboxTransportTest, LateRepliesKeepTheirOrder) {
  slave().mailbox().set_fault(MailboxTransport::Fault::kLate, 10ms);
  device().replies = {bytes({1}), bytes({2})};
  pass(1ms);
  pass(9ms);
  EXPECT_EQ(fetched(), 0xFFFFU);
  pass(2ms);
  EXPECT_EQ(fetched(), 1U);
  pass(5ms);
  EXPECT_EQ(fetched(), 0xFFFFU);
  slave().mailbox().set_fault(MailboxTransport::Fault::kNone);
  pass(1ms);
  EXPECT_EQ(fetched(), 2U);
}

TEST_F(MailboxTransportTest, AForeignMailComesAheadOfEachReplyAndNoneIsLostByRepetition) {
  slave().mailbox().set_fault(MailboxTransport::Fault::kForeign);
  device().replies = {bytes({1, 0, 0, 0, 0, 0x13, 7}), bytes({1, 0, 0, 0, 0, 0x23, 8})};
  std::vector<unsigned> types;
  for (int i = 0; i < 5; ++i) {
    pass(1ms);
    // The last read message is repeated, followed by the one that was in the mailbox.
    if (i == 2) toggle_repeat();
    const auto answer = fetch();
    types.push_back(answer.working_counter == 1 ? std::to_integer<unsigned>(answer.data[5]) : 0xFFU);
  }
  EXPECT_EQ(types, (std::vector<unsigned>{9, 0x13, 0x13, 9, 0x23}));
}

TEST_F(MailboxTransportTest, ReplyLongerThanTheMailboxIsCut) {
  device().replies.push_back(std::vector<std::byte>(kMailboxLength + 10, std::byte{7}));
  pass(1ms);
  EXPECT_EQ(fetch().data, std::vector<std::byte>(kMailboxLength, std::byte{7}));
}

}  // namespace
}  // namespace driveline::slaves::test
