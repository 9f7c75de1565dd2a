// Address, bit rate, boot-up, network states, LEDs and parameters of the MSD on a CAN bus (MSD manual 4, 6).
#include <fstream>
#include <sstream>

#include "can_drive_rig.hpp"
#include "driveline/slaves/msd/can/can_indicators.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint16_t kAddress = 0x27D5;
constexpr std::uint16_t kBitRate = 0x27D6;
constexpr std::uint16_t kActiveAddress = 0x280A;
constexpr std::uint16_t kActiveBitRate = 0x280B;
constexpr std::uint16_t kNetworkState = 0x280C;

class MsdCanAddress : public EachCanDrive {};
class MsdCanSupply : public EachCanDrive {};
class MsdCanParameters : public EachCanDrive {};

// MSD manual Tables 4.4 and 4.5.
TEST(MsdCanSwitch, WeighsOneToSixtyFourAndTheLastOneIsTheResistor) {
  for (unsigned n = 0; n < 7; ++n) {
    const DipSwitch one{static_cast<std::uint8_t>(1U << n)};
    EXPECT_EQ(one.address(Series::kSingleMultiAxis), 1U << n);
    EXPECT_EQ(one.address(Series::kServoOne), 1U << n);
    EXPECT_FALSE(one.terminates(Series::kSingleMultiAxis));
    EXPECT_EQ(one.address(Series::kCompact), n < 6 ? 1U << n : 0U);
    EXPECT_EQ(one.terminates(Series::kCompact), n == 6);
    EXPECT_EQ(one.terminates(Series::kServoOneJunior), n == 6);
  }
  EXPECT_EQ(DipSwitch{0xFF}.address(Series::kSingleMultiAxis), 127);
  EXPECT_EQ(DipSwitch{0x7F}.address(Series::kCompact), 63);
  EXPECT_EQ(DipSwitch{0x80}.address(Series::kSingleMultiAxis), 0);
  EXPECT_TRUE(DipSwitch{0x80}.terminates(Series::kSingleMultiAxis));
}

TEST_P(MsdCanAddress, IsThatOfTheSwitchWithoutParameter) {
  CanDriveRig rig(parameters(), {DipSwitch{0b11}, {}, 500us}, 3);
  rig.run(5ms);
  EXPECT_THAT(rig.payloads(0x703), ElementsAre(hex("00"))) << "one boot-up message, with the address";
  EXPECT_EQ(rig.read(kActiveAddress), 3U);
  EXPECT_FALSE(rig.drive.terminates_bus());
  rig.drive.set_dip_switch({GetParam() == Variant::kServoOneJunior ? std::uint8_t{0x43} : std::uint8_t{0x83}});
  EXPECT_TRUE(rig.drive.terminates_bus());
}

// P 2005 = 30, switches 1 and 2: 33; effective with reset node, not before.
TEST_P(MsdCanAddress, IsTheSumFromResetNodeOn) {
  CanDriveRig rig(parameters(), {DipSwitch{0b11}, {}, 500us}, 3);
  rig.run(5ms);
  ASSERT_EQ(rig.write(kAddress, 0, 30, 1), 0U);
  ASSERT_EQ(rig.save(), 0U);
  EXPECT_EQ(rig.read(kActiveAddress), 3U) << "not yet";
  rig.nmt(NmtCommand::kResetCommunication);
  EXPECT_EQ(rig.read(kActiveAddress), 3U);
  EXPECT_EQ(rig.count(0x703), 2U);
  rig.nmt(NmtCommand::kResetNode);
  rig.run(5ms);
  EXPECT_THAT(rig.payloads(0x721), ElementsAre(hex("00")));
  rig.node = 33;
  EXPECT_EQ(rig.read(kActiveAddress), 33U);
  EXPECT_EQ(rig.read(kAddress), 30U);
  EXPECT_EQ(rig.read(0x1014), 0x0A1U);
  rig.drive.set_dip_switch({0b101});
  EXPECT_EQ(rig.read(kActiveAddress), 33U) << "the switch, too, counts from the next start on";
  rig.drive.restart();
  rig.run(5ms);
  EXPECT_EQ(rig.count(0x700 + 35), 1U);
}

// Ours: without a node-ID the drive is not on the bus.
TEST_P(MsdCanAddress, ThatIsNoNodeIdKeepsTheDriveOffTheBus) {
  for (const std::uint8_t address : {std::uint8_t{0}, std::uint8_t{100}}) {
    CanDriveRig rig(parameters(), {DipSwitch{static_cast<std::uint8_t>(address == 0 ? 0 : 50)}, {}, 500us}, 50);
    rig.run(5ms);
    if (address != 0) {
      ASSERT_EQ(rig.write(kAddress, 0, address, 1), 0U);
      ASSERT_EQ(rig.save(), 0U);
      rig.nmt(NmtCommand::kResetNode);
    }
    rig.master.received.clear();
    rig.nmt(NmtCommand::kResetNode);
    rig.run(50ms);
    EXPECT_THAT(rig.master.received, IsEmpty());
    EXPECT_EQ(rig.value(kActiveAddress), address == 0 ? 0U : 150U);
    EXPECT_EQ(rig.drive.device().state(), NmtState::kInitialising);
  }
}

// P 2006 counts after a restart of the drive, not after reset node.
TEST_P(MsdCan, BitRateCountsAfterARestart) {
  ASSERT_EQ(rig.write(kBitRate, 0, 250, 2), 0U);
  ASSERT_EQ(rig.save(), 0U);
  EXPECT_EQ(rig.read(kActiveBitRate), 1000U);
  rig.nmt(NmtCommand::kResetNode);
  rig.run(5ms);
  EXPECT_EQ(rig.read(kActiveBitRate), 1000U);
  EXPECT_EQ(rig.read(kBitRate), 250U);
  rig.drive.restart();
  rig.run(20ms);
  const std::size_t before = rig.count(0x70C);
  rig.master.controller().set_bit_rate(250'000);
  rig.master.controller().recover(rig.bus.now());
  rig.run(100ms);
  EXPECT_EQ(rig.count(0x70C), before + 1) << "the boot-up message that nobody acknowledged";
  EXPECT_EQ(rig.read(kActiveBitRate), 250U);
  EXPECT_EQ(rig.drive.device().controller()->options().bit_rate, 250'000U);
}

// MSD manual 7.5.4: a factory reset resets address and bit rate, too, and takes ten seconds, in which nothing is said.
TEST_P(MsdCan, FactoryResetTakesAddressAndBitRateAndTenSeconds) {
  ASSERT_EQ(rig.write(kAddress, 0, 7, 1), 0U);
  ASSERT_EQ(rig.write(kBitRate, 0, 500, 2), 0U);
  ASSERT_EQ(rig.write(0x1800, 2, 4, 1), 0U);
  ASSERT_EQ(rig.save(), 0U);
  ASSERT_EQ(rig.write(0x200B, 3, 1, 1), 0U);
  ASSERT_EQ(rig.write(0x200B, 1, 1, 1), 0U);
  rig.run(2ms);
  EXPECT_EQ(rig.read(0x200B, 1), 0U) << "saved";
  rig.master.received.clear();
  rig.nmt(NmtCommand::kResetNode);
  rig.run(9900ms);
  EXPECT_THAT(rig.master.received, IsEmpty());
  EXPECT_EQ(rig.value(kNetworkState), 0U);
  rig.run(200ms);
  EXPECT_EQ(rig.count(0x70C), 1U);
  EXPECT_EQ(rig.read(kAddress), 0U);
  EXPECT_EQ(rig.read(kBitRate), 1000U);
  EXPECT_EQ(rig.read(0x1800, 2), 255U);
}

// 1011h takes the factory settings at the next start (MSD manual 7.5.2).
TEST_P(MsdCan, LoadTakesTheFactorySettings) {
  const std::uint32_t before = rig.read(0x6081);
  ASSERT_EQ(rig.write(0x6081, 0, 12345, 4), 0U);
  ASSERT_EQ(rig.save(), 0U);
  ASSERT_EQ(rig.write(0x1011, 1, 0x64616F6C, 4), 0U);
  rig.nmt(NmtCommand::kResetNode);
  rig.run(11s);
  EXPECT_EQ(rig.read(0x6081), before);
}

// NMT is processed in the next millisecond (MSD manual 8.1.1).
TEST_P(MsdCan, NmtIsObeyedInTheNextMillisecond) {
  rig.bus.advance((rig.bus.now() / 1ms + 1) * 1ms);
  rig.send(canopen::NmtRequest{NmtCommand::kStart, 12}.frame(), 999us);
  EXPECT_EQ(rig.drive.device().state(), NmtState::kPreOperational);
  rig.run(1us);
  EXPECT_EQ(rig.drive.device().state(), NmtState::kOperational);
}

// MSD manual Table 6.5.
TEST_P(MsdCan, NetworkStateIsShown) {
  EXPECT_EQ(rig.value(kNetworkState), 127U);
  rig.start();
  EXPECT_EQ(rig.value(kNetworkState), 5U);
  rig.nmt(NmtCommand::kStop);
  EXPECT_EQ(rig.value(kNetworkState), 4U);
  rig.bus.advance((rig.bus.now() / 1ms + 1) * 1ms);
  rig.send(canopen::NmtRequest{NmtCommand::kResetNode, 12}.frame(), 999us);
  rig.run(500us);
  EXPECT_EQ(rig.value(kNetworkState), 0U) << "the self-test";
  rig.run(5ms);
  EXPECT_EQ(rig.value(kNetworkState), 127U);
}

// MSD manual Table 4.2: half of each cycle is lit.
TEST(MsdCanLeds, H14HasTheCyclesOfTheManual) {
  struct Row {
    NmtState state;
    std::chrono::milliseconds cycle;
  };
  for (const auto& [state, cycle] :
       {Row{NmtState::kInitialising, 100ms}, Row{NmtState::kStopped, 800ms}, Row{NmtState::kPreOperational, 1600ms}}) {
    int changes = 0;
    int lit = 0;
    bool before = network_led_h14(state, 0ms);
    const int steps = static_cast<int>(10 * cycle / 10ms);
    for (int i = 1; i <= steps; ++i) {
      const bool now = network_led_h14(state, i * 10ms);
      changes += now != before ? 1 : 0;
      lit += now ? 1 : 0;
      before = now;
    }
    EXPECT_EQ(changes, 20) << cycle.count();
    EXPECT_EQ(lit, steps / 2) << cycle.count();
  }
  for (int i = 0; i < 200; ++i) EXPECT_TRUE(network_led_h14(NmtState::kOperational, i * 10ms));
}

TEST_P(MsdCan, H14FollowsTheStateOfTheDevice) {
  EXPECT_TRUE(rig.drive.led_h14(1600ms));
  EXPECT_FALSE(rig.drive.led_h14(2400ms));
  rig.start();
  EXPECT_TRUE(rig.drive.led_h14(2400ms));
}

// MSD manual 4.5, 6.5.2: without 24 V at X32 the drive is not on the bus, and H15 is dark.
TEST_P(MsdCan, WithoutSupplyTheDriveIsNotThere) {
  EXPECT_TRUE(rig.drive.led_h15());
  rig.drive.set_bus_supply(false);
  EXPECT_FALSE(rig.drive.led_h15());
  rig.master.received.clear();
  EXPECT_THAT(rig.ask("40 00 10 00 00 00 00 00"), IsEmpty());
  EXPECT_THAT(rig.master.received, IsEmpty());
  rig.drive.set_bus_supply(true);
  rig.run(5ms);
  EXPECT_EQ(rig.count(0x70C), 1U) << "the communication starts again";
  EXPECT_EQ(rig.read(0x1000), 0x0002'0192U);
}

TEST_P(MsdCanSupply, MissingAtTheStartMeansNoBootUp) {
  CanDriveRig rig(parameters());
  rig.drive.set_bus_supply(false);
  rig.run(20ms);
  EXPECT_THAT(rig.master.received, IsEmpty());
  rig.drive.set_bus_supply(true);
  rig.run(5ms);
  EXPECT_THAT(rig.payloads(0x70C), ElementsAre(hex("00")));
}

std::string content(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

// MSD manual 4.4: the same set of parameters for drives with P 2005 = 30 and different switches.
TEST_P(MsdCanParameters, OneFileServesDrivesWithDifferentSwitches) {
  const test::TemporaryFolder folder;
  MsdParameters shared = parameters();
  shared.parameter_file = (folder.path / "drives.txt").string();
  {
    CanDriveRig rig(shared);
    rig.run(5ms);
    ASSERT_EQ(rig.write(kAddress, 0, 30, 1), 0U);
    ASSERT_EQ(rig.write(0x27D7, 3, 0x0000'FF00, 4), 0U);
    ASSERT_EQ(rig.write(0x1017, 0, 25, 2), 0U);
    ASSERT_EQ(rig.write(0x1006, 0, 2000, 4), 0U);
    rig.map(0x1801, {0x6064'0020, 0x6041'0010}, 3);
    ASSERT_EQ(rig.write(0x1802, 1, 0x8000'038CU, 4), 0U);
    ASSERT_EQ(rig.write(0x1802, 1, 0x0000'0234U, 4), 0U) << "an identifier of its own";
    ASSERT_EQ(rig.save(), 0U);
    EXPECT_EQ(rig.read(0x1801, 1), 0x28CU) << "to save changes nothing";
  }
  const std::string file = content(shared.parameter_file);
  EXPECT_NE(file.find("1801:01 = 640 "), std::string::npos) << "280h without node-ID: " << file;
  for (const std::uint8_t place : {std::uint8_t{1}, std::uint8_t{15}}) {
    const auto node = static_cast<std::uint8_t>(30 + place);
    CanDriveRig rig(shared, {DipSwitch{place}, {}, 500us}, node);
    rig.run(5ms);
    EXPECT_EQ(rig.read(kActiveAddress), node);
    EXPECT_EQ(rig.read(0x1801, 1), 0x280U + node);
    EXPECT_EQ(rig.read(0x1802, 1), 0x234U);
    EXPECT_EQ(rig.read(0x1014), 0x80U + node);
    EXPECT_EQ(rig.read(0x1801, 2), 3U);
    EXPECT_EQ(rig.read(0x1A01, 0), 2U);
    EXPECT_EQ(rig.read(0x1A01, 2), 0x6041'0010U);
    EXPECT_EQ(rig.read(0x27D7, 3), 0x0000'FF00U);
    EXPECT_EQ(rig.read(0x1006), 2000U);
    EXPECT_EQ(rig.read(0x1017), 25U);
  }
  EXPECT_EQ(content(shared.parameter_file), file) << "to start writes nothing";
}

// Reset communication restores 1000h to 1FFFh only; reset node everything.
TEST_P(MsdCan, ResetCommunicationKeepsTheDrive) {
  ASSERT_EQ(rig.write(0x1006, 0, 4000, 4), 0U);
  ASSERT_EQ(rig.write(0x1801, 2, 7, 1), 0U);
  ASSERT_EQ(rig.write(0x6081, 0, 12345, 4), 0U);
  const std::uint32_t size_of_version = rig.read(0x100A);
  ASSERT_GT(size_of_version, 4U);
  rig.nmt(NmtCommand::kResetCommunication);
  EXPECT_EQ(rig.read(0x1006), 1000U);
  EXPECT_EQ(rig.read(0x1801, 2), 255U);
  EXPECT_EQ(rig.read(0x1801, 1), 0x28CU);
  EXPECT_EQ(rig.read(0x6081), 12345U);
  EXPECT_EQ(rig.read(0x100A), size_of_version) << "texts are those of this drive";
  rig.nmt(NmtCommand::kResetNode);
  rig.run(5ms);
  EXPECT_NE(rig.read(0x6081), 12345U);
}

// What was written in the modes is not saved: 6060h (MSD manual 7.5.3).
TEST_P(MsdCan, SavedParametersSurviveResetNodeTheModeDoesNot) {
  ASSERT_EQ(rig.write(0x6060, 0, 7, 1), 0U);
  ASSERT_EQ(rig.write(0x6081, 0, 12345, 4), 0U);
  ASSERT_EQ(rig.write(0x200B, 1, 1, 1), 0U);
  ASSERT_EQ(rig.write(0x6081, 0, 777, 4), 0U);
  rig.nmt(NmtCommand::kResetNode);
  rig.run(5ms);
  EXPECT_EQ(rig.read(0x6081), 12345U);
  EXPECT_EQ(rig.read(0x6060), 0U);
}

INSTANTIATE_TEST_SUITE_P(Drives, MsdCan, kEachDrive, drive_name);
INSTANTIATE_TEST_SUITE_P(Drives, MsdCanAddress, kEachDrive, drive_name);
INSTANTIATE_TEST_SUITE_P(Drives, MsdCanSupply, kEachDrive, drive_name);
INSTANTIATE_TEST_SUITE_P(Drives, MsdCanParameters, kEachDrive, drive_name);

}  // namespace
}  // namespace driveline::slaves::msd
