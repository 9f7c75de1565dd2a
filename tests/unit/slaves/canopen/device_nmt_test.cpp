#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

using canopen::NmtCommand;

// C13: boot-up 700h + node-ID with one byte 00h each time Initialising is left, then Pre-operational by itself.
TEST(CanopenBootUp, C13LeadsToPreOperational) {
  DeviceRig rig;
  EXPECT_EQ(rig.device.state(), NmtState::kInitialising);
  rig.run(1ms);
  EXPECT_THAT(rig.payloads(0x705), ElementsAre(hex("00")));
  EXPECT_EQ(rig.device.state(), NmtState::kPreOperational);
  EXPECT_THAT(rig.application.restarts, ElementsAre(Reset::kPowerOn));
  rig.nmt(NmtCommand::kResetCommunication);
  rig.nmt(NmtCommand::kResetNode);
  EXPECT_THAT(rig.payloads(0x705), ElementsAre(hex("00"), hex("00"), hex("00")));
  EXPECT_EQ(rig.master.received.size(), 3U);  // and nothing else
}

TEST(CanopenBootUp, IdentifierAndLengthAreSettings) {  // devices whose boot-up is an EMCY identifier without data
  DeviceRig rig({.boot_up = 0x80, .boot_up_length = 0});
  rig.run(1ms);
  EXPECT_THAT(rig.payloads(0x085), ElementsAre(hex("")));
  EXPECT_EQ(rig.device.state(), NmtState::kPreOperational);
}

TEST(CanopenBootUp, ADeviceWithoutNodeIdStaysOffTheBus) {
  for (const std::uint8_t node : {std::uint8_t{0}, std::uint8_t{128}}) {
    DeviceRig rig;
    rig.application.next_node = node;
    rig.run(1ms);
    rig.send(0x000, "01 00");
    EXPECT_THAT(rig.master.received, IsEmpty());
    EXPECT_EQ(rig.device.state(), NmtState::kInitialising);
    EXPECT_EQ(rig.device.node_id(), 0);
  }
}

// C12: identifier 0, two bytes, commands 1, 2, 80h, 81h, 82h; node 0 means all.
TEST_F(CanopenDevice, C12CommandsAndStates) {
  struct Row {
    const char* request;
    NmtState state;
  };
  for (const auto& row :
       {Row{"01 05", NmtState::kOperational}, Row{"02 05", NmtState::kStopped}, Row{"80 05", NmtState::kPreOperational},
        Row{"01 00", NmtState::kOperational}, Row{"82 00", NmtState::kPreOperational}, Row{"02 00", NmtState::kStopped},
        Row{"01 05", NmtState::kOperational}, Row{"81 05", NmtState::kPreOperational}}) {
    rig.send(0x000, row.request);
    EXPECT_EQ(rig.device.state(), row.state) << row.request;
  }
  EXPECT_EQ(rig.device.ignored(), 0U);
}

// C12: other lengths, commands and nodes are ignored and counted.
TEST_F(CanopenDevice, C12OtherMessagesAreIgnoredAndCounted) {
  std::uint64_t ignored = 0;
  for (const char* request : {"", "01", "01 05 00", "01 06", "03 05", "00 00", "FF 05"}) {
    rig.send(0x000, request);
    EXPECT_EQ(rig.device.state(), NmtState::kPreOperational) << request;
    EXPECT_EQ(rig.device.ignored(), ++ignored) << request;
  }
  rig.send(Frame::of(canopen::Identifier{0, true}, hex("01 05")));
  rig.send(Frame::remote({0, false}, 2));
  EXPECT_EQ(rig.device.state(), NmtState::kPreOperational);
}

// C14: services by state.
TEST_F(CanopenDevice, C14ServicesByState) {
  rig.map(0x1400, {0x2000'0010});
  rig.map(0x1800, {0x2001'0008});
  struct Row {
    NmtCommand command;
    bool sdo;
    bool pdo;
    bool emergency;
  };
  unsigned value = 100;
  for (const auto& row : {Row{NmtCommand::kEnterPreOperational, true, false, true},
                          Row{NmtCommand::kStart, true, true, true}, Row{NmtCommand::kStop, false, false, false}}) {
    rig.nmt(row.command);
    rig.master.received.clear();
    EXPECT_EQ(rig.ask("40 00 10 00 00 00 00 00").empty(), !row.sdo);
    rig.send(Frame::of(0x205, std::array{static_cast<std::byte>(++value), std::byte{0}}));
    EXPECT_EQ(rig.value(0x2000) == value, row.pdo);  // C44
    rig.set(0x2001, value);
    rig.device.watch(rig.bus.now());
    rig.device.raise({0x1000, 1, {}}, rig.bus.now());
    rig.send(Frame::remote({0x705, false}, 1));
    EXPECT_EQ(rig.payloads(0x185).empty(), !row.pdo);
    EXPECT_EQ(rig.payloads(0x085).empty(), !row.emergency);
    EXPECT_EQ(rig.payloads(0x705).size(), 1U);  // error control in every state
    rig.device.clear(0x1000, rig.bus.now());
    rig.run(1ms);
  }
}

// C15: reset node restarts the application with stored values; node-ID and bit rate are taken at that moment.
TEST_F(CanopenDevice, C15ResetNodeTakesTheNodeIdAndTheBitRate) {
  rig.application.next_node = 9;
  rig.nmt(NmtCommand::kResetCommunication);
  EXPECT_EQ(rig.device.node_id(), 5);
  rig.nmt(NmtCommand::kResetNode);
  EXPECT_EQ(rig.device.node_id(), 9);
  EXPECT_EQ(rig.payloads(0x709).size(), 1U);
  EXPECT_EQ(rig.value(0x1014), 0x089U);
  EXPECT_EQ(rig.value(0x1403, 1), 0x509U);
  EXPECT_EQ(rig.value(0x1802, 1), 0x389U);
  rig.application.rate = 250'000;
  rig.send(0x000, "81 09");
  rig.run(1ms);
  EXPECT_EQ(rig.payloads(0x709).size(), 1U);  // the master has another bit rate now
  rig.master.controller().set_bit_rate(250'000);
  rig.run(10ms);
  EXPECT_EQ(rig.payloads(0x709).size(), 2U);
}

// C15: reset communication restores 1000h-1FFFh and nothing else.
TEST_F(CanopenDevice, C15ResetCommunicationKeepsTheApplication) {
  ASSERT_EQ(rig.write(0x1006, 0, 4000, 4), 0U);
  ASSERT_EQ(rig.write(0x2000, 0, 77, 2), 0U);
  rig.nmt(NmtCommand::kResetCommunication);
  EXPECT_EQ(rig.value(0x1006), 0U);
  EXPECT_EQ(rig.value(0x2000), 77U);
  EXPECT_THAT(rig.application.restarts, ElementsAre(Reset::kPowerOn));
  rig.nmt(NmtCommand::kResetNode);
  EXPECT_EQ(static_cast<std::int64_t>(rig.value(0x2000)), -17);
  EXPECT_THAT(rig.application.restarts, ElementsAre(Reset::kPowerOn, Reset::kNode));
}

// C16: NMT start is obeyed whatever the error register says, unless the application forbids it.
TEST_F(CanopenDevice, C16StartsWithAnError) {
  rig.device.raise({0x4310, 8, {}}, rig.bus.now());
  rig.start();
  EXPECT_EQ(rig.device.state(), NmtState::kOperational);
  rig.nmt(NmtCommand::kEnterPreOperational);
  rig.application.start_permitted = false;
  rig.start();
  EXPECT_EQ(rig.device.state(), NmtState::kPreOperational);
}

// CANopenNode #26, #297: no NMT start after a lost heartbeat until power-off.
TEST_F(CanopenDevice, StartsAgainAfterALostHeartbeat) {
  ASSERT_EQ(rig.write(0x1016, 1, 0x0007'0014, 4), 0U);
  rig.start();
  rig.send(0x707, "05");
  rig.run(30ms);
  ASSERT_EQ(rig.device.state(), NmtState::kPreOperational);
  rig.start();
  EXPECT_EQ(rig.device.state(), NmtState::kOperational);
}

}  // namespace
}  // namespace driveline::slaves::cia301
