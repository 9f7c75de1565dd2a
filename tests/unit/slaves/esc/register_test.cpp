// Access rules and side effects of the register space (ETG.1000.4 chapter 6, ESC data sheet section II).
#include <algorithm>

#include "bench_slave.hpp"

namespace driveline::slaves::test {
namespace {

class RegisterTest : public BenchSlave {};

using wire::RegisterAccess;

bool in_some_register(unsigned address) {
  return std::any_of(wire::kRegisters.begin(), wire::kRegisters.end(), [address](const wire::RegisterRow& row) {
    return address >= row.address && address < row.end() && (address - row.address) % row.stride < row.size;
  });
}

TEST_F(RegisterTest, ResetValuesAreThoseOfTheTable) {
  // Registers that the device, the EEPROM or the links determine.
  const std::vector<unsigned> own = {0x0004, 0x0005, 0x0006, 0x0008, 0x0012, 0x0110, 0x0140, 0x0141, 0x0150, 0x0151,
                                     0x0152, 0x0210, 0x0220, 0x0440, 0x0502, 0x0517, 0x0800, 0x0910, 0x0982};
  for (const auto& row : wire::kRegisters) {
    if (row.ecat == RegisterAccess::kWrite || std::find(own.begin(), own.end(), row.address) != own.end()) continue;
    for (unsigned n = 0; n < row.count; ++n) {
      const auto answer = read(static_cast<std::uint16_t>(row.address + n * row.stride), row.size);
      const auto expected = bytes::to_le_bytes(row.reset);
      EXPECT_TRUE(std::equal(answer.data.begin(), answer.data.end(), expected.begin())) << row.name;
    }
  }
}

TEST_F(RegisterTest, InformationTellsWhatTheDeviceHas) {
  auto device = std::make_unique<TestDevice>();
  device->own_profile.fmmu_count = 3;
  device->own_profile.sync_manager_count = 4;
  device->own_profile.ram_kib = 4;
  device->own_profile.distributed_clock = false;
  rebuild({}, std::move(device));
  EXPECT_EQ(read(0x0000, 10).data, bytes({0x11, 0, 0x02, 0, 3, 4, 4, 0x0F, 0xC0, 0x00}));
  EXPECT_EQ(read(0x1FFF, 1).working_counter, 1);
  EXPECT_EQ(read(0x2000, 1).working_counter, 0);
}

TEST_F(RegisterTest, ReservedBytesReadZeroAndIgnoreWrites) {
  for (unsigned address = 0; address < wire::kProcessRamStart; ++address) {
    if (in_some_register(address)) continue;
    // The sync manager and FMMU blocks and the power-on area are arrays of wider elements.
    if (address >= 0x0600 && address < 0x0880) continue;
    const auto at = static_cast<std::uint16_t>(address);
    EXPECT_EQ(write(at, bytes({0xFF})), 0) << std::hex << address;
    EXPECT_EQ(read(at, 1).data, bytes({0})) << std::hex << address;
  }
}

TEST_F(RegisterTest, ReadOnlyRegistersIgnoreWrites) {
  for (const auto& row : wire::kRegisters) {
    if (row.ecat != RegisterAccess::kRead || row.address == 0x0910) continue;
    const auto before = read(row.address, row.size).data;
    std::vector<std::byte> inverted = before;
    for (auto& byte : inverted) byte = ~byte;
    const auto counted = write(row.address, inverted);
    EXPECT_EQ(read(row.address, row.size).data, before) << row.name;
    EXPECT_EQ(counted, 0) << row.name;
  }
}

TEST_F(RegisterTest, WriteAcrossReadOnlyAndWritableCountsOnce) {
  // 0x0010 station address, 0x0012 alias: the second one belongs to the EEPROM.
  EXPECT_EQ(write(0x0010, bytes({0x34, 0x12, 0x78, 0x56})), 1);
  EXPECT_EQ(get(reg::kStationAddress), 0x1234);
  EXPECT_EQ(get(reg::kStationAlias), 0);
}

TEST_F(RegisterTest, ErrorCountersClearInTheirGroups) {
  const auto count = [this] { return get(reg::kProcessingUnitErrorCounter); };
  esc().count_malformed_frame();
  esc().count_malformed_frame();
  EXPECT_EQ(count(), 2);
  EXPECT_EQ(write(0x0300, std::vector<std::byte>(8)), 1);
  EXPECT_EQ(count(), 2) << "the RX error counters are another group";
  EXPECT_EQ(write(reg::kProcessingUnitErrorCounter, 0xFF), 1);
  EXPECT_EQ(count(), 0) << "any value clears";
  for (int i = 0; i < 300; ++i) esc().count_malformed_frame();
  EXPECT_EQ(count(), 0xFF) << "stops at its end";
}

TEST_F(RegisterTest, LostLinkIsCountedPerPortUnlessTheLoopIsForced) {
  const wire::DlStatus::Port up{true, false, true};
  const wire::DlStatus::Port down{false, true, false};
  esc().set_port(1, up);
  esc().set_port(1, down);
  EXPECT_EQ(read(0x0310, 4).data, bytes({0, 1, 0, 0}));
  write(0x0101, bytes({0x0C}));  // port 1: always closed
  esc().set_port(1, up);
  esc().set_port(1, down);
  EXPECT_EQ(read(0x0310, 4).data, bytes({0, 1, 0, 0}));
  EXPECT_EQ(write(0x0313, bytes({0})), 1);
  EXPECT_EQ(read(0x0310, 4).data, bytes({0, 0, 0, 0}));
}

TEST_F(RegisterTest, DlStatusShowsPortsAndRaisesItsEventUntilRead) {
  get(reg::kDlStatus);
  write(reg::kEcatEventMask, 0x0004);
  EXPECT_EQ(transfer(Command::kNop, 0, 0, {}).irq, 0);
  esc().set_port(0, {true, false, true});
  EXPECT_EQ(transfer(Command::kNop, 0, 0, {}).irq, 0x0004);
  // Port 0 link, open, communication; ports 1-3 closed; PDI up. The upper byte is what a drive with one cable
  // answers (0x56).
  EXPECT_EQ(get(reg::kDlStatus), 0x5613);
  EXPECT_EQ(transfer(Command::kNop, 0, 0, {}).irq, 0);
}

TEST_F(RegisterTest, WriteProtectionIsOpenedForOneFrame) {
  EXPECT_EQ(write(0x0021, bytes({1})), 1);
  EXPECT_EQ(write(reg::kStationAddress, 0x1234), 0);
  EXPECT_EQ(get(reg::kStationAddress), 0);
  EXPECT_EQ(write(0x1F00, bytes({5})), 1) << "process RAM is not protected by 0x0021";
  EXPECT_EQ(write(0x0F80, bytes({5})), 1) << "nor is the user RAM";
  EXPECT_EQ(write(0x0F7C, bytes({1, 2, 3, 4, 5})), 1);
  EXPECT_EQ(read(0x0F80, 1).data, bytes({5}));
  EXPECT_EQ(write(0x0F10, bytes({5})), 0) << "the outputs in front of it are";
  EXPECT_EQ(write(0x0020, bytes({0})), 1);
  EXPECT_EQ(write(reg::kStationAddress, 0x1234), 0) << "that was another frame";

  // The same frame: one serial number for both datagrams.
  esc().begin_frame(1'000'000);
  EXPECT_TRUE(esc().ecat_write(0x0020, bytes({0}), now()));
  EXPECT_TRUE(esc().ecat_write(0x0010, bytes({0x34, 0x12}), now()));
  EXPECT_TRUE(esc().ecat_write(0x0021, bytes({0}), now()));
  EXPECT_EQ(get(reg::kStationAddress), 0x1234);
  EXPECT_EQ(write(reg::kStationAddress, 7), 1) << "protection is off again";
}

TEST_F(RegisterTest, EscWriteProtectionCoversTheRamToo) {
  EXPECT_EQ(write(0x0031, bytes({1})), 1);
  EXPECT_EQ(write(0x1F00, bytes({5})), 0);
  EXPECT_EQ(write(reg::kStationAddress, 7), 0);
  esc().begin_frame(1'000'000);
  EXPECT_TRUE(esc().ecat_write(0x0030, bytes({0}), now()));
  EXPECT_TRUE(esc().ecat_write(0x1F00, bytes({5}), now()));
}

TEST_F(RegisterTest, ResetSequenceRestartsTheSlave) {
  write(reg::kStationAddress, kStation);
  go_to(AlState::kPreOp);
  EXPECT_EQ(write(reg::kResetEcat, 'R'), 1);
  EXPECT_EQ(get(reg::kResetEcat), 1);
  write(reg::kResetEcat, 'E');
  EXPECT_EQ(get(reg::kResetEcat), 2);
  write(reg::kResetEcat, 'S');
  slave().advance(now());
  expect_status(AlState::kInit);
  EXPECT_EQ(get(reg::kStationAddress), 0);
  EXPECT_EQ(device().restarts, 1) << "the application starts anew with its controller";
  EXPECT_TRUE(device().fall_backs.empty()) << "and has no fault to report";
}

TEST_F(RegisterTest, ResetSequenceMayStartAnew) {
  write(reg::kStationAddress, kStation);
  for (const char letter : {'R', 'E', 'R', 'E', 'S'}) {
    write(reg::kResetEcat, static_cast<std::uint8_t>(letter));
  }
  slave().advance(now());
  EXPECT_EQ(get(reg::kStationAddress), 0);
}

TEST_F(RegisterTest, ResetSequenceOutOfOrderDoesNothing) {
  write(reg::kStationAddress, kStation);
  for (const char letter : {'R', 'E', 'X', 'S', 'E', 'S', 'R', 'R', 'S'}) {
    write(reg::kResetEcat, static_cast<std::uint8_t>(letter));
    slave().advance(now());
  }
  EXPECT_EQ(get(reg::kStationAddress), kStation);
}

TEST_F(RegisterTest, MiiBelongsToThePdi) {
  EXPECT_EQ(read(0x0516, 2).data, bytes({0, 1}));
  EXPECT_EQ(write(reg::kMiiControl, 0x0100), 0);
  EXPECT_EQ(get(reg::kMiiControl), 0);
}

TEST_F(RegisterTest, UserRamKeepsWhatIsWritten) {
  EXPECT_EQ(write(0x0F80, bytes({1, 2, 3})), 1);
  EXPECT_EQ(read(0x0F80, 3).data, bytes({1, 2, 3}));
}

TEST_F(RegisterTest, ReservedBitsStayZero) {
  struct Row {
    std::uint16_t address;
    std::uint8_t bits;
  };
  for (const auto& row : {Row{0x0100, 0x03}, Row{0x0102, 0x4F}, Row{0x0103, 0x01}, Row{0x0138, 0x1F}, Row{0x0139, 0x1F},
                          Row{0x0606, 0x07}, Row{0x060B, 0x03}, Row{0x060C, 0x01}, Row{0x060D, 0x00}, Row{0x0804, 0x7F},
                          Row{0x0806, 0xC3}, Row{0x0931, 0x7F}, Row{0x0934, 0x0F}, Row{0x0935, 0x0F}}) {
    rebuild();
    write(row.address, bytes({0xFF}));
    EXPECT_EQ(read(row.address, 1).data, bytes({row.bits})) << std::hex << row.address;
  }
}

TEST_F(RegisterTest, RunLedFollowsTheState) {
  struct Row {
    AlState state;
    unsigned code;
  };
  for (const auto& row :
       {Row{AlState::kInit, 0x00}, Row{AlState::kPreOp, 0x0D}, Row{AlState::kSafeOp, 0x01}, Row{AlState::kOp, 0x0F}}) {
    rebuild();
    go_to(row.state);
    EXPECT_EQ(get(reg::kRunLedOverride), row.code) << to_text(row.state);
  }
}

TEST_F(RegisterTest, LedOverrideLastsUntilTheIndicatorHasNews) {
  go_to(AlState::kPreOp);
  EXPECT_EQ(write(reg::kRunLedOverride, 0x15), 1);
  EXPECT_EQ(write(reg::kErrLedOverride, 0x1F), 1);
  request(AlState::kPreOp);
  EXPECT_EQ(get(reg::kRunLedOverride), 0x15) << "the same state again is no news";
  EXPECT_EQ(get(reg::kErrLedOverride), 0x1F);
  request(AlState::kOp);
  EXPECT_EQ(get(reg::kErrLedOverride), 0x01) << "single flash: error indication in AL status";
  EXPECT_EQ(get(reg::kRunLedOverride), 0x15);
  request(AlState::kInit, true);
  EXPECT_EQ(get(reg::kRunLedOverride), 0x00);
  EXPECT_EQ(get(reg::kErrLedOverride), 0x00);
}

TEST_F(RegisterTest, ErrLedFlashesTwiceForTheWatchdog) {
  go_to(AlState::kOp);
  pass(100ms);
  EXPECT_EQ(get(reg::kErrLedOverride), 0x02);
}

TEST_F(RegisterTest, TemporaryLoopSettingsGoBackAfterOneSecond) {
  write(0x0101, bytes({0x40}));
  write(0x0100, bytes({0x03, 0x0C}));  // temporary use, port 1 closed
  slave().advance(now());
  EXPECT_EQ(esc().loop_control(1), wire::LoopControl::kClosed);
  pass(900ms);
  write(0x0101, bytes({0x08}));  // another write starts another second
  pass(900ms);
  EXPECT_EQ(read(0x0101, 1).data, bytes({0x08}));
  EXPECT_TRUE(esc().take_loop_control_change());
  pass(100ms);
  EXPECT_EQ(read(0x0101, 1).data, bytes({0x40})) << "what was set for good";
  EXPECT_TRUE(esc().loop_control_changed()) << "the line must look at its ports again";
  pass(10s);
  EXPECT_EQ(read(0x0101, 1).data, bytes({0x40}));
}

TEST_F(RegisterTest, LoopSettingsForGoodEndTemporaryOnes) {
  write(0x0100, bytes({0x03, 0x0C}));
  write(0x0100, bytes({0x01, 0x08}));
  pass(2s);
  EXPECT_EQ(read(0x0101, 1).data, bytes({0x08}));
}

TEST_F(RegisterTest, PdiWatchdogTellsThatTheApplicationStandsStill) {
  EXPECT_EQ(get(reg::kDlStatus) & 3U, 3U);
  slave().stall(now(), 300ms);
  pass(99ms);
  EXPECT_EQ(get(reg::kDlStatus) & 3U, 3U);
  pass(1ms);
  EXPECT_EQ(get(reg::kDlStatus) & 3U, 1U) << "PDI still up, its watchdog expired";
  EXPECT_EQ(get(reg::kWatchdogCounterPdi), 1);
  EXPECT_EQ(get(reg::kErrLedOverride), 0x0F);
  pass(200ms);
  EXPECT_EQ(get(reg::kDlStatus) & 3U, 3U) << "the application is back";
  EXPECT_EQ(write(reg::kWatchdogCounterProcessData, 0), 1);
  EXPECT_EQ(get(reg::kWatchdogCounterPdi), 0);
}

TEST_F(RegisterTest, PdiWatchdogTimeZeroSwitchesItOff) {
  write(reg::kWatchdogTimePdi, 0);
  slave().stall(now(), 10s);
  pass(9s);
  EXPECT_EQ(get(reg::kWatchdogCounterPdi), 0);
  EXPECT_EQ(get(reg::kDlStatus) & 3U, 3U);
}

TEST_F(RegisterTest, BlockWritesOfCommonMastersReachTheirRegisters) {
  // Initialisation by broadcast as masters send it; all were answered with working counter 1 by a drive.
  struct Row {
    std::uint16_t address;
    std::size_t length;
  };
  for (const auto& row :
       {Row{0x0010, 2}, Row{0x0101, 1}, Row{0x0103, 1}, Row{0x0120, 1}, Row{0x0200, 2}, Row{0x0300, 8}, Row{0x0500, 1},
        Row{0x0600, 48}, Row{0x0600, 256}, Row{0x0800, 32}, Row{0x0800, 256}, Row{0x0900, 4}, Row{0x0900, 8},
        Row{0x0910, 4}, Row{0x0910, 32}, Row{0x0930, 2}, Row{0x0934, 2}, Row{0x0981, 1}}) {
    const auto answer = transfer(Command::kBwr, 0, row.address, std::vector<std::byte>(row.length));
    EXPECT_EQ(answer.working_counter, 1) << std::hex << row.address << " length " << row.length;
  }
}

TEST_F(RegisterTest, AlControlIsLockedUntilTheApplicationHasReadIt) {
  // The recorded drive answers two AL control writes 0.5 ms apart with working counters 1 and 0.
  EXPECT_EQ(write(0x0120, bytes({0x11})), 1);
  EXPECT_EQ(write(0x0120, bytes({0x11})), 0);
  slave().advance(now());
  EXPECT_EQ(write(0x0120, bytes({0x11})), 1);
}

}  // namespace
}  // namespace driveline::slaves::test
