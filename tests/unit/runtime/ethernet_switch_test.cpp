#include <gtest/gtest.h>

#include <vector>

#include "driveline/runtime/eoe/ethernet_switch.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using wire::MacAddress;
using Frame = std::vector<std::byte>;

MacAddress mac(int last, int first = 0x02) {
  return {static_cast<std::byte>(first), {}, {}, {}, {}, static_cast<std::byte>(last)};
}
const MacAddress kBroadcast = {std::byte{0xFF}, std::byte{0xFF}, std::byte{0xFF},
                               std::byte{0xFF}, std::byte{0xFF}, std::byte{0xFF}};

Frame frame(const MacAddress& to, const MacAddress& from, std::size_t size = 60) {
  Frame bytes(size);
  std::copy(to.begin(), to.end(), bytes.begin());
  if (size >= 12) std::copy(from.begin(), from.end(), bytes.begin() + 6);
  return bytes;
}

struct Station : SwitchedDevice {
  std::vector<Frame> got;
  bool full = false;
  bool send(std::span<const std::byte> bytes) override {
    if (full) return false;
    got.emplace_back(bytes.begin(), bytes.end());
    return true;
  }
};

class TheSwitch : public testing::Test {
 protected:
  explicit TheSwitch(const EthernetSwitch::Settings& settings = {}) : ethernet(settings) {
    for (auto& station : stations) ethernet.set_link(ethernet.connect("port", station), true);
  }
  void send(std::size_t port, const Frame& bytes) { ethernet.receive(port, bytes, now); }
  std::vector<std::size_t> received() const {
    std::vector<std::size_t> counts;
    for (const auto& station : stations) counts.push_back(station.got.size());
    return counts;
  }
  using Counts = std::vector<std::size_t>;

  std::array<Station, 3> stations;
  EthernetSwitch ethernet;
  std::chrono::nanoseconds now = seconds{1000};
};

TEST_F(TheSwitch, FloodsWhatIsForNobodyKnownAndForAll) {
  send(0, frame(mac(2), mac(1)));
  EXPECT_EQ(received(), (Counts{0, 1, 1}));
  send(0, frame(kBroadcast, mac(1)));
  EXPECT_EQ(received(), (Counts{0, 2, 2}));
}

TEST_F(TheSwitch, LearnsWhereAStationIs) {
  send(1, frame(kBroadcast, mac(2)));
  send(0, frame(mac(2), mac(1)));
  EXPECT_EQ(received(), (Counts{1, 1, 1}));
  EXPECT_EQ(stations[1].got.back(), frame(mac(2), mac(1)));
  // The station moves to another port.
  send(2, frame(kBroadcast, mac(2)));
  send(0, frame(mac(2), mac(1)));
  EXPECT_EQ(received(), (Counts{2, 2, 2}));
}

TEST_F(TheSwitch, SendsNothingBackToWhereItCameFrom) {
  send(0, frame(kBroadcast, mac(1)));
  send(0, frame(kBroadcast, mac(2)));
  for (auto& station : stations) station.got.clear();
  send(0, frame(mac(2), mac(1)));
  EXPECT_EQ(received(), (Counts{0, 0, 0}));
}

TEST_F(TheSwitch, ForgetsAStationThatIsSilent) {
  send(1, frame(kBroadcast, mac(2)));
  now += seconds{299};
  send(0, frame(mac(2), mac(1)));
  EXPECT_EQ(received(), (Counts{1, 1, 1}));
  now += seconds{2};
  send(0, frame(mac(2), mac(1)));
  EXPECT_EQ(received(), (Counts{1, 2, 2}));
}

TEST_F(TheSwitch, ALinkThatIsDownTakesAndGivesNothing) {
  send(1, frame(kBroadcast, mac(2)));
  for (auto& station : stations) station.got.clear();
  ethernet.set_link(1, false);
  send(0, frame(mac(2), mac(1)));
  EXPECT_EQ(received(), (Counts{0, 0, 1})) << "what was learnt there is forgotten";
  send(1, frame(kBroadcast, mac(2)));
  EXPECT_EQ(received(), (Counts{0, 0, 1}));
  ethernet.set_link(1, true);
  send(0, frame(mac(2), mac(1)));
  EXPECT_EQ(received(), (Counts{0, 1, 2}));
}

TEST_F(TheSwitch, RefusesWhatNoSwitchForwards) {
  send(0, frame(mac(2), mac(1), 13));
  send(0, frame(mac(2), mac(1), 1515));
  send(0, frame(mac(2), mac(1, 0x03)));  // a group address as the source
  MacAddress bridges = {std::byte{0x01}, std::byte{0x80}, std::byte{0xC2}, {}, {}, std::byte{0x0E}};
  send(0, frame(bridges, mac(1)));
  send(0, {});
  EXPECT_EQ(received(), (Counts{0, 0, 0}));
  EXPECT_EQ(ethernet.figures()[0].refused, 5U);
  EXPECT_TRUE(ethernet.figures()[0].addresses.empty());
}

TEST_F(TheSwitch, AVlanTagMakesAFrameFourBytesLonger) {
  auto tagged = frame(kBroadcast, mac(1), 1518);
  tagged[12] = std::byte{0x81};
  send(0, tagged);
  send(0, frame(kBroadcast, mac(1), 1514));
  EXPECT_EQ(received(), (Counts{0, 2, 2}));
  auto longer = frame(kBroadcast, mac(1), 1519);
  longer[12] = std::byte{0x81};
  send(0, longer);
  EXPECT_EQ(received(), (Counts{0, 2, 2}));
}

TEST_F(TheSwitch, DropsAndCountsWhenAQueueIsFull) {
  send(1, frame(kBroadcast, mac(2)));
  stations[1].full = true;
  for (int i = 0; i < 5; ++i) send(0, frame(mac(2), mac(1)));
  const auto figures = ethernet.figures();
  EXPECT_EQ(figures[1].full, 5U);
  EXPECT_EQ(figures[1].sent, 0U);
  EXPECT_EQ(figures[0].received, 5U);
  EXPECT_EQ(figures[0].bytes_in, 300U);
}

TEST_F(TheSwitch, AStormOfOnePortIsLimited) {
  for (int i = 0; i < 1000; ++i) send(0, frame(kBroadcast, mac(1)));
  EXPECT_EQ(received(), (Counts{0, 100, 100}));
  EXPECT_EQ(ethernet.figures()[0].flood_limit, 900U);
  // Other ports are not limited by it, nor are frames with a known destination.
  send(1, frame(kBroadcast, mac(2)));
  EXPECT_EQ(received(), (Counts{1, 100, 101}));
  send(0, frame(mac(2), mac(1)));
  EXPECT_EQ(received(), (Counts{1, 101, 101}));
  now += milliseconds{10};
  for (int i = 0; i < 1000; ++i) send(0, frame(kBroadcast, mac(1)));
  EXPECT_EQ(received(), (Counts{1, 111, 111}));
}

class TheSmallSwitch : public TheSwitch {
 protected:
  TheSmallSwitch() : TheSwitch({.addresses = 2, .flood_rate = 1e9}) {}
};

/// A station that invents addresses does not fill the memory, and known stations stay known.
TEST_F(TheSmallSwitch, KeepsNoMoreAddressesThanAllowed) {
  send(1, frame(kBroadcast, mac(2)));
  for (int i = 10; i < 110; ++i) {
    now += milliseconds{1};
    send(0, frame(kBroadcast, mac(i)));
  }
  std::size_t known = 0;
  for (const auto& port : ethernet.figures()) known += port.addresses.size();
  EXPECT_EQ(known, 2U);
  for (auto& station : stations) station.got.clear();
  send(2, frame(mac(2), mac(3)));
  EXPECT_EQ(received(), (Counts{0, 1, 0}));
}

}  // namespace
}  // namespace driveline::runtime
