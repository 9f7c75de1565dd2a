#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

constexpr Emergency kTemperature{
    0x4310, 0x08, {std::byte{0xA1}, std::byte{0xB2}, std::byte{3}, std::byte{4}, std::byte{5}}};

// C24: 8 bytes: error code low byte first, error register, manufacturer bytes. CANopenNode #402: bytes in the wrong
// order.
TEST_F(CanopenDevice, C24EmergencyMessage) {
  rig.device.raise(kTemperature, rig.bus.now());
  rig.run(1ms);
  EXPECT_THAT(rig.payloads(0x085), ElementsAre(hex("10 43 09 A1 B2 03 04 05")));
  EXPECT_EQ(rig.value(0x1001), 0x09U);
}

// C24: 1014h with bit 31 is off; its identifier is locked while the message exists.
TEST_F(CanopenDevice, C24Identifier) {
  EXPECT_EQ(rig.value(0x1014), 0x085U);
  EXPECT_EQ(rig.write(0x1014, 0, 0x0000'0091, 4), 0x0609'0030U);
  ASSERT_EQ(rig.write(0x1014, 0, 0x8000'0085, 4), 0U);
  rig.device.raise(kTemperature, rig.bus.now());
  rig.run(1ms);
  EXPECT_THAT(rig.seen(0x085), IsEmpty());
  EXPECT_EQ(rig.value(0x1003, 0), 1U);  // the history has it
  ASSERT_EQ(rig.write(0x1014, 0, 0x0000'0091, 4), 0U);
  rig.device.raise({0x3210, 4, {}}, rig.bus.now());
  rig.run(1ms);
  EXPECT_THAT(rig.payloads(0x091), ElementsAre(hex("10 32 0D 00 00 00 00 00")));
}

// C24: 1015h inhibits in 0.1 ms.
TEST_F(CanopenDevice, C24InhibitTime) {
  ASSERT_EQ(rig.write(0x1015, 0, 70, 2), 0U);
  rig.device.raise({0x1001, 1, {}}, rig.bus.now());
  rig.device.raise({0x1002, 1, {}}, rig.bus.now());
  rig.device.raise({0x1003, 1, {}}, rig.bus.now());
  rig.run(30ms);
  const auto messages = rig.seen(0x085);
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_NEAR(nanos(messages[1].time - messages[0].time), 7e6, 50e3);
  EXPECT_NEAR(nanos(messages[2].time - messages[1].time), 7e6, 50e3);
}

// C25: one EMCY per event; 0000h when the last error has gone, which is no error (CANopenNode #566, #190).
TEST_F(CanopenDevice, C25OneMessagePerEvent) {
  rig.device.raise(kTemperature, rig.bus.now());
  rig.device.raise(kTemperature, rig.bus.now());
  rig.device.raise({0x3210, 4, {}}, rig.bus.now());
  rig.run(2ms);
  EXPECT_EQ(rig.seen(0x085).size(), 2U);
  EXPECT_EQ(rig.value(0x1001), 0x0DU);
  rig.device.clear(0x4310, rig.bus.now());
  rig.device.clear(0x9999, rig.bus.now());
  rig.run(2ms);
  EXPECT_EQ(rig.seen(0x085).size(), 2U);
  EXPECT_EQ(rig.value(0x1001), 0x05U);
  rig.start();
  rig.device.clear(0x3210, rig.bus.now());
  rig.run(2ms);
  EXPECT_EQ(rig.payloads(0x085).back(), hex("00 00 00 00 00 00 00 00"));
  EXPECT_EQ(rig.value(0x1001), 0U);
  EXPECT_EQ(rig.value(0x1003, 0), 2U);
  EXPECT_EQ(rig.device.state(), NmtState::kOperational);
}

// C26: 1003h: newest at 1, older move down; 0 to sub 0 clears, anything else 06090030h.
TEST_F(CanopenDevice, C26History) {
  for (std::uint16_t code = 0x1001; code <= 0x1004; ++code) rig.device.raise({code, 1, {}}, rig.bus.now());
  rig.device.raise(kTemperature, rig.bus.now());
  rig.run(5ms);
  EXPECT_EQ(rig.read(0x1003, 0), 3U);
  EXPECT_EQ(rig.read(0x1003, 1), 0xB2A1'4310U);
  EXPECT_EQ(rig.read(0x1003, 2), 0x0000'1004U);
  EXPECT_EQ(rig.read(0x1003, 3), 0x0000'1003U);
  EXPECT_EQ(rig.write(0x1003, 0, 1, 1), 0x0609'0030U);
  ASSERT_EQ(rig.write(0x1003, 0, 0, 1), 0U);
  EXPECT_EQ(rig.read(0x1003, 0), 0U);
  EXPECT_EQ(rig.read(0x1003, 1), 0U);
}

// C27: no other EMCY changes the state.
TEST_F(CanopenDevice, C27OtherErrorsDoNotChangeTheState) {
  rig.start();
  rig.device.raise(kTemperature, rig.bus.now());
  rig.run(2ms);
  EXPECT_EQ(rig.device.state(), NmtState::kOperational);
}

// What happens in Stopped is told when the state allows it.
TEST_F(CanopenDevice, C14AnErrorInStoppedIsToldLater) {
  rig.nmt(canopen::NmtCommand::kStop);
  rig.device.raise(kTemperature, rig.bus.now());
  rig.run(20ms);
  EXPECT_THAT(rig.seen(0x085), IsEmpty());
  EXPECT_EQ(rig.value(0x1003, 0), 1U);
  rig.start();
  EXPECT_EQ(rig.seen(0x085).size(), 1U);
}

TEST_F(CanopenDevice, ErrorsAndMessagesHaveBounds) {
  rig.nmt(canopen::NmtCommand::kStop);
  for (std::uint16_t code = 0x1001; code < 0x1101; ++code) rig.device.raise({code, 1, {}}, rig.bus.now());
  rig.start();
  rig.run(20ms);
  EXPECT_EQ(rig.seen(0x085).size(), 8U);  // the newest
  EXPECT_EQ(rig.payloads(0x085).back(), hex("00 11 01 00 00 00 00 00"));
}

}  // namespace
}  // namespace driveline::slaves::cia301
