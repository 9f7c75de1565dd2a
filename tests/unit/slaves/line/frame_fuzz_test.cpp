// Whatever arrives on the wire, the line neither crashes nor reads or writes out of bounds (checked by sanitizers), nor
// does a reply change its length. Fixed seeds; the fuzzers do the open-ended search.
#include "random.hpp"
#include "test_line.hpp"

namespace driveline::slaves::test {
namespace {

using wire::DatagramAddress;

class FrameFuzzTest : public LineTest {
 protected:
  /// Frames of an ordinary start-up, as seeds for mutation.
  std::vector<std::vector<std::byte>> seeds() {
    std::vector<std::vector<std::byte>> result;
    const auto add = [&](Command command, std::uint16_t adp, std::uint16_t ado, const std::vector<std::byte>& data) {
      result.push_back(make_frame(command, DatagramAddress::physical(adp, ado), data));
    };
    const auto channel = [](const wire::SyncManagerChannel& c) {
      std::vector<std::byte> raw(8);
      c.encode(std::span(raw).first<8>());
      return raw;
    };
    add(Command::kBwr, 0, 0x0800, channel({kMailboxOutAddress, kMailboxLength, 0x26, 0, 1, 0}));
    add(Command::kBwr, 0, 0x0808, channel({kMailboxInAddress, kMailboxLength, 0x22, 0, 1, 0}));
    add(Command::kBwr, 0, 0x0120, bytes({2, 0}));
    add(Command::kBwr, 0, 0x0810, channel({kOutputsAddress, 4, 0x64, 0, 1, 0}));
    add(Command::kBwr, 0, 0x0818, channel({kInputsAddress, 6, 0x20, 0, 1, 0}));
    for (const unsigned type : {2U, 1U}) {
      std::vector<std::byte> raw(16);
      wire::FmmuEntity{
          0x10000, 4, 0, 7, type == 2 ? kOutputsAddress : kInputsAddress, 0, static_cast<std::uint8_t>(type), true}
          .encode(std::span(raw).first<16>());
      add(Command::kBwr, 0, static_cast<std::uint16_t>(0x0620 - 0x10 * type), raw);
    }
    add(Command::kBwr, 0, 0x0120, bytes({4, 0}));
    add(Command::kLrw, 0, 1, std::vector<std::byte>(40));
    add(Command::kBwr, 0, 0x0120, bytes({8, 0}));
    add(Command::kBwr, 0, kMailboxOutAddress, std::vector<std::byte>(kMailboxLength));
    add(Command::kAprd, 0, kMailboxInAddress, std::vector<std::byte>(kMailboxLength));
    add(Command::kBwr, 0, 0x0502, bytes({0x00, 0x01, 8, 0, 0, 0}));
    add(Command::kArmw, 0, 0x0910, std::vector<std::byte>(8));
    add(Command::kBwr, 0, 0x0900, std::vector<std::byte>(4));
    add(Command::kBrw, 0, 0, std::vector<std::byte>(1400));
    return result;
  }

  void send(std::vector<std::byte> frame) {
    const auto length = frame.size();
    if (line().send(frame) == port::SendStatus::kSent) {
      clock().advance(50us);
      while (const auto received = line().receive()) EXPECT_EQ(received->bytes.size(), length);
    }
    line().process(frame, clock().now());
  }
};

TEST_F(FrameFuzzTest, MutatedStartUpTraffic) {
  build(3);
  const auto originals = seeds();
  Random random(7);
  for (int round = 0; round < 60'000; ++round) {
    auto frame = originals[random() % originals.size()];
    const unsigned changes = random() % 6;
    for (unsigned i = 0; i < changes; ++i) {
      // Mostly in the headers, which are most sensitive.
      const std::size_t at =
          random() % 4 != 0 ? random() % std::min<std::size_t>(frame.size(), 40) : random() % frame.size();
      frame[at] =
          random() % 2 == 0 ? static_cast<std::byte>(random()) : frame[at] ^ static_cast<std::byte>(1U << random() % 8);
    }
    if (random() % 16 == 0) frame.resize(random() % (frame.size() + 1));
    if (random() % 16 == 0) frame.resize(std::min<std::size_t>(frame.size() + random() % 200, port::kMaxFrameBytes));
    send(std::move(frame));
    if (random() % 64 == 0) clock().advance(std::chrono::microseconds(random() % 200'000));
    if (round % 5000 == 0) build(1 + random() % 4);
  }
}

TEST_F(FrameFuzzTest, RandomBytesBehindAnEtherCatType) {
  build(2);
  Random random(11);
  for (int round = 0; round < 20'000; ++round) {
    std::vector<std::byte> frame(random() % (port::kMaxFrameBytes + 1));
    for (auto& byte : frame) byte = static_cast<std::byte>(random());
    if (frame.size() > 16) {
      frame[12] = std::byte{0x88};
      frame[13] = std::byte{0xA4};
      if (random() % 4 != 0) frame[15] = (frame[15] & std::byte{0x07}) | std::byte{0x10};
      if (random() % 2 == 0) frame[16] = static_cast<std::byte>(random() % 16);
    }
    send(std::move(frame));
  }
}

TEST_F(FrameFuzzTest, RandomDatagramsOnTheWholeMemory) {
  build(3);
  Random random(13);
  for (int round = 0; round < 60'000; ++round) {
    const auto command = static_cast<Command>(random() % 15);
    const auto raw = static_cast<std::uint32_t>(random());
    const auto address = wire::is_logical(command)
                             ? DatagramAddress::logical(random() % 3 == 0 ? raw : raw % 0x20000)
                             : DatagramAddress::physical(static_cast<std::uint16_t>(raw % 3 == 0 ? 0 : raw),
                                                         static_cast<std::uint16_t>(random() % 0x3100));
    std::vector<std::byte> data(random() % 8 == 0 ? random() % 1487 : random() % 20);
    for (auto& byte : data) byte = random() % 2 == 0 ? std::byte{0} : static_cast<std::byte>(random());
    send(make_frame(command, address, data));
  }
}

}  // namespace
}  // namespace driveline::slaves::test
