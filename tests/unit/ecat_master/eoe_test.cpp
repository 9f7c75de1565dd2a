#include <gmock/gmock.h>

#include <array>
#include <memory>
#include <utility>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/eoe/eoe_client.hpp"
#include "driveline/ecat_master/eoe/eoe_ports.hpp"
#include "driveline/ecat_master/foe/foe_client.hpp"
#include "support/bytes.hpp"
#include "support/mail_line.hpp"
#include "support/must.hpp"

namespace driveline::ecat_master {
namespace {

using bytes_test::hex;
using ecat_master_test::MailLine;
using std::chrono::milliseconds;
using testing::ElementsAre;
using Bytes = std::vector<std::byte>;

constexpr unsigned kEoe = 2;
constexpr unsigned kCoe = 3;

/// A frame in which neighbouring bytes differ.
Bytes frame_of(std::size_t size, unsigned first = 0) {
  Bytes frame(size);
  for (std::size_t i = 0; i < size; ++i) frame[i] = static_cast<std::byte>(first + i);
  return frame;
}

/// A header of ETG.1000.6 5.7, with its flags and its value.
Bytes eoe(unsigned type, unsigned flags, unsigned value, std::span<const std::byte> data = {}) {
  Bytes service{static_cast<std::byte>(type), static_cast<std::byte>(flags), static_cast<std::byte>(value & 0xFFU),
                static_cast<std::byte>(value >> 8)};
  service.insert(service.end(), data.begin(), data.end());
  return service;
}

/// Fragment `number` of frame `frame`; `blocks` is the size of the frame or the offset.
Bytes fragment(unsigned number, unsigned blocks, unsigned frame, bool last, std::span<const std::byte> data) {
  return eoe(0, last ? 1 : 0, number | blocks << 6 | frame << 12, data);
}

/// Two slaves with ports.
struct EthernetBench : EoeReceiver {
  static constexpr std::uint16_t kFirst = 0x1001;
  static constexpr std::uint16_t kSecond = 0x1002;

  EthernetBench() {
    engine.open({0, kFirst}, MailLine::kWindow);
    engine.open({1, kSecond}, MailLine::kWindow);
    ports = {eoe.open(0, *this), eoe.open(1, *this)};
  }
  void receive(std::uint16_t position, std::span<const std::byte> frame) override {
    got.emplace_back(position, Bytes(frame.begin(), frame.end()));
  }
  void step(int times = 1) {
    for (int i = 0; i < times; ++i) {
      if (!engine.step()) line.pause(milliseconds{1});
    }
  }
  /// Services of a protocol that the slave has received.
  std::vector<Bytes> heard(std::uint16_t station, unsigned type) {
    std::vector<Bytes> services;
    for (const auto& mail : line[station].heard) {
      if ((std::to_integer<unsigned>(mail[5]) & 0x0FU) == type) services.emplace_back(mail.begin() + 6, mail.end());
    }
    return services;
  }
  /// Protocols of all messages that the slave has received, in order.
  std::string order(std::uint16_t station) {
    std::string types;
    for (const auto& mail : line[station].heard) types += "mAECFS"[std::to_integer<unsigned>(mail[5]) & 0x07U];
    return types;
  }

  MailLine line;
  Bus bus{line};
  EoePorts eoe{engine};
  MailboxEngine engine{bus};
  std::array<std::shared_ptr<EoePort>, 2> ports;
  std::vector<std::pair<std::uint16_t, Bytes>> got;
};

TEST(EoePort, CutsAFrameIntoFragmentsOfWholeBlocks) {
  EthernetBench bench;
  const auto frame = frame_of(150);
  ASSERT_TRUE(bench.ports[0]->send(frame));
  bench.step(5);
  const auto all = std::span<const std::byte>(frame);
  EXPECT_THAT(bench.heard(EthernetBench::kFirst, kEoe),
              ElementsAre(fragment(0, 5, 1, false, all.first(64)), fragment(1, 2, 1, false, all.subspan(64, 64)),
                          fragment(2, 4, 1, true, all.subspan(128))));
  const auto seen = bench.ports[0]->statistics();
  EXPECT_EQ(seen.frames_out, 1U);
  EXPECT_EQ(seen.bytes_out, 150U);
  EXPECT_EQ(seen.fragments_out, 3U);
}

TEST(EoePort, CountsTheFramesOfEachSlaveForItself) {
  EthernetBench bench;
  for (int i = 0; i < 17; ++i) ASSERT_TRUE(bench.ports[0]->send(frame_of(20)));
  ASSERT_TRUE(bench.ports[1]->send(frame_of(20)));
  bench.step(20);
  const auto first = bench.heard(EthernetBench::kFirst, kEoe);
  ASSERT_EQ(first.size(), 17U);
  EXPECT_EQ(first[15], fragment(0, 1, 0, true, frame_of(20))) << "four bits";
  EXPECT_EQ(first[16], fragment(0, 1, 1, true, frame_of(20)));
  EXPECT_THAT(bench.heard(EthernetBench::kSecond, kEoe), ElementsAre(fragment(0, 1, 1, true, frame_of(20))));
}

TEST(EoePort, PutsFramesOfSeveralSlavesTogether) {
  EthernetBench bench;
  const auto one = frame_of(100, 1);
  const auto two = frame_of(90, 2);
  for (const auto& [station, frame] : {std::pair{EthernetBench::kFirst, one}, std::pair{EthernetBench::kSecond, two}}) {
    const auto all = std::span<const std::byte>(frame);
    bench.line[station].say(kEoe, fragment(0, static_cast<unsigned>(frame.size() + 31) / 32, 3, false, all.first(32)));
    bench.line[station].say(kEoe, fragment(1, 1, 3, false, all.subspan(32, 32)));
    bench.line[station].say(kEoe, fragment(2, 2, 3, true, all.subspan(64)));
  }
  bench.step(20);
  EXPECT_THAT(bench.got, ElementsAre(std::pair{std::uint16_t{0}, one}, std::pair{std::uint16_t{1}, two}));
  EXPECT_EQ(bench.ports[1]->statistics().bytes_in, 90U);
  EXPECT_EQ(bench.ports[1]->statistics().fragments_in, 3U);
}

TEST(EoePort, ALostFragmentCostsOneFrame) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  const auto frame = frame_of(100);
  const auto all = std::span<const std::byte>(frame);
  slave.say(kEoe, fragment(0, 4, 3, false, all.first(32)));
  slave.say(kEoe, fragment(2, 2, 3, true, all.subspan(64)));
  slave.say(kEoe, fragment(0, 4, 4, false, all.first(64)));
  slave.say(kEoe, fragment(1, 2, 4, true, all.subspan(64)));
  bench.step(20);
  EXPECT_EQ(bench.got.size(), 1U);
  EXPECT_EQ(bench.ports[0]->statistics().lost, 1U);
}

TEST(EoePort, CountsWhatCannotBeAndPassesNothingOn) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  slave.say(kEoe, hex("00 01"));                             // shorter than a header
  slave.say(kEoe, {});                                       // nothing
  slave.say(kEoe, fragment(1, 2, 3, false, frame_of(32)));   // frame not in progress
  slave.say(kEoe, fragment(0, 63, 3, false, frame_of(32)));  // longer than any frame
  slave.say(kEoe, fragment(0, 1, 4, true, frame_of(64)));    // more than its size
  slave.say(kEoe, fragment(0, 1, 5, true, frame_of(13)));    // shorter than any frame
  slave.say(kEoe, eoe(1, 1, 0, hex("01020304")));            // time stamp without a request
  slave.say(kEoe, eoe(3, 1, 0));                             // answer without a request
  slave.say(kEoe, eoe(15, 0xFF, 0xFFFF, frame_of(32)));      // no type
  slave.say(kEoe, fragment(0, 1, 6, true, frame_of(32)));
  bench.step(30);
  EXPECT_EQ(bench.got.size(), 1U);
  const auto seen = bench.ports[0]->statistics();
  EXPECT_EQ(seen.malformed, 5U);
  EXPECT_EQ(seen.stray, 4U);
  EXPECT_EQ(seen.frames_in, 1U);
  EXPECT_EQ(bench.engine.statistics(0).refused, 0U);
}

TEST(EoePort, TakesNoFrameThatEoeDoesNotCarryAndDropsWhenFull) {
  EthernetBench bench;
  EXPECT_FALSE(bench.ports[0]->send(frame_of(13)));
  EXPECT_FALSE(bench.ports[0]->send(frame_of(1519)));
  EXPECT_EQ(bench.ports[0]->statistics().refused, 2U);
  for (std::size_t i = 0; i < EoePort::kQueue; ++i) ASSERT_TRUE(bench.ports[0]->send(frame_of(1518)));
  EXPECT_FALSE(bench.ports[0]->send(frame_of(14)));
  EXPECT_EQ(bench.ports[0]->statistics().full, 1U);
}

TEST(EoePort, DropsWhatWaitsWhenItIsTakenDown) {
  EthernetBench bench;
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(bench.ports[0]->send(frame_of(200)));
  bench.step(2);
  bench.ports[0]->set_link(false);
  EXPECT_FALSE(bench.ports[0]->up());
  EXPECT_FALSE(bench.ports[0]->send(frame_of(20)));
  bench.line[EthernetBench::kFirst].say(kEoe, fragment(0, 1, 6, true, frame_of(32)));
  bench.step(20);
  EXPECT_TRUE(bench.got.empty());
  EXPECT_EQ(bench.heard(EthernetBench::kFirst, kEoe).size(), 2U);
  EXPECT_EQ(bench.ports[0]->statistics().given_up, 3U);
  bench.ports[0]->set_link(true);
  ASSERT_TRUE(bench.ports[0]->send(frame_of(20)));
  bench.step(3);
  EXPECT_EQ(bench.heard(EthernetBench::kFirst, kEoe).back(), fragment(0, 1, 2, true, frame_of(20)));
}

TEST(EoePort, GoesDownAndUpWithTheMailboxesOfItsSlave) {
  EthernetBench bench;
  ASSERT_TRUE(bench.ports[0]->send(frame_of(300)));
  bench.step(1);
  bench.line[EthernetBench::kFirst].say(kEoe, fragment(0, 2, 6, false, frame_of(32)));
  bench.step(3);
  bench.engine.close(0);
  EXPECT_FALSE(bench.ports[0]->up());
  EXPECT_FALSE(bench.ports[0]->send(frame_of(20)));
  EXPECT_EQ(bench.ports[0]->statistics().given_up, 1U);
  bench.line[EthernetBench::kFirst].says.clear();
  bench.engine.open({0, EthernetBench::kFirst}, MailLine::kWindow);
  EXPECT_TRUE(bench.ports[0]->up());
  EXPECT_EQ(bench.ports[0]->openings(), 2U);
  EXPECT_EQ(bench.eoe.port(0), bench.ports[0]);
  bench.line[EthernetBench::kFirst].say(kEoe, fragment(1, 1, 6, true, frame_of(32)));
  bench.step(5);
  EXPECT_EQ(bench.ports[0]->statistics().stray, 1U) << "the rest of a frame of an earlier life";
  bench.eoe.close(0);
  EXPECT_FALSE(bench.ports[0]->up());
  EXPECT_EQ(bench.eoe.port(0), nullptr);
}

TEST(EoePort, StaysDownWhereNoBlockFitsIntoAMailbox) {
  EthernetBench bench;
  auto window = MailLine::kWindow;
  window.out_length = 41;
  bench.engine.open({0, EthernetBench::kFirst}, window);
  EXPECT_FALSE(bench.ports[0]->up());
}

TEST(EoePort, GivesAFrameUpThatTheSlaveDoesNotTake) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  slave.busy = -1;
  ASSERT_TRUE(bench.ports[0]->send(frame_of(100)));
  const auto begin = bench.line.now();
  while (bench.ports[0]->statistics().given_up == 0 && bench.line.now() - begin < milliseconds{5000}) bench.step();
  EXPECT_GE(bench.line.now() - begin, milliseconds{2000});
  EXPECT_LT(bench.line.now() - begin, milliseconds{2100});
  slave.busy = 0;
  ASSERT_TRUE(bench.ports[0]->send(frame_of(20)));
  bench.step(3);
  EXPECT_THAT(bench.heard(EthernetBench::kFirst, kEoe), ElementsAre(fragment(0, 1, 2, true, frame_of(20))));
}

TEST(EoePort, RepeatsAMailThatWasNotTakenWithItsCounter) {
  EthernetBench bench;
  bench.line[EthernetBench::kFirst].busy = 3;
  ASSERT_TRUE(bench.ports[0]->send(frame_of(100)));
  bench.step(10);
  const auto& heard = bench.line[EthernetBench::kFirst].heard;
  ASSERT_EQ(heard.size(), 2U) << "nothing is skipped, nothing doubled";
  EXPECT_EQ(std::to_integer<unsigned>(heard[0][5]) >> 4, 1U);
  EXPECT_EQ(std::to_integer<unsigned>(heard[1][5]) >> 4, 2U);
  EXPECT_EQ(heard[0][4], std::byte{0}) << "lowest priority";
}

/// The slave's answer to an SDO upload of 1018h:01.
const Bytes kSdoAnswer = hex("0030 43 1810 01 28000000");

TEST(EoeBesideDialogues, AnSdoWaitsForOneFragmentAtMost) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  slave.answers = [&](const Bytes& mail) {
    if ((mail[5] & std::byte{0x0F}) == std::byte{kCoe}) slave.say(kCoe, kSdoAnswer);
  };
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(bench.ports[0]->send(frame_of(1000)));
  bench.step(5);
  slave.busy = 2;
  bench.step(1);
  const auto before = slave.heard.size();
  ASSERT_EQ(failure_text(CoeClient(bench.engine, 0).upload_as<std::uint32_t>(0x1018, 1)), "");
  EXPECT_EQ(bench.order(EthernetBench::kFirst).substr(before, 3), "ECE") << "the fragment that was on its way first";
}

TEST(EoeBesideDialogues, FragmentsFlowWhileADialogueAwaitsItsAnswer) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(bench.ports[0]->send(frame_of(1000)));
  int mails = 0;
  slave.answers = [&](const Bytes&) {
    // The slave answers late, after twenty fragments.
    if (++mails == 21) slave.say(kCoe, kSdoAnswer);
  };
  ASSERT_TRUE(CoeClient(bench.engine, 0).upload_as<std::uint32_t>(0x1018, 1));
  EXPECT_EQ(bench.order(EthernetBench::kFirst).substr(0, 21), "C" + std::string(20, 'E'));
}

TEST(EoeBesideDialogues, FragmentsFlowDuringAFileTransfer) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  std::uint8_t packet = 0;
  slave.answers = [&](const Bytes& mail) {
    if ((mail[5] & std::byte{0x0F}) == std::byte{4})
      slave.say(4, hex(packet++ == 0 ? "0400 00000000" : "0400 01000000"));
  };
  ASSERT_TRUE(bench.ports[0]->send(frame_of(200)));
  ASSERT_TRUE(FoeClient(bench.engine, 0).write({"file", 0}, frame_of(10)));
  bench.step(5);
  EXPECT_EQ(bench.order(EthernetBench::kFirst).substr(0, 2), "FE");
  EXPECT_EQ(bench.ports[0]->statistics().frames_out, 1U);
}

TEST(EoeBesideDialogues, AForeignFrameAndAnSdoAheadOfASetIpResponseConfuseNothing) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  const auto frame = frame_of(100);
  const auto all = std::span<const std::byte>(frame);
  slave.answers = [&](const Bytes& mail) {
    const auto type = std::to_integer<unsigned>(mail[5]) & 0x0FU;
    if (type == kCoe) {
      slave.say(kEoe, fragment(0, 4, 7, false, all.first(64)));
      slave.say(kEoe, eoe(5, 1, 0));  // of another service
      slave.say(kCoe, kSdoAnswer);
    } else if (mail[6] == std::byte{2}) {
      slave.say(kEoe, fragment(1, 2, 7, true, all.subspan(64)));
      slave.say(kEoe, hex("03"));  // garbage
      slave.say(kEoe, eoe(3, 1, 0));
    }
  };
  const auto sdo = CoeClient(bench.engine, 0).start_upload({0x1018, 1, false});
  ASSERT_TRUE(EoeClient(bench.engine, 0).set_ip({.mac = wire::MacAddress{}}));
  EXPECT_TRUE(sdo.ready());
  EXPECT_TRUE(sdo.get());
  EXPECT_THAT(bench.got, ElementsAre(std::pair{std::uint16_t{0}, frame}));
}

TEST(EoeBesideDialogues, AnErrorReplyThatMayBeAboutAFragmentLeavesTheDialogueItsTime) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  slave.answers = [&](const Bytes& mail) {
    if ((mail[5] & std::byte{0x0F}) == std::byte{kEoe}) slave.say(0, hex("0100 0200"));
  };
  ASSERT_TRUE(bench.ports[0]->send(frame_of(20)));
  bench.step(1);
  const auto sdo = CoeClient(bench.engine, 0).start_upload({0x1018, 1, false});
  bench.step(300);
  EXPECT_FALSE(sdo.ready());
  slave.say(kCoe, kSdoAnswer);
  bench.step(3);
  ASSERT_TRUE(sdo.ready());
  EXPECT_TRUE(sdo.get());
}

TEST(EoeReading, ReadsTheNextMailWithoutLookingWhileTheyCome) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  for (unsigned i = 0; i < 10; ++i) slave.say(kEoe, fragment(0, 1, i, true, frame_of(32)));
  bench.step(12);
  EXPECT_EQ(bench.got.size(), 10U);
  EXPECT_EQ(slave.reads, 11) << "the last one finds nothing";
  EXPECT_EQ(slave.looks, 1);
}

TEST(EoeReading, GoesBackToTheSlowIntervalWhenNothingMoves) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  slave.say(kEoe, fragment(0, 1, 1, true, frame_of(32)));
  bench.step(100);
  slave.looks = slave.reads = 0;
  bench.step(100);
  EXPECT_LE(slave.looks, 11) << "every 10 ms";
  EXPECT_EQ(slave.reads, 0);
}

TEST(EoeReading, AMailWhoseReadingWasLostIsAskedForAgainAndTheNextOneIsNotTakenForIt) {
  for (const unsigned lost : {0U, 1U, 4U}) {
    EthernetBench bench;
    auto& slave = bench.line[EthernetBench::kFirst];
    for (unsigned i = 0; i < 6; ++i) slave.say(kEoe, fragment(0, 1, i, true, frame_of(32, i)));
    while (bench.got.size() < lost) bench.step();
    slave.lost_reads = 1;
    bench.step(40);
    ASSERT_EQ(bench.got.size(), 6U) << lost;
    for (unsigned i = 0; i < 6; ++i) EXPECT_EQ(bench.got[i].second, frame_of(32, i)) << lost;
    EXPECT_EQ(bench.engine.statistics(0).repeated, 1U);
  }
}

TEST(EoeReading, ALostReadOfAnEmptyMailboxBringsNothingTwice) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  slave.say(kEoe, fragment(0, 1, 1, true, frame_of(32)));
  while (bench.got.empty()) bench.step();
  slave.lost_reads = 1;
  bench.step(40);
  EXPECT_EQ(bench.got.size(), 1U);
  EXPECT_EQ(bench.engine.statistics(0).repeated, 1U);
}

/// A slave that answers every EoE request with this service.
struct ServiceBench : EthernetBench {
  explicit ServiceBench(const Bytes& answer) {
    line[kFirst].answers = [this, answer](const Bytes&) { line[kFirst].say(kEoe, answer); };
  }
  EoeClient client{engine, 0};
};

/// All parameters: the manual's address and a name.
const wire::EoeIpParameters kAll{
    .mac = wire::MacAddress{std::byte{2}, std::byte{0}, std::byte{0}, std::byte{0}, std::byte{0}, std::byte{5}},
    .ip = wire::IpV4Address{192, 168, 39, 5},
    .subnet_mask = wire::IpV4Address{255, 255, 255, 0},
    .gateway = wire::IpV4Address{192, 168, 39, 1},
    .dns_server = wire::IpV4Address{0, 0, 0, 0},
    .dns_name = wire::EoeIpParameters::Name{'d', '1'}};

TEST(EoeServices, SetAllIpParameters) {
  ServiceBench bench(eoe(3, 1, 0));
  ASSERT_TRUE(bench.client.set_ip(kAll));
  auto expected = hex("02 01 0000 3F000000 020000000005 0527A8C0 00FFFFFF 0127A8C0 00000000 6431");
  expected.resize(4 + 58);
  EXPECT_THAT(bench.heard(EthernetBench::kFirst, kEoe), ElementsAre(expected));
}

TEST(EoeServices, FillGapsWithWhatTheSlaveHas) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  slave.answers = [&](const Bytes& mail) {
    // Densely packed: no gateway, but a DNS server; the master must not shift it into the gap.
    if (mail[6] == std::byte{6}) slave.say(kEoe, eoe(7, 1, 0, hex("17000000 020000000005 0527A8C0 00FFFFFF 01010101")));
    if (mail[6] == std::byte{2}) slave.say(kEoe, eoe(3, 1, 0));
  };
  ASSERT_TRUE(EoeClient(bench.engine, 0).set_ip({.subnet_mask = wire::IpV4Address{255, 255, 0, 0}}));
  auto expected = hex("02 01 0000 07000000 020000000005 0527A8C0 0000FFFF");
  expected.resize(4 + 58);
  EXPECT_THAT(bench.heard(EthernetBench::kFirst, kEoe), ElementsAre(eoe(6, 1, 0), expected));
}

TEST(EoeServices, SendGapsToASlaveThatDoesNotTellWhatItHas) {
  EthernetBench bench;
  auto& slave = bench.line[EthernetBench::kFirst];
  slave.answers = [&](const Bytes& mail) { slave.say(kEoe, mail[6] == std::byte{6} ? eoe(7, 1, 1) : eoe(3, 1, 0)); };
  ASSERT_TRUE(EoeClient(bench.engine, 0).set_ip({.ip = wire::IpV4Address{192, 168, 39, 5}}));
  auto expected = hex("02 01 0000 02000000 000000000000 0527A8C0");
  expected.resize(4 + 58);
  EXPECT_EQ(bench.heard(EthernetBench::kFirst, kEoe).back(), expected);
}

TEST(EoeServices, ReadIpParametersWithAndWithoutGaps) {
  auto whole = hex("12000000 000000000000 0527A8C0 00000000 00000000 01020304");
  whole.resize(58);
  for (const auto& answer : {whole, hex("12000000 0527A8C0 01020304")}) {
    ServiceBench bench(eoe(7, 1, 0, answer));
    const auto ip = must(bench.client.get_ip());
    EXPECT_EQ(*ip, (wire::EoeIpParameters{.ip = wire::IpV4Address{192, 168, 39, 5},
                                          .dns_server = wire::IpV4Address{4, 3, 2, 1}}));
  }
}

TEST(EoeServices, NameARefusalWithItsReason) {
  const auto sentence = [](const auto& result) { return result ? "" : describe(result.error()); };
  EXPECT_EQ(sentence(ServiceBench(eoe(3, 1, 0x0201)).client.set_ip(kAll)),
            "slave 0: refused the IP parameters with EoE result 0x0201 (no IP support)");
  EXPECT_EQ(sentence(ServiceBench(eoe(7, 1, 0x0001)).client.get_ip()),
            "slave 0: does not report its IP parameters, EoE result 0x0001 (unspecified error)");
  EXPECT_EQ(sentence(ServiceBench(eoe(7, 1, 0, hex("01000000 0102"))).client.get_ip()),
            "slave 0: sent a malformed mailbox");
}

TEST(EoeServices, TimeOutWhenNothingButFramesComes) {
  ServiceBench bench(fragment(0, 1, 1, true, frame_of(32)));
  const auto result = bench.client.set_ip(kAll);
  ASSERT_FALSE(result);
  EXPECT_TRUE(result.error().is<facts::MailboxTimeout>());
}

/// The address filter is longer than the mailboxes above.
TEST(EoeServices, SetAndReadTheAddressFilter) {
  wire::EoeAddressFilter filter;
  filter.address_count = 1;
  filter.no_broadcasts = true;
  filter.addresses[0] = wire::MacAddress{std::byte{2}};
  const auto service = EoeService::set_filter(filter);
  service->begin(4, {200, 200});
  Bytes expected = hex("04 01 0000 8100 02");
  expected.resize(4 + 122);
  EXPECT_THAT(service->outgoing(), testing::ElementsAreArray(expected));
  EXPECT_EQ(service->receive(eoe(5, 1, 0x0401)), MailboxDialogue::Reaction::kDone);
  EXPECT_EQ(describe(service->result().error()),
            "slave 4: refused the address filter with EoE result 0x0401 (no filter support)");
  const auto query = EoeService::get_filter();
  query->begin(4, {200, 200});
  EXPECT_THAT(query->outgoing(), testing::ElementsAreArray(eoe(8, 1, 0)));
  EXPECT_EQ(query->receive(eoe(5, 1, 0)), MailboxDialogue::Reaction::kForeign);
  EXPECT_EQ(query->receive(eoe(9, 1, 0, std::span(expected).subspan(4))), MailboxDialogue::Reaction::kDone);
  ASSERT_TRUE(query->result());
  EXPECT_EQ(query->filter(), filter);
  const auto refused = EoeService::get_filter();
  refused->begin(4, {200, 200});
  EXPECT_EQ(refused->receive(eoe(9, 1, 0x0401)), MailboxDialogue::Reaction::kDone);
  EXPECT_EQ(describe(refused->result().error()),
            "slave 4: does not report its address filter, EoE result 0x0401 (no filter support)");
}

TEST(EoeServices, NeedAMailboxThatTheyFitInto) {
  EthernetBench bench;
  const auto result = EoeClient(bench.engine, 0).set_filter({});
  ASSERT_FALSE(result);
  EXPECT_TRUE(result.error().is<facts::ProcessDataSize>());
}

}  // namespace
}  // namespace driveline::ecat_master
