#include "driveline/canopen_client/scan.hpp"

#include "scripted_port.hpp"

namespace driveline::canopen {
namespace {

class ScanTest : public ScriptedBus {
 protected:
  [[nodiscard]] std::vector<FoundNode> scan(std::vector<std::uint8_t> nodes, std::uint32_t bit_rate = 1'000'000) {
    return *must(Scan(link, {std::move(nodes), 50ms, bit_rate}).run());
  }
};

TEST_F(ScanTest, AsksForTheDeviceType) {
  port.answer("581#4300100092010200");
  port.silence();
  port.answer("583#8000100000000008");  // a node, though it does not tell
  const auto found = scan({1, 2, 3});
  EXPECT_THAT(port.sent, ElementsAre("601#4000100000000000", "602#4000100000000000", "603#4000100000000000"));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].node, 1);
  EXPECT_EQ(found[0].device_type, 0x0002'0192U);
  EXPECT_EQ(found[1].node, 3);
  EXPECT_TRUE(found[1].answers);
  EXPECT_FALSE(found[1].device_type);
}

TEST_F(ScanTest, AnAnswerAboutAnotherObjectIsNone) {
  port.answers({{1ms, "581#4301100000000000"}, {2ms, "581#4300100100000000"}});
  EXPECT_TRUE(scan({1}).empty());
}

TEST_F(ScanTest, HearsNodesThatDoNotAnswer) {
  port.answers({{1ms, "705#05"}, {2ms, "089#00FF110E06000000"}});
  const auto found = scan({1});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].node, 5);
  EXPECT_FALSE(found[0].answers);
  EXPECT_EQ(found[0].state, NmtState::kOperational);
  EXPECT_EQ(found[1].node, 9);
}

TEST_F(ScanTest, ALateAnswerCounts) {
  port.answers({{70ms, "581#4300100092010200"}});
  const auto found = scan({1, 2});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].device_type, 0x0002'0192U);
}

// python-canopen #670: a scan that sends all requests at once floods a slow bus.
TEST_F(ScanTest, DoesNotFloodASlowBus) {
  for (int node = 1; node <= 3; ++node) {
    port.answers({{30ms, "58" + std::to_string(node) + "#4300100092010200"}});
  }
  EXPECT_EQ(scan({1, 2, 3}, 10'000).size(), 3U);
  // A request and its answer of 8 bytes have 2 x 135 bits at most: 27 ms at 10 kbit/s, a tenth of the bus in 270 ms.
  EXPECT_EQ(Scan::pace(10'000), 270ms);
  EXPECT_THAT(port.sent_at, ElementsAre(1s, 1s + 270ms, 1s + 540ms));
}

TEST_F(ScanTest, OneRequestIsUnderWayAtATime) {
  for (int i = 0; i < 127; ++i) port.silence();
  std::size_t told = 0;
  const auto found = Scan(link, {{}, 50ms, 1'000'000}).run([&](std::size_t done, std::size_t total) {
    EXPECT_EQ(done, told++);
    EXPECT_EQ(total, 127U);
  });
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->empty());
  ASSERT_EQ(port.sent_at.size(), 127U);
  for (std::size_t i = 1; i < 127; ++i) EXPECT_GE(port.sent_at[i] - port.sent_at[i - 1], 50ms);
}

TEST_F(ScanTest, EndsWhenTheBusIsGoneOrAStopIsAskedFor) {
  port.status = SendStatus::kDown;
  EXPECT_EQ(Scan(link, {}).run().error().kind, ClientErrorKind::kDown);
  port.status = SendStatus::kSent;
  link.set_stop([] { return true; });
  EXPECT_EQ(Scan(link, {}).run().error().kind, ClientErrorKind::kStopped);
}

}  // namespace
}  // namespace driveline::canopen
