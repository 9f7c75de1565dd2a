// The 15 commands: addressing, transfer of data, working counter (ETG.1000.4 5.4).
#include "bench_slave.hpp"

namespace driveline::slaves::test {
namespace {

constexpr std::uint16_t kRam = 0x1F00;

class CommandTest : public BenchSlave {
 protected:
  CommandTest() {
    write(reg::kStationAddress, kStation);
    write(kRam, bytes({0x11, 0x22}));
  }
  std::vector<std::byte> ram() { return read(kRam, 2).data; }
  static void expect(const Answer& answer, unsigned working_counter, unsigned adp, const std::vector<std::byte>& data) {
    EXPECT_EQ(answer.working_counter, working_counter);
    EXPECT_EQ(answer.adp, adp);
    EXPECT_EQ(answer.data, data);
  }
};

TEST_F(CommandTest, NopLeavesEverythingAlone) {
  expect(transfer(Command::kNop, 0, kRam, bytes({0xAA, 0xBB})), 0, 0, bytes({0xAA, 0xBB}));
  EXPECT_EQ(ram(), bytes({0x11, 0x22}));
}

TEST_F(CommandTest, UnknownCommandLeavesEverythingAlone) {
  for (unsigned raw = 15; raw < 256; ++raw) {
    expect(transfer(static_cast<Command>(raw), 0, kRam, bytes({0xAA, 0xBB})), 0, 0, bytes({0xAA, 0xBB}));
  }
  EXPECT_EQ(ram(), bytes({0x11, 0x22}));
}

TEST_F(CommandTest, AutoIncrementAddressesTheSlaveThatSeesZeroAndCountsUpInAll) {
  expect(transfer(Command::kAprd, 0, kRam, bytes({0, 0})), 1, 1, bytes({0x11, 0x22}));
  for (const unsigned position : {1U, 0xFFFFU, 0x8000U}) {
    expect(transfer(Command::kAprd, static_cast<std::uint16_t>(position), kRam, bytes({7, 7})), 0,
           static_cast<std::uint16_t>(position + 1), bytes({7, 7}));
  }
}

TEST_F(CommandTest, AutoIncrementWriteAndReadWrite) {
  EXPECT_EQ(transfer(Command::kApwr, 0xFFFF, kRam, bytes({1, 2})).working_counter, 0);
  EXPECT_EQ(ram(), bytes({0x11, 0x22}));
  const auto written = transfer(Command::kApwr, 0, kRam, bytes({1, 2}));
  EXPECT_EQ(written.working_counter, 1);
  EXPECT_EQ(written.data, bytes({1, 2}));
  EXPECT_EQ(ram(), bytes({1, 2}));

  const auto exchanged = transfer(Command::kAprw, 0, kRam, bytes({3, 4}));
  EXPECT_EQ(exchanged.working_counter, 3);
  EXPECT_EQ(exchanged.data, bytes({1, 2}));
  EXPECT_EQ(ram(), bytes({3, 4}));
}

TEST_F(CommandTest, ConfiguredAddressDoesNotChangeTheAddressField) {
  expect(transfer(Command::kFprd, kStation, kRam, bytes({0, 0})), 1, kStation, bytes({0x11, 0x22}));
  expect(transfer(Command::kFprd, kStation + 1, kRam, bytes({7, 7})), 0, kStation + 1, bytes({7, 7}));
}

TEST_F(CommandTest, ConfiguredAddressWriteAndReadWrite) {
  EXPECT_EQ(transfer(Command::kFpwr, kStation, kRam, bytes({1, 2})).working_counter, 1);
  const auto exchanged = transfer(Command::kFprw, kStation, kRam, bytes({3, 4}));
  EXPECT_EQ(exchanged.working_counter, 3);
  EXPECT_EQ(exchanged.data, bytes({1, 2}));
  EXPECT_EQ(ram(), bytes({3, 4}));
}

TEST_F(CommandTest, BroadcastReadOrsIntoTheData) {
  expect(transfer(Command::kBrd, 5, kRam, bytes({0x80, 0x02})), 1, 6, bytes({0x91, 0x22}));
}

TEST_F(CommandTest, BroadcastWriteAndReadWrite) {
  const auto written = transfer(Command::kBwr, 0xFFFF, kRam, bytes({1, 2}));
  EXPECT_EQ(written.working_counter, 1);
  EXPECT_EQ(written.adp, 0);
  EXPECT_EQ(ram(), bytes({1, 2}));
  const auto exchanged = transfer(Command::kBrw, 0, kRam, bytes({0x10, 0x20}));
  EXPECT_EQ(exchanged.working_counter, 3);
  EXPECT_EQ(exchanged.data, bytes({0x11, 0x22}));
  EXPECT_EQ(ram(), bytes({0x10, 0x20}));
}

TEST_F(CommandTest, MultipleWriteReadsFromTheAddressedSlaveAndWritesToAllOthers) {
  expect(transfer(Command::kArmw, 0, kRam, bytes({0, 0})), 1, 1, bytes({0x11, 0x22}));
  expect(transfer(Command::kArmw, 1, kRam, bytes({5, 6})), 1, 2, bytes({5, 6}));
  EXPECT_EQ(ram(), bytes({5, 6}));

  EXPECT_EQ(transfer(Command::kFrmw, kStation, kRam, bytes({0, 0})).data, bytes({5, 6}));
  const auto other = transfer(Command::kFrmw, kStation + 7, kRam, bytes({9, 9}));
  EXPECT_EQ(other.working_counter, 1);
  EXPECT_EQ(other.adp, kStation + 7);
  EXPECT_EQ(ram(), bytes({9, 9}));
}

TEST_F(CommandTest, LogicalCommandsCountOneForReadingTwoForWritingInAReadWrite) {
  set_fmmu(0, {0x10000, 2, 0, 7, kRam, 0, wire::FmmuEntity::kTypeWrite, true});
  set_fmmu(1, {0x10002, 2, 0, 7, kRam, 0, wire::FmmuEntity::kTypeRead, true});
  EXPECT_EQ(logical(Command::kLrd, 0x10000, bytes({9, 9, 9, 9})).data, bytes({9, 9, 0x11, 0x22}));
  EXPECT_EQ(logical(Command::kLrd, 0x10000, bytes({9, 9, 9, 9})).working_counter, 1);
  EXPECT_EQ(logical(Command::kLwr, 0x10000, bytes({1, 2, 3, 4})).working_counter, 1);
  EXPECT_EQ(ram(), bytes({1, 2}));
  const auto both = logical(Command::kLrw, 0x10000, bytes({5, 6, 7, 8}));
  EXPECT_EQ(both.working_counter, 3);
  EXPECT_EQ(both.data, bytes({5, 6, 1, 2})) << "what is read was there before the write";
  EXPECT_EQ(ram(), bytes({5, 6}));
  EXPECT_EQ(logical(Command::kLrw, 0x10004, bytes({5, 6})).working_counter, 0);
  EXPECT_EQ(logical(Command::kLrw, 0x0FFFE, bytes({5, 6})).working_counter, 0);
  EXPECT_EQ(logical(Command::kLrw, 0x0FFFE, bytes({5, 6, 7})).working_counter, 2);
  EXPECT_EQ(logical(Command::kLrw, 0x10003, bytes({5})).working_counter, 1);
}

TEST_F(CommandTest, LogicalAddressesWrapNowhere) {
  set_fmmu(0, {0xFFFFFFFE, 2, 0, 7, kRam, 0, wire::FmmuEntity::kTypeRead, true});
  EXPECT_EQ(logical(Command::kLrd, 0xFFFFFFFE, bytes({0, 0, 7, 7})).data, bytes({0x11, 0x22, 7, 7}));
  EXPECT_EQ(logical(Command::kLrd, 0, bytes({7, 7})).working_counter, 0);
}

TEST_F(CommandTest, ReadWriteOffsetSeparatesTheAddresses) {
  write(reg::kPhysicalOffset, 4);
  const auto answer = transfer(Command::kFprw, kStation, kRam, bytes({0xA, 0xB}));
  EXPECT_EQ(answer.data, bytes({0x11, 0x22}));
  EXPECT_EQ(ram(), bytes({0x11, 0x22}));
  EXPECT_EQ(read(kRam + 4, 2).data, bytes({0xA, 0xB}));
}

TEST_F(CommandTest, MemoryThatDoesNotExistIsNotCounted) {
  const std::uint16_t end = 0x1000 + 8 * 1024;
  EXPECT_EQ(read(end, 4).working_counter, 0);
  EXPECT_EQ(write(end, bytes({1})), 0);
  EXPECT_EQ(read(0xFFFF, 4).working_counter, 0);
  const auto across = read(end - 1, 3);
  EXPECT_EQ(across.working_counter, 1);
  EXPECT_EQ(across.data, bytes({0, 0xEE, 0xEE}));
  EXPECT_EQ(write(end - 1, bytes({1, 2, 3})), 1);
}

TEST_F(CommandTest, DatagramsWithoutDataCountNothing) {
  for (const auto command : {Command::kAprd, Command::kApwr, Command::kAprw, Command::kBrd, Command::kBwr,
                             Command::kBrw, Command::kLrd, Command::kLwr, Command::kLrw, Command::kArmw}) {
    EXPECT_EQ(transfer(command, 0, kRam, {}).working_counter, 0) << to_text(command);
    EXPECT_EQ(transfer(command, 0, reg::kAlControl.address, {}).working_counter, 0) << to_text(command);
  }
}

TEST_F(CommandTest, AliasIsAnAddressOnlyWhenEnabled) {
  auto device = std::make_unique<TestDevice>();
  device->own_profile.sii_image = test_image(0x0E05, 0x0777);
  rebuild({}, std::move(device));
  EXPECT_EQ(get(reg::kStationAlias), 0x0777);
  EXPECT_EQ(transfer(Command::kFprd, 0x0777, 0, bytes({0})).working_counter, 0);
  write(0x0103, bytes({0x01}));
  EXPECT_EQ(transfer(Command::kFprd, 0x0777, 0, bytes({0})).working_counter, 1);
  EXPECT_EQ(transfer(Command::kFpwr, 0x0777, kRam, bytes({9})).working_counter, 1);
  write(0x0103, bytes({0x00}));
  EXPECT_EQ(transfer(Command::kFprd, 0x0777, 0, bytes({0})).working_counter, 0);
}

TEST_F(CommandTest, EventRequestsAreOredIntoTheIrqFieldOfEveryDatagram) {
  // AL status event: a state change the master has not read yet.
  request(AlState::kPreOp);
  EXPECT_EQ(transfer(Command::kNop, 0, 0, {}).irq, 0) << "masked";
  write(reg::kEcatEventMask, 0x0008);
  EXPECT_EQ(transfer(Command::kNop, 0, 0, {}).irq, 0x0008);
  EXPECT_EQ(transfer(Command::kFprd, 0x0BAD, 0, bytes({0})).irq, 0x0008) << "even if addressed elsewhere";
  get(reg::kAlStatus);
  EXPECT_EQ(transfer(Command::kNop, 0, 0, {}).irq, 0);
}

}  // namespace
}  // namespace driveline::slaves::test
