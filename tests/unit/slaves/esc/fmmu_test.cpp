// Logical addressing: bit-granular mapping, several FMMUs, overlapping areas (ETG.1000.4 6.5).
#include "bench_slave.hpp"
#include "random.hpp"

namespace driveline::slaves::test {
namespace {

constexpr std::uint16_t kMappedRam = 0x1F00;
constexpr auto kRead = wire::FmmuEntity::kTypeRead;
constexpr auto kWrite = wire::FmmuEntity::kTypeWrite;

class FmmuTest : public BenchSlave {};

TEST_F(FmmuTest, ReadsSingleBitsOfTheMailboxStatus) {
  // A master polls the mailbox of several slaves in one byte: bit 3 of the status to one logical bit.
  go_to(AlState::kPreOp);
  set_fmmu(0, {0x5000, 1, 5, 5, 0x080D, 3, kRead, true});
  const auto empty = logical(Command::kLrd, 0x5000, bytes({0xFF}));
  EXPECT_EQ(empty.data, bytes({0xDF}));
  EXPECT_EQ(empty.working_counter, 1);
  device().replies.push_back(bytes({1, 2, 3}));
  pass(1ms);
  EXPECT_EQ(logical(Command::kLrd, 0x5000, bytes({0x00})).data, bytes({0x20}));
}

TEST_F(FmmuTest, StartAndStopBitsCrossBytes) {
  write(kMappedRam, bytes({0xA5, 0x3C}));
  // 9 bits from logical bit 6 on, physical from bit 3 on: 0b1100'1010'0 read little end first.
  set_fmmu(0, {0x100, 2, 6, 6, kMappedRam, 3, kRead, true});
  const unsigned physical = 0x3CA5U >> 3 & 0x1FFU;
  const unsigned expected = physical << 6;
  const auto answer = logical(Command::kLrd, 0x100, bytes({0x00, 0x00}));
  EXPECT_EQ(answer.data, bytes({expected & 0xFF, expected >> 8}));
  const auto ones = logical(Command::kLrd, 0x100, bytes({0xFF, 0xFF}));
  EXPECT_EQ(ones.data, bytes({(expected & 0xC0) | 0x3F, (expected >> 8) | 0x80})) << "other bits stay";
}

TEST_F(FmmuTest, BitwiseWriteLeavesNeighboursAlone) {
  write(kMappedRam, bytes({0x00, 0xFF}));
  set_fmmu(0, {0x100, 1, 2, 4, kMappedRam, 7, kWrite, true});
  EXPECT_EQ(logical(Command::kLwr, 0x100, bytes({0x14})).working_counter, 1);  // bits 2-4: 1 0 1
  EXPECT_EQ(read(kMappedRam, 2).data, bytes({0x80, 0xFE}));
}

TEST_F(FmmuTest, AnyBitRangeIsMovedExactly) {
  // Against a model that knows only single bits.
  Random random(20240229);
  for (int round = 0; round < 2000; ++round) {
    const unsigned bits = 1 + random() % 40;
    const unsigned logical_bit = random() % 8;
    const unsigned physical_bit = random() % 8;
    const unsigned length = (logical_bit + bits + 7) / 8;
    const unsigned stop = (logical_bit + bits - 1) % 8;
    std::vector<std::byte> memory(8);
    std::vector<std::byte> data(8);
    for (auto& byte : memory) byte = static_cast<std::byte>(random());
    for (auto& byte : data) byte = static_cast<std::byte>(random());
    const auto bit = [](const std::vector<std::byte>& from, std::size_t n) {
      return std::to_integer<unsigned>(from[n / 8]) >> (n % 8) & 1U;
    };
    const auto put = [](std::vector<std::byte>& to, std::size_t n, unsigned value) {
      const auto mask = static_cast<std::byte>(1U << (n % 8));
      to[n / 8] = value != 0 ? to[n / 8] | mask : to[n / 8] & ~mask;
    };
    write(kMappedRam, memory);
    // The frame covers a window of the logical area that may cut the mapping at both ends.
    const unsigned window_begin = random() % 3;
    const unsigned begin_bit = 8 * window_begin;
    const auto type = random() % 2 == 0 ? kRead : kWrite;
    set_fmmu(0, {0x1000, static_cast<std::uint16_t>(length), static_cast<std::uint8_t>(logical_bit),
                 static_cast<std::uint8_t>(stop), kMappedRam, static_cast<std::uint8_t>(physical_bit), type, true});
    const unsigned window = 1 + random() % 5;
    std::vector<std::byte> frame(data.begin(), data.begin() + window);
    auto expected_frame = frame;
    auto expected_memory = memory;
    bool hit = false;
    for (unsigned i = 0; i < bits; ++i) {
      const unsigned at = logical_bit + i;
      if (at < begin_bit || at >= begin_bit + 8 * window) continue;
      hit = true;
      if (type == kRead) {
        put(expected_frame, at - begin_bit, bit(memory, physical_bit + i));
      } else {
        put(expected_memory, physical_bit + i, bit(frame, at - begin_bit));
      }
    }
    const auto answer = logical(type == kRead ? Command::kLrd : Command::kLwr, 0x1000 + window_begin, frame);
    ASSERT_EQ(answer.data, expected_frame) << "round " << round;
    ASSERT_EQ(answer.working_counter, hit ? 1 : 0) << "round " << round;
    ASSERT_EQ(read(kMappedRam, 8).data, expected_memory) << "round " << round;
  }
}

TEST_F(FmmuTest, OfTwoFmmusOnTheSameBitsTheLowerNumberCounts) {
  write(kMappedRam, bytes({1, 2, 3, 4, 5, 6, 7, 8}));
  set_fmmu(1, {0x100, 4, 0, 7, kMappedRam, 0, kRead, true});
  set_fmmu(0, {0x101, 2, 0, 7, kMappedRam + 4, 0, kRead, true});
  EXPECT_EQ(logical(Command::kLrd, 0x100, bytes({0, 0, 0, 0})).data, bytes({1, 5, 6, 4}));
  set_fmmu(1, {0x100, 4, 0, 7, kMappedRam, 0, kWrite, true});
  set_fmmu(0, {0x101, 2, 0, 7, kMappedRam + 4, 0, kWrite, true});
  EXPECT_EQ(logical(Command::kLwr, 0x100, bytes({0xA, 0xB, 0xC, 0xD})).working_counter, 1);
  EXPECT_EQ(read(kMappedRam, 8).data, bytes({0xA, 2, 3, 0xD, 0xB, 0xC, 7, 8}));
}

TEST_F(FmmuTest, OverlappingInputsAndOutputsShareTheBytes) {
  // Inputs and outputs of the slave at the same logical addresses: outputs are read from the frame and replaced by
  // inputs.
  go_to(AlState::kSafeOp);
  device().inputs[3] = bytes({0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6});
  set_fmmu(0, {0x0, 4, 0, 7, kOutputsAddress, 0, kWrite, true});
  set_fmmu(1, {0x0, 6, 0, 7, kInputsAddress, 0, kRead, true});
  pass(125us);
  const auto answer = logical(Command::kLrw, 0, bytes({1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(answer.working_counter, 3);
  EXPECT_EQ(answer.data, bytes({0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6}));
  request(AlState::kOp);
  pass(125us);
  EXPECT_EQ(device().outputs[2], bytes({1, 2, 3, 4}));
}

TEST_F(FmmuTest, ReadWriteFmmuSwapsTheBytes) {
  write(kMappedRam, bytes({1, 2}));
  set_fmmu(0, {0x100, 2, 0, 7, kMappedRam, 0, kRead | kWrite, true});
  const auto answer = logical(Command::kLrw, 0x100, bytes({8, 9}));
  EXPECT_EQ(answer.working_counter, 3);
  EXPECT_EQ(answer.data, bytes({1, 2}));
  EXPECT_EQ(read(kMappedRam, 2).data, bytes({8, 9}));
}

TEST_F(FmmuTest, ABufferSpreadOverTwoFmmusIsOpenedAndClosedInLogicalOrder) {
  go_to(AlState::kSafeOp);
  set_fmmu(5, {0x200, 2, 0, 7, kOutputsAddress, 0, kWrite, true});
  set_fmmu(4, {0x202, 2, 0, 7, kOutputsAddress + 2, 0, kWrite, true});
  EXPECT_EQ(logical(Command::kLwr, 0x200, bytes({1, 2, 3, 4})).working_counter, 1);
  EXPECT_EQ(esc().sync_managers().write_count(2), 1U);
  // In the reverse order the last byte comes before the first one: nothing is handed over.
  set_fmmu(5, {0x202, 2, 0, 7, kOutputsAddress, 0, kWrite, true});
  set_fmmu(4, {0x200, 2, 0, 7, kOutputsAddress + 2, 0, kWrite, true});
  EXPECT_EQ(logical(Command::kLwr, 0x200, bytes({1, 2, 3, 4})).working_counter, 1);
  EXPECT_EQ(esc().sync_managers().write_count(2), 1U);
}

TEST_F(FmmuTest, PartOfTheProcessDataDoesNotHandOver) {
  go_to(AlState::kSafeOp);
  set_fmmu(0, {0x200, 4, 0, 7, kOutputsAddress, 0, kWrite, true});
  EXPECT_EQ(logical(Command::kLwr, 0x200, bytes({1, 2})).working_counter, 1);
  EXPECT_EQ(esc().sync_managers().write_count(2), 0U);
  EXPECT_EQ(logical(Command::kLwr, 0x202, bytes({3, 4})).working_counter, 1);
  EXPECT_EQ(esc().sync_managers().write_count(2), 1U);
  EXPECT_EQ(logical(Command::kLwr, 0x203, bytes({4})).working_counter, 0) << "closed: the last byte opens nothing";
}

TEST_F(FmmuTest, BitwiseWritesOfOneSyncManagerByteAddUp) {
  auto own = std::make_unique<TestDevice>();
  own->sizes = {0, 0, 1, 1};
  rebuild({}, std::move(own));
  configure_mailboxes();
  request(AlState::kPreOp);
  set_sync_manager(2, outputs(1));
  set_sync_manager(3, inputs(1));
  expect_request(AlState::kSafeOp, AlState::kSafeOp);
  set_fmmu(0, {0x300, 1, 0, 3, kOutputsAddress, 0, kWrite, true});
  set_fmmu(1, {0x301, 1, 0, 3, kOutputsAddress, 4, kWrite, true});
  EXPECT_EQ(logical(Command::kLwr, 0x300, bytes({0x05, 0x0A})).working_counter, 1);
  request(AlState::kOp);
  pass(125us);
  EXPECT_EQ(device().outputs[2], bytes({0xA5}));
  // Writing one half keeps the other one, whichever of the three buffers is the newest.
  for (unsigned i = 1; i < 8; ++i) {
    EXPECT_EQ(logical(Command::kLwr, 0x300, bytes({i})).working_counter, 1);
    pass(125us);
    EXPECT_EQ(device().outputs[2], bytes({0xA0 | i}));
  }
}

TEST_F(FmmuTest, InactiveOrEmptyFmmusMapNothing) {
  set_fmmu(0, {0x100, 2, 0, 7, kMappedRam, 0, kRead, false});
  set_fmmu(1, {0x100, 0, 0, 7, kMappedRam, 0, kRead, true});
  set_fmmu(2, {0x100, 1, 6, 2, kMappedRam, 0, kRead, true});  // ends before its start
  set_fmmu(3, {0x100, 2, 0, 7, kMappedRam, 0, 0, true});
  EXPECT_EQ(logical(Command::kLrd, 0x100, bytes({7, 7})).working_counter, 0);
}

TEST_F(FmmuTest, OnlyAsManyAsTheDeviceHas) {
  auto own = std::make_unique<TestDevice>();
  own->own_profile.fmmu_count = 2;
  rebuild({}, std::move(own));
  EXPECT_EQ(set_fmmu(1, {0x100, 2, 0, 7, kMappedRam, 0, kRead, true}), 1);
  EXPECT_EQ(set_fmmu(2, {0x102, 2, 0, 7, kMappedRam, 0, kRead, true}), 0);
  EXPECT_EQ(read(0x0620, 4).data, bytes({0, 0, 0, 0}));
  EXPECT_EQ(logical(Command::kLrd, 0x102, bytes({7, 7})).working_counter, 0);
}

TEST_F(FmmuTest, BitsOfBytesThatDoNotExistStay) {
  write(0x2FFF, bytes({0x50}));
  set_fmmu(0, {0x100, 1, 0, 7, 0x2FFF, 4, kRead, true});
  EXPECT_EQ(logical(Command::kLrd, 0x100, bytes({0xC0})).data, bytes({0xC5}));
}

TEST_F(FmmuTest, MappingBeyondTheMemoryTouchesNothing) {
  set_fmmu(0, {0x100, 0xFFFF, 0, 7, 0x2FFE, 0, kRead | kWrite, true});
  const auto answer = logical(Command::kLrw, 0x100, bytes({7, 7, 7, 7}));
  EXPECT_EQ(answer.working_counter, 3);
  EXPECT_EQ(answer.data, bytes({0, 0, 7, 7}));
  set_fmmu(1, {0x20000, 0xFFFF, 3, 2, 0xFFFF, 5, kRead | kWrite, true});
  EXPECT_EQ(logical(Command::kLrw, 0x20000, std::vector<std::byte>(1486)).working_counter, 0);
}

}  // namespace
}  // namespace driveline::slaves::test
