// Ethernet over EtherCAT of a device (ETG.1000.6 5.7). All messages are written and read as plain numbers.
#include "driveline/slaves/mailbox/eoe_server.hpp"

#include <deque>

#include "mailbox_rig.hpp"

namespace driveline::slaves {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Frames that the device's network has received, and frames to be sent.
class Network final : public EthernetLink {
 public:
  bool send(std::span<const std::byte> frame) noexcept override {
    if (full) return false;
    Bytes numbers;
    for (const auto byte : frame) numbers.push_back(std::to_integer<unsigned>(byte));
    taken.push_back(numbers);
    return true;
  }
  std::size_t receive(std::span<std::byte> out) noexcept override {
    if (frames.empty()) return 0;
    const Bytes frame = frames.front();
    frames.pop_front();
    for (std::size_t i = 0; i < frame.size(); ++i) out[i] = static_cast<std::byte>(frame[i]);
    return frame.size();
  }
  void set_address(const wire::EoeIpParameters& parameters) noexcept override { address = parameters; }
  void set_link(bool link) noexcept override { up = link; }

  bool full = false;
  bool up = false;
  wire::EoeIpParameters address;
  std::vector<Bytes> taken;
  std::deque<Bytes> frames;
};

/// A device with CoE and EoE behind mailboxes of `size` bytes, in PREOP.
struct EoeRig {
  explicit EoeRig(std::size_t size = 512) : bytes(size) {
    eoe.restart();
    eoe.connect(&network);
    eoe.enter(wire::AlState::kPreOp);
  }

  /// Writes a message of a type, with the next counter; false: the device has no room for it.
  bool write(unsigned type, const Bytes& data) {
    counter = counter % 7 + 1;
    return repeat(type, data);
  }
  bool repeat(unsigned type, const Bytes& data) {
    std::vector<std::byte> mail(bytes);
    const Bytes header = {static_cast<unsigned>(data.size() & 0xFF),
                          static_cast<unsigned>(data.size() >> 8),
                          0,
                          0,
                          0,
                          type | counter << 4};
    for (std::size_t i = 0; i < 6; ++i) mail[i] = static_cast<std::byte>(header[i]);
    for (std::size_t i = 0; i < data.size(); ++i) mail.at(6 + i) = static_cast<std::byte>(data[i]);
    if (!server.has_room(mail)) return false;
    server.request(mail);
    return true;
  }
  /// Type and service data of the next message of the device, in one list; empty: there is none.
  Bytes read() {
    std::vector<std::byte> out(bytes, std::byte{0xEE});
    const auto length = server.reply(out, wire::AlState::kPreOp);
    EXPECT_LE(length, bytes);
    if (length == 0) return {};
    EXPECT_EQ(length, 6 + std::to_integer<std::size_t>(out[0]) + 256 * std::to_integer<std::size_t>(out[1]));
    Bytes mail = {std::to_integer<unsigned>(out[5]) & 0x0FU};
    for (std::size_t i = 6; i < length; ++i) mail.push_back(std::to_integer<unsigned>(out[i]));
    return mail;
  }
  /// Sends an EoE request; returns the service data of the answer, which must be EoE.
  Bytes ask(const Bytes& data) {
    EXPECT_TRUE(write(2, data));
    auto answer = read();
    if (answer.empty()) return answer;
    EXPECT_EQ(answer.front(), 2U);
    answer.erase(answer.begin());
    return answer;
  }

  std::size_t bytes;
  unsigned counter = 0;
  MailboxRig inner{bytes};
  Network network;
  EoeServer eoe{factory_address(0x01020304)};
  MailboxServer server{std::array<MailboxProtocol*, 2>{&inner.coe_server, &eoe}, bytes};
};

/// An Ethernet frame to `receiver` with `length` bytes, counting up after the addresses.
Bytes frame_to(Bytes receiver, std::size_t length) {
  while (receiver.size() < length) receiver.push_back(static_cast<unsigned>(receiver.size()) & 0xFFU);
  return receiver;
}

Bytes joined(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

const Bytes kToDevice = {0x02, 0xE0, 0x01, 0x02, 0x03, 0x04};
const Bytes kBroadcast = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
const Bytes kUploadByte = {0x00, 0x20, 0x40, 0x00, 0x20, 0x00, 0, 0, 0, 0};

/// A frame that fits into one message: first and last fragment of frame 1, size in blocks.
Bytes whole(const Bytes& frame, unsigned flags = 1) {
  const auto blocks = static_cast<unsigned>((frame.size() + 31) / 32);
  return joined({0x00, flags, (blocks & 3U) << 6, 0x10U | blocks >> 2}, frame);
}

TEST(EoeServer, PutsFramesTogetherWithoutAnAnswer) {
  EoeRig rig(48);  // 38 bytes behind the EoE header, 32 of them in a fragment
  const auto frame = frame_to(kToDevice, 60);
  // Fragment 0 of frame 1, 2 blocks in all; fragment 1 at block 1, last.
  EXPECT_TRUE(rig.write(2, joined({0x00, 0x00, 0x80, 0x10}, Bytes(frame.begin(), frame.begin() + 32))));
  EXPECT_THAT(rig.network.taken, IsEmpty());
  EXPECT_TRUE(rig.write(2, joined({0x00, 0x01, 0x41, 0x10}, Bytes(frame.begin() + 32, frame.end()))));
  EXPECT_THAT(rig.network.taken, ElementsAre(frame));
  EXPECT_THAT(rig.read(), IsEmpty());
  EXPECT_EQ(rig.eoe.counters().to_network, 1U);
}

TEST(EoeServer, CutsFramesOfTheNetworkIntoMails) {
  EoeRig rig(48);
  const auto frame = frame_to(kBroadcast, 75);
  rig.network.frames = {frame};
  // 75 bytes are 3 blocks: 0x00C0 and frame 1; then at block 1, and 11 bytes at block 2.
  EXPECT_EQ(rig.read(), joined({2, 0x00, 0x00, 0xC0, 0x10}, Bytes(frame.begin(), frame.begin() + 32)));
  EXPECT_EQ(rig.read(), joined({2, 0x00, 0x00, 0x41, 0x10}, Bytes(frame.begin() + 32, frame.begin() + 64)));
  EXPECT_EQ(rig.read(), joined({2, 0x00, 0x01, 0x82, 0x10}, Bytes(frame.begin() + 64, frame.end())));
  EXPECT_THAT(rig.read(), IsEmpty());
  EXPECT_EQ(rig.eoe.counters().to_master, 1U);
}

TEST(EoeServer, AMailThatIsRepeatedCountsOnce) {
  EoeRig rig;
  const auto frame = frame_to(kToDevice, 60);
  EXPECT_TRUE(rig.write(2, whole(frame)));
  EXPECT_TRUE(rig.repeat(2, whole(frame)));
  EXPECT_THAT(rig.network.taken, ElementsAre(frame));
  EXPECT_EQ(rig.server.repeated(), 1U);
}

TEST(EoeServer, BeginsWithTheFactoryAddress) {
  EoeRig rig;
  // Get IP: flags MAC, IP, mask; addresses of IP are little-endian numbers.
  auto answer = rig.ask({0x06, 0x01, 0, 0});
  ASSERT_EQ(answer.size(), 62U);
  EXPECT_THAT(Bytes(answer.begin(), answer.begin() + 26),
              ElementsAre(0x07, 0x01, 0, 0, 0x07, 0, 0, 0, 0x02, 0xE0, 1, 2, 3, 4, 5, 39, 168, 192, 0, 255, 255, 255, 0,
                          0, 0, 0));
  EXPECT_EQ(rig.network.address, rig.eoe.address());
}

/// MAC, IP 192.168.38.5, mask /24, gateway .1, DNS .2, name "drive", each at its fixed offset.
Bytes all_parameters() {
  Bytes data = {0x02, 0x01, 0,   0,   0x3F, 0,  0,   0,   0x02, 0,  0,   0,   0,   0x55, 5,   38,  168, 192,
                0,    255,  255, 255, 1,    38, 168, 192, 2,    38, 168, 192, 'd', 'r',  'i', 'v', 'e'};
  data.resize(62);
  return data;
}

TEST(EoeServer, TakesAndReturnsEveryIpParameter) {
  EoeRig rig;
  EXPECT_THAT(rig.ask(all_parameters()), ElementsAre(0x03, 0x01, 0, 0));
  auto expected = all_parameters();
  expected[0] = 0x07;
  EXPECT_EQ(rig.ask({0x06, 0x01, 0, 0}), expected);
  EXPECT_EQ(rig.network.address.ip, (wire::IpV4Address{192, 168, 38, 5}));
  EXPECT_EQ(rig.network.address.gateway, (wire::IpV4Address{192, 168, 38, 1}));
}

TEST(EoeServer, TakesParametersThatFollowOneAnotherWithoutGaps) {
  EoeRig rig;
  // IP and mask alone: flags 6, and 8 bytes.
  EXPECT_THAT(rig.ask({0x02, 0x01, 0, 0, 0x06, 0, 0, 0, 7, 38, 168, 192, 0, 0, 255, 255}),
              ElementsAre(0x03, 0x01, 0, 0));
  EXPECT_EQ(rig.eoe.address().ip, (wire::IpV4Address{192, 168, 38, 7}));
  EXPECT_EQ(rig.eoe.address().subnet_mask, (wire::IpV4Address{255, 255, 0, 0}));
  EXPECT_EQ(rig.eoe.address().mac, factory_address(0x01020304).mac) << "not there: not changed";
}

TEST(EoeServer, TheSameParametersAtTheirPlaces) {
  EoeRig rig;
  Bytes data = {0x02, 0x01, 0, 0, 0x06, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7, 38, 168, 192, 0, 0, 255, 255};
  data.resize(62);
  EXPECT_THAT(rig.ask(data), ElementsAre(0x03, 0x01, 0, 0));
  EXPECT_EQ(rig.eoe.address().ip, (wire::IpV4Address{192, 168, 38, 7}));
  EXPECT_EQ(rig.eoe.address().subnet_mask, (wire::IpV4Address{255, 255, 0, 0}));
}

TEST(EoeServer, RefusesParametersThatCannotBe) {
  struct Case {
    const char* name;
    Bytes data;
  };
  const std::vector<Case> cases = {
      {"no flags", {}},
      {"shorter than its flags say", {0x06, 0, 0, 0, 7, 38, 168}},
      {"MAC address of a group", {0x01, 0, 0, 0, 0x01, 0, 0x5E, 0, 0, 1}},
      {"mask with a gap", {0x04, 0, 0, 0, 0, 255, 0, 255}},
  };
  for (const auto& c : cases) {
    EoeRig rig;
    EXPECT_THAT(rig.ask(joined({0x02, 0x01, 0, 0}, c.data)), ElementsAre(0x03, 0x01, 0x01, 0x00)) << c.name;
    EXPECT_EQ(rig.eoe.address(), factory_address(0x01020304)) << c.name;
  }
}

/// Addresses and masks of a filter; the counters in the first byte.
Bytes filter(unsigned options, const std::vector<Bytes>& addresses, const std::vector<Bytes>& masks) {
  Bytes data = {0x04, 0x01, 0, 0, options, 0};
  for (const auto& address : addresses) data = joined(data, address);
  data.resize(6 + 16 * 6);
  for (const auto& mask : masks) data = joined(data, mask);
  data.resize(6 + 20 * 6);
  return data;
}

TEST(EoeServer, LetsThroughWhatTheAddressFilterSays) {
  const Bytes neighbour = {0x02, 0, 0, 0, 0, 9};
  const Bytes group = {0x01, 0, 0x5E, 0, 0, 1};
  struct Case {
    const char* name;
    Bytes filter;
    std::vector<Bytes> pass;
    unsigned stopped;
  };
  const std::vector<Case> cases = {
      {"nothing said", filter(0x00, {}, {}), {kToDevice, neighbour, group, kBroadcast}, 0},
      {"no broadcasts", filter(0x80, {}, {}), {kToDevice, neighbour, group}, 1},
      {"one address", filter(0x01, {neighbour}, {}), {kToDevice, neighbour, kBroadcast}, 1},
      {"one mask", filter(0x10, {}, {{0x01, 0, 0x5E, 0, 0, 0}}), {kToDevice, group, kBroadcast}, 1},
      {"an address behind the count", filter(0x81, {neighbour, group}, {}), {kToDevice, neighbour}, 2},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    EoeRig rig;
    EXPECT_THAT(rig.ask(c.filter), ElementsAre(0x05, 0x01, 0, 0));
    for (const auto& receiver : {kToDevice, neighbour, group, kBroadcast}) {
      EXPECT_TRUE(rig.write(2, whole(frame_to(receiver, 60))));
    }
    std::vector<Bytes> passed;
    for (const auto& frame : rig.network.taken) passed.emplace_back(frame.begin(), frame.begin() + 6);
    EXPECT_EQ(passed, c.pass);
    EXPECT_EQ(rig.eoe.counters().filtered, c.stopped);
  }
}

TEST(EoeServer, ReturnsTheAddressFilter) {
  EoeRig rig;
  auto expected = filter(0x92, {kToDevice, kBroadcast}, {{0x01, 0, 0x5E, 0, 0, 0}});
  EXPECT_THAT(rig.ask(expected), ElementsAre(0x05, 0x01, 0, 0));
  expected[0] = 0x09;
  EXPECT_EQ(rig.ask({0x08, 0x01, 0, 0}), expected);
  auto part = filter(0, {}, {});
  part.resize(100);
  EXPECT_THAT(rig.ask(part), ElementsAre(0x05, 0x01, 0x01, 0x00)) << "too short: unspecified error";
  EXPECT_EQ(rig.ask({0x08, 0x01, 0, 0}), expected);
}

TEST(EoeServer, TellsWhenAFrameLeftThatAsksForIt) {
  EoeRig rig;
  rig.eoe.set_time(std::chrono::nanoseconds{0x1'0A0B'0C0D});
  rig.write(2, whole(frame_to(kToDevice, 60), 0x05));
  // Type 1, last fragment and time appended, the frame's own word, 32 bits of the time.
  EXPECT_THAT(rig.read(), ElementsAre(2, 0x01, 0x03, 0x80, 0x10, 0x0D, 0x0C, 0x0B, 0x0A));
  EXPECT_THAT(rig.read(), IsEmpty());
  rig.write(2, whole(frame_to(kToDevice, 60), 0x05));
  rig.write(2, whole(frame_to(kToDevice, 60), 0x05));
  EXPECT_EQ(rig.eoe.counters().stamps_missed, 1U);
}

TEST(EoeServer, AnswersWhatItDoesNotKnowWithUnsupportedFrameType) {
  EoeRig rig;
  EXPECT_THAT(rig.ask({0x0A, 0x01, 0, 0}), ElementsAre(0x0B, 0x01, 0x02, 0x00));
  EXPECT_THAT(rig.ask({0x3E, 0x01, 0, 0}), ElementsAre(0x3F, 0x01, 0x02, 0x00)) << "with its port";
  for (unsigned response = 1; response <= 9; response += 2) {
    EXPECT_THAT(rig.ask({response, 0x01, 0, 0, 0, 0, 0, 0}), IsEmpty()) << response;
  }
}

TEST(EoeServer, MalformedMailsAreErrorsAndMalformedFragmentsAreCounted) {
  EoeRig rig;
  EXPECT_TRUE(rig.write(2, {0x02, 0x01, 0}));
  EXPECT_THAT(rig.read(), ElementsAre(0, 1, 0, 6, 0)) << "mailbox error: too short";
  rig.write(2, {0x00, 0x01, 0x00, 0x10});                     // no size
  rig.write(2, joined({0x00, 0x00, 0xC0, 0x1F}, Bytes(32)));  // 63 blocks
  rig.write(2, whole(Bytes(10)));                             // shorter than an Ethernet header
  rig.write(2, {0x00, 0x01, 0x41, 0x10, 1});                  // without a first fragment
  EXPECT_EQ(rig.eoe.assembly().malformed, 3U);
  EXPECT_EQ(rig.eoe.assembly().stray, 1U);
  EXPECT_THAT(rig.network.taken, IsEmpty());
  EXPECT_THAT(rig.read(), IsEmpty());
}

TEST(EoeServer, SmallMailboxesAreToldWhatDoesNotFit) {
  EoeRig rig(48);
  EXPECT_TRUE(rig.write(2, {0x06, 0x01, 0, 0}));
  EXPECT_THAT(rig.read(), ElementsAre(0, 1, 0, 7, 0)) << "no more memory";
  EXPECT_TRUE(rig.write(2, {0x08, 0x01, 0, 0}));
  EXPECT_THAT(rig.read(), ElementsAre(0, 1, 0, 7, 0));
}

TEST(EoeServer, AFullNetworkCostsTheFrameAlone) {
  EoeRig rig;
  rig.network.full = true;
  EXPECT_TRUE(rig.write(2, whole(frame_to(kToDevice, 60))));
  EXPECT_EQ(rig.eoe.counters().dropped, 1U);
  rig.network.full = false;
  EXPECT_TRUE(rig.write(2, whole(frame_to(kToDevice, 60))));
  EXPECT_EQ(rig.eoe.counters().to_network, 1U);
  rig.eoe.connect(nullptr);
  EXPECT_TRUE(rig.write(2, whole(frame_to(kToDevice, 60))));
  EXPECT_EQ(rig.eoe.counters().dropped, 2U);
  EXPECT_THAT(rig.read(), IsEmpty());
}

TEST(EoeMailbox, FragmentsPassTheQueueAndWhatHasNoRoomIsTold) {
  EoeRig rig;
  for (std::size_t i = 0; i < MailboxServer::kQueueDepth; ++i) EXPECT_TRUE(rig.write(3, kUploadByte));
  const auto kept = rig.counter;
  EXPECT_FALSE(rig.write(3, kUploadByte)) << "it stays where it is";
  rig.counter = kept;
  EXPECT_TRUE(rig.repeat(3, kUploadByte)) << "a repetition needs no room";
  EXPECT_TRUE(rig.write(2, whole(frame_to(kToDevice, 60))));
  EXPECT_EQ(rig.network.taken.size(), 1U);
  EXPECT_FALSE(rig.write(2, {0x06, 0x01, 0, 0})) << "a service of EoE with an answer waits, too";
  for (std::size_t i = 0; i < MailboxServer::kQueueDepth; ++i) EXPECT_EQ(rig.read().at(0), 3U);
  EXPECT_EQ(rig.server.dropped(), 0U);
}

TEST(EoeMailbox, FramesAndAnswersTakeTurns) {
  EoeRig rig(48);
  for (int i = 0; i < 10; ++i) rig.network.frames.push_back(frame_to(kBroadcast, 75));
  EXPECT_EQ(rig.read().at(0), 2U);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(rig.write(3, kUploadByte));
  rig.inner.coe_server.raise({.error_code = 0xFF00});
  std::vector<unsigned> types;
  for (int i = 0; i < 8; ++i) types.push_back(rig.read().at(0));
  EXPECT_THAT(types, ElementsAre(3, 2, 3, 2, 3, 2, 3, 2));
}

TEST(EoeMailbox, AnAnswerOfEoeIsNoLaterThanOneFragment) {
  EoeRig rig;
  for (int i = 0; i < 10; ++i) rig.network.frames.push_back(frame_to(kBroadcast, 1514));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(rig.read().at(1), 0x00U);
  EXPECT_TRUE(rig.write(2, {0x06, 0x01, 0, 0}));
  const auto first = rig.read().at(1);
  const auto second = rig.read().at(1);
  EXPECT_TRUE(first == 0x07 || second == 0x07) << first << ' ' << second;
}

TEST(EoeMailbox, InInitTheLinkIsDownAndNothingIsLeftBehind) {
  EoeRig rig(48);
  EXPECT_TRUE(rig.network.up);
  const auto frame = frame_to(kToDevice, 60);
  rig.write(2, joined({0x00, 0x00, 0x80, 0x10}, Bytes(frame.begin(), frame.begin() + 32)));
  rig.network.frames = {frame_to(kBroadcast, 75)};
  EXPECT_EQ(rig.read().size(), 37U);
  rig.server.reset();
  EXPECT_FALSE(rig.network.up);
  EXPECT_THAT(rig.read(), IsEmpty());
  rig.eoe.enter(wire::AlState::kPreOp);
  EXPECT_TRUE(rig.network.up);
  EXPECT_THAT(rig.read(), IsEmpty()) << "the rest of a frame that was under way";
  rig.write(2, joined({0x00, 0x01, 0x41, 0x10}, Bytes(frame.begin() + 32, frame.end())));
  EXPECT_EQ(rig.eoe.assembly().stray, 1U);
  EXPECT_THAT(rig.network.taken, IsEmpty());
}

TEST(EoeMailbox, AddressAndFilterStayUntilTheDeviceIsSwitchedOff) {
  EoeRig rig;
  EXPECT_THAT(rig.ask(all_parameters()), ElementsAre(0x03, 0x01, 0, 0));
  EXPECT_THAT(rig.ask(filter(0x80, {}, {})), ElementsAre(0x05, 0x01, 0, 0));
  rig.server.reset();
  rig.eoe.enter(wire::AlState::kPreOp);
  EXPECT_EQ(rig.network.address.ip, (wire::IpV4Address{192, 168, 38, 5}));
  EXPECT_EQ(rig.ask({0x08, 0x01, 0, 0}).at(4), 0x80U);
  rig.eoe.restart();
  rig.eoe.enter(wire::AlState::kPreOp);
  EXPECT_EQ(rig.network.address, factory_address(0x01020304));
  EXPECT_EQ(rig.ask({0x08, 0x01, 0, 0}).at(4), 0U);
}

}  // namespace
}  // namespace driveline::slaves
