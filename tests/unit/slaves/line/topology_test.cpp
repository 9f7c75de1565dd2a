// Cables that break and heal, loops that close and open, power that fails, rings.
#include "support/must.hpp"
#include "test_line.hpp"

namespace driveline::slaves::test {
namespace {

using wire::DatagramAddress;

class TopologyTest : public LineTest {
 protected:
  wire::DlStatus dl_status(std::size_t position) { return wire::DlStatus::from_raw(peek(position, reg::kDlStatus)); }
  void set_loops(std::uint16_t position, unsigned value) {
    exchange(Command::kApwr, DatagramAddress::position(position, 0x0101), bytes({value}));
  }
};

constexpr wire::DlStatus::Port kUp{true, false, true};
constexpr wire::DlStatus::Port kDown{false, true, false};

TEST_F(TopologyTest, DlStatusOfAPlainLine) {
  build(3);
  EXPECT_EQ(count_slaves(), 3);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(dl_status(i).ports[0], kUp);
    EXPECT_EQ(dl_status(i).ports[1], i < 2 ? kUp : kDown);
    EXPECT_EQ(dl_status(i).ports[2], kDown);
    EXPECT_EQ(dl_status(i).ports[3], kDown);
    EXPECT_TRUE(dl_status(i).pdi_operational);
  }
}

TEST_F(TopologyTest, BrokenCableTurnsFramesRound) {
  build(4);
  EXPECT_EQ(count_slaves(), 4);
  EXPECT_TRUE(line().break_cable({1, 1}));
  EXPECT_EQ(count_slaves(), 2);
  EXPECT_EQ(dl_status(1).ports[1], kDown);
  EXPECT_EQ(dl_status(2).ports[0], kDown);
  EXPECT_EQ(peek(1, reg::kLostLinkCounter, 1), 1);
  EXPECT_EQ(peek(2, reg::kLostLinkCounter, 0), 1);
  EXPECT_EQ(peek(0, reg::kLostLinkCounter, 1), 0);
  line().break_cable({1, 1}, false);
  EXPECT_EQ(count_slaves(), 4);
  EXPECT_EQ(dl_status(1).ports[1], kUp);
  EXPECT_EQ(peek(1, reg::kLostLinkCounter, 1), 1);
}

TEST_F(TopologyTest, CutOffSlavesNoticeTheSilence) {
  build(2);
  count_slaves();
  line().break_cable({0, 1});
  // A slave behind the break keeps running: it is advanced although no frame reaches it.
  clock().advance(20ms);
  count_slaves();
  EXPECT_GE(device(1).local_time, 1s + 20ms);
}

TEST_F(TopologyTest, CableToTheMasterBroken) {
  build(2);
  line().break_cable({0, 0});
  EXPECT_EQ(line().send(make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}))),
            port::SendStatus::kLinkDown);
  line().break_cable({0, 0}, false);
  EXPECT_EQ(count_slaves(), 2);
}

TEST_F(TopologyTest, PowerFailureLooksLikeACutCableAndComesBackInInit) {
  build(3);
  exchange(Command::kApwr, DatagramAddress::position(1, 0x0010), bytes({0x05, 0x10}));
  line().set_power(1, false);
  EXPECT_EQ(count_slaves(), 1);
  EXPECT_EQ(dl_status(0).ports[1], kDown);
  EXPECT_EQ(dl_status(2).ports[0], kDown);
  line().set_power(1, true);
  EXPECT_EQ(count_slaves(), 3);
  EXPECT_EQ(peek(1, reg::kStationAddress), 0);
  EXPECT_EQ(dl_status(1).ports[0], kUp);
}

TEST_F(TopologyTest, FirstSlaveWithoutPowerIsNoLinkForTheMaster) {
  build(2);
  line().set_power(0, false);
  EXPECT_EQ(line().send(make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}))),
            port::SendStatus::kLinkDown);
}

TEST_F(TopologyTest, DroppedFramesAreGone) {
  build(2);
  line().drop_frames(2);
  EXPECT_EQ(count_slaves(), 0xFFFF);
  EXPECT_EQ(count_slaves(), 0xFFFF);
  EXPECT_EQ(count_slaves(), 2);
  EXPECT_EQ(line().counters().lost, 2U);
}

TEST_F(TopologyTest, LoopControlClosed) {
  build(3);
  set_loops(0, 0x0C);  // port 1 always closed
  EXPECT_EQ(count_slaves(), 1);
  EXPECT_EQ(dl_status(0).ports[1], (wire::DlStatus::Port{true, true, false})) << "link, but turned round";
  set_loops(0, 0x00);
  EXPECT_EQ(count_slaves(), 3);
}

TEST_F(TopologyTest, LoopControlOpenWithoutLinkLosesFrames) {
  build(2);
  set_loops(1, 0x08);  // port 1 of the last slave always open
  EXPECT_EQ(count_slaves(), 0xFFFF);
  EXPECT_EQ(line().slave(0).esc().memory().get(reg::kStationAddress), 0);
}

TEST_F(TopologyTest, AutoCloseStaysClosedUntilWrittenAgain) {
  build(3);
  set_loops(0, 0x04);  // port 1 auto close
  EXPECT_EQ(count_slaves(), 3);
  line().break_cable({0, 1});
  EXPECT_EQ(count_slaves(), 1);
  line().break_cable({0, 1}, false);
  EXPECT_EQ(count_slaves(), 1) << "the link is back, the loop is not opened by itself";
  EXPECT_EQ(dl_status(0).ports[1], (wire::DlStatus::Port{true, true, false}));
  set_loops(0, 0x04);
  EXPECT_EQ(count_slaves(), 3);
}

TEST_F(TopologyTest, AutoClosedPortOpensForAFrameThatComesIn) {
  build(3);
  set_loops(1, 0x01);  // port 0 auto close
  line().break_cable({1, 0});
  EXPECT_EQ(count_slaves(), 1);
  line().break_cable({1, 0}, false);
  EXPECT_EQ(count_slaves(), 3);
}

TEST_F(TopologyTest, RingIsPassedFromEndToEnd) {
  build(3, {}, Wiring::ring(3));
  const auto frame = make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}));
  EXPECT_EQ(must(exchange(frame, line(), line().secondary()))->working_counter, 3);
  EXPECT_EQ(must(exchange(frame, line().secondary(), line()))->working_counter, 0);
  EXPECT_EQ(dl_status(2).ports[1], kUp);
}

TEST_F(TopologyTest, BrokenRingIsReachedFromBothEnds) {
  build(4, {}, Wiring::ring(4));
  line().break_cable({0, 1});
  const auto frame = make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}));
  const auto near = must(exchange(frame, line(), line()));
  EXPECT_EQ(near->working_counter, 1);
  EXPECT_FALSE(near->circulating);
  const auto far = must(exchange(frame, line().secondary(), line().secondary()));
  EXPECT_EQ(far->working_counter, 3);
  EXPECT_TRUE(far->circulating) << "set by the slave that turned it round at port 0";
}

TEST_F(TopologyTest, CirculatingFramesAreDestroyed) {
  build(4, {}, Wiring::ring(4));
  line().break_cable({0, 1});
  auto frame = make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}));
  frame[16 + 7] |= std::byte{0x40};
  EXPECT_FALSE(exchange(frame, line().secondary(), line().secondary()));
  const auto near = exchange(frame, line(), line());
  ASSERT_TRUE(near) << "only a closed port 0 destroys";
  EXPECT_EQ(near->working_counter, 1);
}

TEST_F(TopologyTest, BranchWithPositionsInFrameOrder) {
  Wiring wiring(4);
  wiring.connect_master(MasterPort::kPrimary, {0, 0});
  wiring.connect({0, 1}, {1, 0});
  wiring.connect({0, 3}, {2, 0});
  wiring.connect({2, 1}, {3, 0});
  build(4, {}, std::move(wiring));
  EXPECT_EQ(count_slaves(), 4);
  // Frame order: 0, 2, 3, 1.
  const std::size_t expected[] = {0, 2, 3, 1};
  for (std::uint16_t position = 0; position < 4; ++position) {
    exchange(Command::kApwr, DatagramAddress::position(position, 0x0010), bytes({0x40U + position, 0}));
    EXPECT_EQ(peek(expected[position], reg::kStationAddress), 0x40U + position);
  }
  EXPECT_EQ(dl_status(0).ports[3], kUp);
}

TEST_F(TopologyTest, AbsentSecondInterfaceHasNoLink) {
  build(2);
  EXPECT_EQ(line().secondary().send(make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}))),
            port::SendStatus::kLinkDown);
}

}  // namespace
}  // namespace driveline::slaves::test
