// Facts of the manual that an almost correct model gets wrong, each checked where it takes effect.
#include "drive_rig.hpp"
#include "driveline/slaves/esc/slave.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/device_layout.hpp"

namespace driveline::slaves::msd {
namespace {

using testing::ElementsAre;
constexpr std::int32_t kTurnIncrements = 1 << 20;
constexpr double kTurnRad = 2.0 * std::numbers::pi;
constexpr std::uint16_t kTargetUsedBit = 0x1000;
constexpr std::uint16_t kStandstillBit = 0x4000;
constexpr std::uint16_t kSynchronisedBit = 0x8000;
constexpr std::uint16_t kReachedStatus = 0x0400;

/// Bits 12, 14 and 15 of the modes 8, 9 and 10 (MSD manual 12.3).
TEST(MsdCyclicBits, TargetUsedStandstillAndSynchronised) {
  for (const std::int8_t mode : {std::int8_t{8}, std::int8_t{9}, std::int8_t{10}}) {
    SCOPED_TRACE(int{mode});
    EnabledRig rig(mode);
    rig.cycles(80);
    EXPECT_EQ(rig.status & (kTargetUsedBit | kStandstillBit | kSynchronisedBit),
              kTargetUsedBit | kStandstillBit | kSynchronisedBit);
    rig.target_velocity = 5 * kTurnIncrements;
    rig.target_torque = 200;
    for (int i = 0; i < 800; ++i) {
      rig.target_position += 655;
      rig.cycle();
    }
    EXPECT_EQ(rig.status & kStandstillBit, 0) << "it turns";
    EXPECT_TRUE(rig.status & kTargetUsedBit);
    rig.pass(5ms);
    EXPECT_EQ(rig.status & kSynchronisedBit, 0) << "no setpoints";
    rig.command(0x07, 8000);
    ASSERT_EQ(rig.drive.state(), PowerState::kSwitchedOn);
    EXPECT_EQ(rig.status & kTargetUsedBit, 0) << "nothing is followed";
  }
}

TEST(MsdBrakeImage, IsBit6AndNoOther) {
  DriveRig rig;
  ASSERT_EQ(rig.read(0x208F), 0U);
  rig.start(9);
  rig.cycles(8);
  EXPECT_EQ(rig.read(0x208F), 1U << 6U) << "open";
  rig.command(0x06, 800);
  EXPECT_EQ(rig.read(0x208F), 0U);
}

/// P 375 scales the external feed-forward in velocity mode too (MSD manual Tables 12.25, 12.26).
TEST(MsdFeedForward, ScaleOfTheSpeedActsInVelocityMode) {
  for (const float percent : {100.0F, 50.0F, 25.0F, 0.0F}) {
    DriveRig rig;
    rig.set({{0x217B, 1, 1, 2}, real_value(0x2177, 0, percent)});
    rig.start(9);
    rig.velocity_offset = 4'000'000;
    rig.cycles(1600);
    EXPECT_NEAR(rig.velocity, 4'000'000.0 * static_cast<double>(percent) / 100.0, 3000) << percent;
  }
}

/// The same in position mode, where the external feed-forward replaces the internal one: the position controller has to
/// supply the missing part, with an error of speed over gain.
TEST(MsdFeedForward, ScaleOfTheSpeedActsInPositionMode) {
  const auto error_with = [](float percent) {
    DriveRig rig;
    rig.set({{0x217B, 1, 1, 2}, real_value(0x2177, 0, percent)});
    rig.start(8);
    rig.velocity_offset = 8000 * 131;  // increments per second at 131 in 125 us
    for (int i = 0; i < 4000; ++i) {
      rig.target_position += 131;
      rig.cycle();
    }
    return static_cast<double>(rig.following_error);
  };
  const double whole = error_with(100.0F);
  const double none = error_with(0.0F);
  EXPECT_GT(std::abs(none - whole), 1000.0);
  EXPECT_NEAR(error_with(50.0F), (whole + none) / 2.0, 0.05 * std::abs(none - whole));
  EXPECT_NEAR(error_with(25.0F), (whole + 3.0 * none) / 4.0, 0.05 * std::abs(none - whole));
}

/// 608Dh: accelerations in 10^n velocity units per second, on the shaft and not only in 6097h.
TEST(MsdScaling, AccelerationNotationActsOnTheShaft) {
  for (const auto& [index, factor] : {std::pair(0x00U, 1.0), std::pair(0x01U, 10.0), std::pair(0xFFU, 0.1)}) {
    DriveRig rig;
    ASSERT_EQ(rig.write(0x608D, 0, index, 1), 0U);
    ASSERT_EQ(rig.write(0x6083, 0, 20 * kTurnIncrements, 4), 0U);
    ASSERT_EQ(rig.write(0x6084, 0, 30 * kTurnIncrements, 4), 0U);
    rig.start(3);
    rig.turn(30 * kTurnIncrements, 80);
    const auto rate = [&rig] {
      const double before = rig.drive.velocity_rad_s();
      rig.cycles(160);
      return (rig.drive.velocity_rad_s() - before) / 20e-3 / kTurnRad;
    };
    EXPECT_NEAR(rate(), 20.0 * factor, 0.05 * 20.0 * factor + 0.2) << index;
    rig.turn(0, 8);
    EXPECT_NEAR(rate(), -30.0 * factor, 0.05 * 30.0 * factor + 0.2) << index;
  }
}

/// "After quick stop with code 5, 6, 7 or 8: bit 10 set" (MSD manual Table 11.8).
TEST(MsdQuickStop, EveryCodeThatStaysReportsItsEnd) {
  for (const std::uint32_t code : {5U, 6U, 7U, 8U}) {
    DriveRig rig;
    ASSERT_EQ(rig.write(0x605A, 0, code, 2), 0U);
    rig.operate();
    rig.run_at(10 * kTurnIncrements);
    rig.command(0x02, 8);
    EXPECT_EQ(rig.status & kReachedStatus, 0) << code << ": it brakes";
    rig.cycles(4000);
    EXPECT_EQ(rig.drive.state(), PowerState::kQuickStopActive) << code;
    EXPECT_TRUE(rig.status & kReachedStatus) << code;
    EXPECT_NEAR(rig.drive.velocity_rad_s(), 0.0, 0.05) << code;
  }
}

/// P n is object 2000h + n: that address has the parameter of that name.
TEST(MsdAddresses, ParametersHaveTheNamesOfTheManualAtTheirAddresses) {
  struct Named {
    std::uint16_t index;  ///< by hand: 2000h and the number in hexadecimal
    std::string_view name;
  };
  for (const auto& p :
       {Named{0x2003, "DV_DeviceAliasName"}, Named{0x200B, "PARA_SetCmd"}, Named{0x202D, "MOT_Type"},
        Named{0x2079, "MPRO_INPUT_STATE"}, Named{0x208F, "MPRO_OUTPUT_STATE"}, Named{0x2099, "MPRO_DRVCOM_FaultReset"},
        Named{0x21C7, "MOT_FNOM"}, Named{0x27DB, "COM_301_DeviceType"}, Named{0x2807, "COM_301_U8"},
        Named{0x280C, "COM_CAN_NMT_State"}, Named{0x28A0, "MPRO_402_Controlword"},
        Named{0x28A1, "MPRO_402_Statusword"}}) {
    ASSERT_NE(dictionary_table().find(p.index, 0), nullptr) << std::hex << p.index;
    EXPECT_EQ(dictionary_table().find(p.index, 0)->name, p.name) << std::hex << p.index;
  }
}

/// The trace of MSD manual 8.2.4 as far as CoE has it: the request and the answer announcing 100 bytes. CANopen
/// continues in segments, but the mailbox has room for all bytes.
TEST(MsdTrace, UploadOfTheAliasNameBeginsAsInTheManual) {
  DriveRig rig;
  const auto answer = rig.sdo({0x40, 0x03, 0x20, 0x00, 0x00, 0x00, 0x00, 0x00});
  ASSERT_EQ(answer.size(), 8U + 100U);
  EXPECT_THAT(std::vector<unsigned>(answer.begin(), answer.begin() + 8),
              ElementsAre(0x41, 0x03, 0x20, 0x00, 0x64, 0x00, 0x00, 0x00));
  EXPECT_THAT(std::vector<unsigned>(answer.begin() + 8, answer.begin() + 15),
              ElementsAre(0x58, 0x2D, 0x41, 0x78, 0x69, 0x73, 0x00))
      << "X-Axis";
}

/// SDOs are served during process data exchange: an answer arrives within the 5 ms that the manual calls typical (8.1),
/// and no cycle waits for it.
TEST(MsdCommunication, SdosAreAcyclicAndAnsweredInTheirTime) {
  EnabledRig rig(8);
  for (int request = 0; request < 100; ++request) {
    std::vector<std::byte> mailbox(512);
    const std::array<unsigned, 16> bytes = {
        10, 0, 0, 0, 0, 0x03U | (unsigned(request) % 7 + 1) << 4U, 0x00, 0x20, 0x40, 0x64, 0x60, 0, 0, 0, 0, 0};
    for (std::size_t i = 0; i < bytes.size(); ++i) mailbox[i] = static_cast<std::byte>(bytes[i]);
    rig.device.mailbox_request(mailbox);
    std::size_t length = 0;
    for (int cycle = 0; cycle < 40 && length == 0; ++cycle) {
      rig.target_position += 131;
      rig.cycle();
      ASSERT_NEAR(rig.position, rig.target_position, 3000) << "the axis goes on";
      length = rig.device.mailbox_reply(mailbox);
    }
    ASSERT_GT(length, 0U) << "5 ms are 40 cycles";
  }
}

/// The part of Table 8.1 that applies to EtherCAT.
TEST(MsdCommunication, ObjectsOfTheStandardAreReadOnlyOrWritableAsListed) {
  DriveRig rig;
  constexpr std::uint32_t kReadOnly = 0x06010002;
  for (const auto& [index, sub] :
       {std::pair(0x1000, 0U), std::pair(0x1001, 0U), std::pair(0x1003, 1U), std::pair(0x1018, 0U),
        std::pair(0x1018, 1U), std::pair(0x1018, 2U), std::pair(0x1018, 3U), std::pair(0x1018, 4U)}) {
    static_cast<void>(rig.read(static_cast<std::uint16_t>(index), sub));
    EXPECT_EQ(rig.write(static_cast<std::uint16_t>(index), sub, 0, sub == 0 ? (index == 0x1000 ? 4 : 1) : 4), kReadOnly)
        << std::hex << index << ':' << sub;
  }
  EXPECT_EQ(rig.write(0x1010, 1, 0x65766173, 4), 0U) << "save";
  EXPECT_EQ(rig.write(0x1011, 1, 0x64616F6C, 4), 0U) << "load";
  for (std::uint16_t n = 0; n < 4; ++n) {
    for (const std::uint16_t first : {std::uint16_t{0x1600}, std::uint16_t{0x1A00}}) {
      EXPECT_EQ(rig.write(static_cast<std::uint16_t>(first + n), 0, 0, 1), 0U);
    }
  }
}

TEST(MsdCommunication, ConformsToTheProfileOfDrives) {
  DriveRig rig;
  EXPECT_EQ(rig.read(0x1000) & 0xFFFFU, 402U);
  EXPECT_EQ(rig.read(0x1000) >> 16U, 2U) << "servo drive";
}

TEST(MsdHoming, AWrittenMethodIsTheNextOneToRun) {
  MsdParameters parameters;
  parameters.initial_position_rad = 2.2 * kTurnRad;
  DriveRig rig(parameters);
  ASSERT_EQ(rig.write(0x6099, 1, 2 * kTurnIncrements, 4), 0U);
  rig.start(6);
  const auto home_with = [&rig](unsigned method) {
    EXPECT_EQ(rig.write(0x6098, 0, method, 1), 0U);
    rig.command(0x0F, 4);
    rig.command(0x1F, 40'000);
    EXPECT_EQ(rig.status & 0x3400, 0x1400) << "attained and at rest";
    return rig.drive.position_rad() / kTurnRad - double{0} - rig.position / double{kTurnIncrements};
  };
  EXPECT_NEAR(home_with(33), 2.0, 1e-4) << "index pulse in negative direction";
  const double here = rig.drive.position_rad() / kTurnRad;
  EXPECT_NEAR(home_with(35), here, 1e-4) << "the present position";
  EXPECT_NEAR(home_with(34), std::ceil(here), 1e-4) << "index pulse in positive direction";
}

/// The emergency of every byte: code, register as in 1001h, number, location, hours (MSD manual Table 13.1).
TEST(MsdEmergency, CarriesRegisterNumberLocationAndHours) {
  struct Expected {
    Fault fault;
    std::vector<unsigned> bytes;
  };
  for (const auto& e : {Expected{Fault::kEncoder, {0x00, 0x73, 0x21, 10, 1, 0x56, 0x34, 0x12}},
                        Expected{Fault::kOvercurrent, {0x10, 0x23, 0x03, 3, 1, 0x56, 0x34, 0x12}},
                        Expected{Fault::kMotorTemperature, {0x10, 0x43, 0x09, 6, 1, 0x56, 0x34, 0x12}}}) {
    MsdParameters parameters;
    parameters.operating_hours = std::chrono::hours(0x123456);
    DriveRig rig(parameters);
    rig.drive.set_cause(e.fault, true);
    rig.pass(5ms);
    rig.fetch_emergencies();
    ASSERT_EQ(rig.emergencies.size(), 1U);
    EXPECT_EQ(rig.emergencies[0], e.bytes);
    EXPECT_EQ(rig.read(0x1001), e.bytes[2]);
  }
}

TEST(MsdScope, ExternalFeedForwardShowsAsNrefExtAndMrefExt) {
  EnabledRig rig(8);
  const auto shown = [&rig](std::string_view name) {
    const auto place = rig.drive.signals().find_signal(SignalId::Direction::kOutput, name);
    EXPECT_TRUE(place);
    return place ? rig.drive.signals().signal(*place) : -1.0;
  };
  EXPECT_EQ(shown("nref_Ext"), 0.0);
  rig.velocity_offset = 3 * kTurnIncrements;
  rig.torque_offset = -250;
  rig.cycles(2);
  EXPECT_NEAR(shown("nref_Ext"), 180.0, 1e-6) << "rpm";
  EXPECT_NEAR(shown("mref_Ext"), -0.6, 1e-6) << "Nm";
}

/// The drive behind its slave controller, accessed through registers only.
class DriveSlave : public testing::Test {
 protected:
  DriveSlave() {
    auto drive = std::make_unique<MsdDrive>();
    drive_ = &drive->core();
    slave_ = std::make_unique<Slave>(std::move(drive));
    pass(10ms);
  }
  void pass(std::chrono::nanoseconds time) {
    now_ += time;
    slave_->advance(now_);
  }
  void power_cycle() {
    slave_->set_power(false, now_);
    pass(1s);
    slave_->set_power(true, now_);
    pass(3s);
  }
  std::uint16_t transfer(wire::Command command, std::uint16_t address, std::span<std::byte> data) {
    Datagram datagram;
    datagram.command = command;
    datagram.ado = address;
    datagram.data = data;
    slave_->esc().begin_frame(++serial_);
    slave_->esc().process(datagram, now_);
    slave_->advance(now_);
    return datagram.working_counter;
  }
  void write(std::uint16_t address, std::vector<std::byte> data) {
    EXPECT_EQ(transfer(wire::Command::kApwr, address, data), 1) << std::hex << address;
  }
  void set_mailboxes() {
    for (const auto& [number, start, control] :
         {std::tuple(0U, kMailboxOutStart, 0x26U), std::tuple(1U, kMailboxInStart, 0x22U)}) {
      wire::SyncManagerChannel channel;
      channel.start_address = start;
      channel.length = kMailboxSize;
      channel.control = static_cast<std::uint8_t>(control);
      channel.activate = 1;
      std::vector<std::byte> raw(wire::SyncManagerChannel::kSize);
      channel.encode(std::span(raw).first<wire::SyncManagerChannel::kSize>());
      write(static_cast<std::uint16_t>(wire::reg::kSyncManager.at(number)), raw);
    }
  }
  void request(AlState state) {
    const auto raw = bytes::to_le_bytes(wire::AlControl{state, true, false}.raw());
    write(wire::reg::kAlControl.address, {raw.begin(), raw.end()});
    pass(1ms);
  }
  /// Uploads 1000h over CoE; returns the type of the returned mailbox message.
  unsigned coe_answer_type() {
    std::vector<std::byte> mailbox(kMailboxSize);
    const std::array<unsigned, 16> bytes = {10, 0, 0, 0, 0, 0x13, 0, 0x20, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0};
    for (std::size_t i = 0; i < bytes.size(); ++i) mailbox[i] = static_cast<std::byte>(bytes[i]);
    write(kMailboxOutStart, mailbox);
    pass(1ms);
    EXPECT_EQ(transfer(wire::Command::kAprd, kMailboxInStart, mailbox), 1);
    return std::to_integer<unsigned>(mailbox[5]) & 0x0FU;
  }
  DriveCore* drive_ = nullptr;
  std::unique_ptr<Slave> slave_;

 private:
  std::chrono::nanoseconds now_{0};
  std::uint64_t serial_ = 0;
};

using MsdBootstrap = DriveSlave;

TEST_F(MsdBootstrap, IsReachedFromInitHasNoCoeAndItsEndRestartsTheDevice) {
  set_mailboxes();
  request(AlState::kPreOp);
  ASSERT_EQ(slave_->state(), AlState::kPreOp);
  EXPECT_EQ(coe_answer_type(), 3U) << "CoE";
  request(AlState::kBootstrap);
  EXPECT_EQ(slave_->state(), AlState::kPreOp) << "only from INIT";
  request(AlState::kInit);
  set_mailboxes();
  request(AlState::kBootstrap);
  ASSERT_EQ(slave_->state(), AlState::kBootstrap);
  EXPECT_EQ(drive_->dictionary().get(kValue.nmt_state), 0);
  EXPECT_EQ(coe_answer_type(), 0U) << "an error reply: bootstrap is for FoE alone";
  drive_->set_cause(Fault::kEncoder, true);
  pass(5ms);
  drive_->set_cause(Fault::kEncoder, false);
  ASSERT_EQ(drive_->fault(), Fault::kEncoder);
  request(AlState::kInit);
  EXPECT_EQ(slave_->state(), AlState::kInit);
  EXPECT_FALSE(drive_->fault().has_value()) << "started anew";
  pass(5ms);
  EXPECT_EQ(drive_->state(), PowerState::kSwitchOnDisabled);
}

using MsdEeprom = DriveSlave;

/// Er 14 02 (MSD manual 5.3.3), detected by the drive: its EEPROM cannot be loaded, or belongs to another device.
TEST_F(MsdEeprom, WrongDataAreAFaultUntilTheyAreRight) {
  constexpr std::size_t kChecksum = 14;
  constexpr std::size_t kProduct = 0x14;
  auto& sii = slave_->esc().sii();
  for (const std::size_t offset : {kChecksum, kProduct}) {
    SCOPED_TRACE(offset);
    ASSERT_FALSE(drive_->fault().has_value());
    const std::byte right = sii.image()[offset];
    sii.corrupt(offset, right ^ std::byte{0x55});
    pass(50ms);
    EXPECT_FALSE(drive_->fault().has_value()) << "nobody has looked";
    power_cycle();
    EXPECT_EQ(drive_->fault(), Fault::kEepromData);
    EXPECT_EQ(drive_->state(), PowerState::kFault) << "the processor runs without its process data interface, too";
    EXPECT_EQ(drive_->display(), "Er. 14 02");
    drive_->press_buttons();
    pass(5ms);
    EXPECT_EQ(drive_->fault(), Fault::kEepromData) << "the cause lasts";
    sii.corrupt(offset, right);
    power_cycle();
    EXPECT_FALSE(drive_->fault().has_value());
    EXPECT_EQ(drive_->state(), PowerState::kSwitchOnDisabled);
  }
}

}  // namespace
}  // namespace driveline::slaves::msd
