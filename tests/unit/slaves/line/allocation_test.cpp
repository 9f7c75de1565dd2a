// In operation frames allocate nothing: neither process data nor mailboxes nor polls nor the slaves' firmware.
#include "driveline/rt_guard/rt_guard.hpp"
#include "test_line.hpp"

namespace driveline::slaves::test {
namespace {

using wire::DatagramAddress;

class AllocationTest : public LineTest {
 protected:
  void send_once(const std::vector<std::byte>& frame) {
    ASSERT_EQ(line().send(frame), port::SendStatus::kSent);
    clock().advance(125us);
    ASSERT_TRUE(line().receive());
  }
};

TEST_F(AllocationTest, NoneInTheCycle) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  build(8);
  const auto channel = [](const wire::SyncManagerChannel& c) {
    std::vector<std::byte> raw(wire::SyncManagerChannel::kSize);
    c.encode(std::span(raw).first<wire::SyncManagerChannel::kSize>());
    return raw;
  };
  const auto write_all = [&](std::uint16_t address, const std::vector<std::byte>& data) {
    const auto reply = exchange(Command::kBwr, DatagramAddress::physical(0, address), data);
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->working_counter, 8);
    clock().advance(1ms);
  };
  write_all(0x0800, channel({kMailboxOutAddress, kMailboxLength, 0x26, 0, 1, 0}));
  write_all(0x0808, channel({kMailboxInAddress, kMailboxLength, 0x22, 0, 1, 0}));
  write_all(0x0120, bytes({2, 0}));
  write_all(0x0810, channel({kOutputsAddress, 4, 0x64, 0, 1, 0}));
  write_all(0x0818, channel({kInputsAddress, 6, 0x20, 0, 1, 0}));
  std::vector<std::byte> fmmu(wire::FmmuEntity::kSize);
  for (std::uint16_t i = 0; i < 8; ++i) {
    wire::FmmuEntity{0x100U + 10U * i, 4, 0, 7, kOutputsAddress, 0, wire::FmmuEntity::kTypeWrite, true}.encode(
        std::span(fmmu).first<16>());
    exchange(Command::kApwr, DatagramAddress::position(i, 0x0600), fmmu);
    wire::FmmuEntity{0x104U + 10U * i, 6, 0, 7, kInputsAddress, 0, wire::FmmuEntity::kTypeRead, true}.encode(
        std::span(fmmu).first<16>());
    exchange(Command::kApwr, DatagramAddress::position(i, 0x0610), fmmu);
  }
  write_all(0x0120, bytes({4, 0}));
  const auto lrw = make_frame(Command::kLrw, DatagramAddress::logical(0x100), std::vector<std::byte>(80));
  send_once(lrw);
  write_all(0x0120, bytes({8, 0}));
  send_once(lrw);
  ASSERT_EQ(line().slave(7).state(), AlState::kOp);
  const auto poll = make_frame(Command::kBrd, DatagramAddress::physical(0, 0x0130), bytes({0, 0}));
  const auto time = make_frame(Command::kArmw, DatagramAddress::position(0, 0x0910), bytes({0, 0, 0, 0}));
  // The consequences of an overrun: silence, watchdog, fall-back. The device of this test records them in a vector.
  for (std::size_t i = 0; i < 8; ++i) {
    device(i).fall_backs.reserve(4);
    device(i).echo = true;
  }
  const auto request = make_frame(Command::kBwr, DatagramAddress::physical(0, kMailboxOutAddress),
                                  std::vector<std::byte>(kMailboxLength, std::byte{5}));
  const auto reply = make_frame(Command::kBrd, DatagramAddress::physical(0, kMailboxInAddress),
                                std::vector<std::byte>(kMailboxLength));
  // The vectors that record outputs have reached their size.
  rt::RtGuard::enter();
  for (int cycle = 0; cycle < 10'000; ++cycle) {
    send_once(lrw);
    send_once(time);
    if (cycle % 16 == 0) send_once(poll);
    if (cycle % 32 == 0) send_once(request);
    if (cycle % 32 == 16) send_once(reply);
  }
  const auto written = line().slave(7).esc().sync_managers().write_count(0);
  const auto unanswered = device(7).echo_length;
  line().break_cable({3, 1});
  send_once(poll);
  line().break_cable({3, 1}, false);
  send_once(poll);
  clock().advance(1s);
  send_once(poll);
  EXPECT_EQ(rt::RtGuard::leave().total(), 0U);
  EXPECT_EQ(written, 313U);
  EXPECT_EQ(unanswered, 0U) << "the last mailbox was answered";
  EXPECT_EQ(line().slave(7).state(), AlState::kSafeOp) << "the silence was noticed";
}

}  // namespace
}  // namespace driveline::slaves::test
