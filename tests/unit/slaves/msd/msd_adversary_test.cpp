// Every misuse of the object dictionary by a master, tried on every row of every variant's table; and values that must
// never reach the plant.
#include <limits>
#include <random>
#include <set>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint32_t kDone = 0;
constexpr std::uint32_t kWriteToReadOnly = 0x06010002;
constexpr std::uint32_t kNoSuchObject = 0x06020000;
constexpr std::uint32_t kNotMappable = 0x06040041;
constexpr std::uint32_t kTooLong = 0x06070012;
constexpr std::uint32_t kTooShort = 0x06070013;
constexpr std::uint32_t kNoSuchSubindex = 0x06090011;
constexpr std::uint32_t kRange = 0x06090030;
constexpr std::uint32_t kTooHigh = 0x06090031;
constexpr std::uint32_t kTooLow = 0x06090032;
constexpr std::uint32_t kWrongState = 0x08000022;

class MsdAdversary : public testing::TestWithParam<Variant> {
 protected:
  static MsdParameters parameters() {
    MsdParameters made;
    made.variant = GetParam();
    return made;
  }
  [[nodiscard]] static const DictionaryTable& table() { return dictionary_table(GetParam()); }

  DriveRig rig{parameters()};

  /// Download of any length; 0 or the abort code.
  std::uint32_t download(std::uint16_t index, unsigned sub, const std::vector<unsigned>& data) {
    std::vector<unsigned> request = {0x21, index & 0xFFU, unsigned{index} >> 8, sub};
    if (!data.empty() && data.size() <= 4) {
      request[0] = 0x23U | (4U - static_cast<unsigned>(data.size())) << 2;
    } else {
      for (unsigned i = 0; i < 4; ++i) request.push_back(static_cast<unsigned>(data.size() >> 8 * i & 0xFFU));
    }
    request.insert(request.end(), data.begin(), data.end());
    while (request.size() < 8) request.push_back(0);
    const auto answer = rig.sdo(request);
    return answer.at(0) == 0x80 ? DriveRig::number(answer, 4) : kDone;
  }
  std::uint32_t download(const EntryRow& row, std::uint64_t raw, std::size_t size) {
    std::vector<unsigned> data;
    for (std::size_t i = 0; i < size; ++i) {
      data.push_back(i < sizeof raw ? static_cast<unsigned>(raw >> 8 * i & 0xFF) : 0U);
    }
    return download(row.index, row.subindex, data);
  }
  /// Upload: the data, or the abort code.
  std::pair<std::uint32_t, std::vector<unsigned>> upload(std::uint16_t index, unsigned sub) {
    const auto answer = rig.sdo({0x40, index & 0xFFU, unsigned{index} >> 8, sub, 0, 0, 0, 0});
    if (answer.at(0) == 0x80) return {DriveRig::number(answer, 4), {}};
    return {kDone, {answer.begin() + 4, answer.end()}};
  }
  /// The download is refused with `code` and the value stays as it is.
  void expect_refused(const EntryRow& row, std::uint64_t raw, std::size_t size, std::uint32_t code) {
    const auto before = upload(row.index, row.subindex);
    EXPECT_EQ(download(row, raw, size), code) << std::hex << row.index << ':' << int{row.subindex} << " = " << raw;
    EXPECT_EQ(upload(row.index, row.subindex), before) << std::hex << row.index << ':' << int{row.subindex};
  }
};

bool writable(const EntryRow& row) {
  return (row.access & access::kWrite) != 0;
}

TEST_P(MsdAdversary, ObjectsThatDoNotExist) {
  for (std::uint32_t index = 0; index <= 0xFFFF; ++index) {
    const auto i = static_cast<std::uint16_t>(index);
    if (!table().object(i).empty()) continue;
    ASSERT_EQ(upload(i, 0).first, kNoSuchObject) << std::hex << index;
    ASSERT_EQ(download(i, 0, {0, 0}), kNoSuchObject) << std::hex << index;
  }
}

TEST_P(MsdAdversary, SubindicesThatDoNotExist) {
  for (auto rows = table().next_object(0); !rows.empty(); rows = table().next_object(rows.front().index)) {
    const auto index = rows.front().index;
    for (unsigned sub = 0; sub <= 0xFF; ++sub) {
      if (table().find(index, static_cast<std::uint8_t>(sub)) != nullptr) continue;
      ASSERT_EQ(upload(index, sub).first, kNoSuchSubindex) << std::hex << index << ':' << sub;
      ASSERT_EQ(download(index, sub, {0, 0}), kNoSuchSubindex) << std::hex << index << ':' << sub;
    }
  }
}

TEST_P(MsdAdversary, NothingIsWriteOnlyAndReadOnlyStaysSo) {
  for (const auto& row : table().rows()) {
    EXPECT_EQ(upload(row.index, row.subindex).first, kDone) << std::hex << row.index;
    if (writable(row)) continue;
    for (const std::size_t size : {std::size_t{1}, byte_size(row), std::size_t{5}}) {
      expect_refused(row, 1, size, kWriteToReadOnly);
    }
  }
}

TEST_P(MsdAdversary, ValuesOfTheWrongLength) {
  for (const auto& row : table().rows()) {
    if (!writable(row)) continue;
    const auto size = byte_size(row);
    if (is_string(row.type)) {
      expect_refused(row, 0x4141, size + 1, kTooLong);
      continue;
    }
    expect_refused(row, 0, size + 1, kTooLong);
    expect_refused(row, 0, size + 4, kTooLong);
    for (std::size_t shorter = 0; shorter < size; ++shorter) expect_refused(row, 0, shorter, kTooShort);
  }
}

TEST_P(MsdAdversary, ValuesOutOfRange) {
  std::size_t tried = 0;
  for (const auto& row : table().rows()) {
    if (!writable(row) || is_string(row.type) || row.type == esi::DataType::kReal32) continue;
    const auto size = byte_size(row.type);
    const double bits = static_cast<double>(8 * size);
    const double most = is_signed(row.type) ? std::exp2(bits - 1) - 1 : std::exp2(bits) - 1;
    const double least = is_signed(row.type) ? -std::exp2(bits - 1) : 0.0;
    if (row.maximum < most) {
      for (const double value : {row.maximum + 1, most}) {
        expect_refused(row, raw_from_number(row.type, value), size, kTooHigh);
        ++tried;
      }
    }
    if (row.minimum > least) {
      for (const double value : {row.minimum - 1, least}) {
        expect_refused(row, raw_from_number(row.type, value), size, kTooLow);
        ++tried;
      }
    }
  }
  EXPECT_GT(tried, 100U);
}

TEST_P(MsdAdversary, RealNumbersThatAreNoneOrOutOfRange) {
  using Limits = std::numeric_limits<float>;
  std::size_t tried = 0;
  for (const auto& row : table().rows()) {
    if (row.type != esi::DataType::kReal32) continue;
    const bool parameter = row.index >= 0x2000 && row.index < 0x6000;
    EXPECT_TRUE(parameter || (row.access & access::kRxMappable) == 0)
        << "process data have no range check but for device parameters: " << std::hex << row.index;
    if (!writable(row)) continue;
    EXPECT_TRUE(std::isfinite(row.minimum) && std::isfinite(row.maximum)) << std::hex << row.index;
    const auto refuse = [&](float value, std::uint32_t code) {
      expect_refused(row, std::bit_cast<std::uint32_t>(value), 4, code);
      ++tried;
    };
    for (const float value : {Limits::quiet_NaN(), -Limits::quiet_NaN(), Limits::signaling_NaN(), Limits::infinity(),
                              -Limits::infinity()}) {
      refuse(value, kRange);
    }
    refuse(std::nextafter(static_cast<float>(row.maximum), Limits::infinity()), kTooHigh);
    refuse(Limits::max(), kTooHigh);
    refuse(-Limits::max(), kTooLow);
  }
  EXPECT_GT(tried, 100U);
}

TEST_P(MsdAdversary, WrongStatesOfNetworkAndDrive) {
  rig.operate();
  for (const auto& row : table().rows()) {
    const bool pre_op_only = writable(row) && (row.access & access::kWriteOperating) == 0;
    if (pre_op_only) expect_refused(row, 0, byte_size(row), kWrongState);
  }
  rig.enable(8);
  std::size_t locked = 0;
  for (const auto& row : table().rows()) {
    if (!row.power_off_only) continue;
    expect_refused(row, 0, byte_size(row), kWrongState);
    ++locked;
  }
  EXPECT_GT(locked, 10U);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled) << "what is refused disturbs nothing";
}

TEST_P(MsdAdversary, MappingOfEveryRowInEitherDirection) {
  for (const auto& row : table().rows()) {
    const auto bits = static_cast<std::uint32_t>(bit_size(row));
    const std::uint32_t address = std::uint32_t{row.index} << 16 | std::uint32_t{row.subindex} << 8;
    for (const auto& [pdo, flag] : {std::pair(0x1600, access::kRxMappable), std::pair(0x1A00, access::kTxMappable)}) {
      const auto index = static_cast<std::uint16_t>(pdo);
      const bool can = (row.access & flag) != 0;
      if (bits <= 0xFF) {
        EXPECT_EQ(rig.write(index, 1, address | bits, 4), can ? kDone : kNotMappable) << std::hex << row.index;
      }
      for (const std::uint32_t wrong : {0U, 1U, bits - 1, bits + 1, 64U}) {
        if (wrong == bits || wrong > 0xFF) continue;
        EXPECT_EQ(rig.write(index, 1, address | wrong, 4), kNotMappable) << std::hex << row.index << ' ' << wrong;
      }
    }
  }
}

TEST_P(MsdAdversary, MappingsAndAssignmentsThatAreTooLong) {
  for (const unsigned first : {0x1600U, 0x1A00U}) {
    for (unsigned pdo = first; pdo < first + 4; ++pdo) {
      const auto index = static_cast<std::uint16_t>(pdo);
      for (unsigned sub = 1; sub <= 8; ++sub) ASSERT_EQ(rig.write(index, sub, 0x28070008, 4), kDone);
      EXPECT_EQ(rig.write(index, 9, 0x28070008, 4), kNoSuchSubindex);
      for (unsigned count = 9; count <= 0xFF; ++count) ASSERT_EQ(rig.write(index, 0, count, 1), 0x06040042U) << count;
      ASSERT_EQ(rig.write(index, 0, 8, 1), kDone);
      ASSERT_EQ(rig.write(index, 8, 0, 4), 0x06010003U) << "entries only while sub-index 0 is 0";
      ASSERT_EQ(rig.write(index, 0, 0, 1), kDone);
      ASSERT_EQ(rig.write(index, 8, 0x60640020, 4), first == 0x1600U ? kNotMappable : kDone);
      ASSERT_EQ(rig.write(index, 8, 0x607A0020, 4), kDone);
      EXPECT_EQ(rig.write(index, 0, 8, 1), 0x06040042U) << "eleven bytes";
    }
  }
  for (const std::uint16_t assignment : {std::uint16_t{0x1C12}, std::uint16_t{0x1C13}}) {
    EXPECT_EQ(rig.write(assignment, 0, 5, 1), kTooHigh);
    ASSERT_EQ(rig.write(assignment, 0, 0, 1), kDone);
    EXPECT_EQ(rig.write(assignment, 1, assignment == 0x1C12 ? 0x1A00 : 0x1600, 2), kNoSuchObject);
    EXPECT_EQ(rig.write(assignment, 1, 0x1604, 2), kNoSuchObject);
  }
}

/// Values at and beyond the ends of their ranges, by process data, which cannot be refused: every mode, every writable
/// mappable object, while the axis is enabled.
TEST_P(MsdAdversary, ExtremeProcessDataKeepThePlantFinite) {
  std::vector<const EntryRow*> targets;
  for (const auto& row : table().rows()) {
    const bool fixed = row.index == 0x6040 || row.index == 0x6060 || row.index == 0x2807;
    if ((row.access & access::kRxMappable) != 0 && row.index >= 0x6000 && !fixed) targets.push_back(&row);
  }
  ASSERT_GT(targets.size(), 15U);
  std::mt19937 random(7);
  for (const EntryRow* row : targets) {
    const auto size = static_cast<std::uint32_t>(byte_size(row->type));
    OperatingRig axis(parameters());
    axis.to(AlState::kOp, AlState::kPreOp);
    axis.map(0x1603, {std::uint32_t{row->index} << 16 | std::uint32_t{row->subindex} << 8 | 8 * size});
    ASSERT_EQ(axis.to(AlState::kPreOp, AlState::kSafeOp), AlStatusCode::kNoError);
    ASSERT_EQ(axis.to(AlState::kSafeOp, AlState::kOp), AlStatusCode::kNoError);
    for (const unsigned mode : {1U, 2U, 3U, 6U, 7U, 8U, 9U, 10U}) {
      std::array<std::byte, 24> out{};
      for (int cycle = 0; cycle < 400; ++cycle) {
        constexpr std::array<std::uint32_t, 6> kEnds = {0, 1, 0xFFFFFFFF, 0x7FFFFFFF, 0x80000000, 0x00008000};
        const bool enabling = cycle < 8;
        const std::uint16_t steps[] = {0x80, 0x00, 0x06, 0x06, 0x07, 0x07, 0x0F, 0x0F};
        bytes::store_le(std::span(out),
                        enabling ? steps[cycle] : static_cast<std::uint16_t>((random() & 0x017FU) | 0x0FU));
        bytes::store_le(std::span(out).subspan(2), static_cast<std::uint8_t>(mode));
        bytes::store_le(std::span(out).subspan(20), kEnds[random() % kEnds.size()]);
        for (std::size_t i = 4; i < 20; i += 2) {
          if (cycle % 40 == 0) bytes::store_le(std::span(out).subspan(i), static_cast<std::uint16_t>(random()));
        }
        axis.device.write_outputs(2, std::span(out).first(20 + size));
        axis.pass(125us);
        ASSERT_TRUE(std::isfinite(axis.drive.position_rad())) << std::hex << row->index << " mode " << mode;
        ASSERT_TRUE(std::isfinite(axis.drive.torque_nm())) << std::hex << row->index << " mode " << mode;
        ASSERT_LE(std::abs(axis.drive.velocity_rad_s()), 720.0) << std::hex << row->index << " mode " << mode;
        ASSERT_LE(std::abs(axis.drive.torque_nm()), 7.3) << std::hex << row->index << " mode " << mode;
      }
    }
  }
}

/// Every parameter at either end of its range and at its smallest step beyond zero, with the axis enabled and moving.
TEST_P(MsdAdversary, ParametersAtTheEndsOfTheirRangesKeepThePlantFinite) {
  for (const auto& row : table().rows()) {
    if (!writable(row) || is_string(row.type) || row.index < 0x2000) continue;
    const auto size = byte_size(row.type);
    OperatingRig axis(parameters());
    for (const unsigned mode : {8U, 3U, 1U}) {
      for (const double wanted : {row.minimum, row.maximum, 0.0, 1e-30}) {
        const double bits = static_cast<double>(8 * size);
        const bool real = row.type == esi::DataType::kReal32;
        const double most = real ? 3e38 : is_signed(row.type) ? std::exp2(bits - 1) - 1 : std::exp2(bits) - 1;
        const double least = real ? -3e38 : is_signed(row.type) ? -std::exp2(bits - 1) : 0.0;
        axis.mode = static_cast<std::int8_t>(mode);
        for (const std::uint16_t word : {std::uint16_t{0x80}, std::uint16_t{0}, std::uint16_t{6}, std::uint16_t{7},
                                         std::uint16_t{15}}) {  // as far as the parameters allow
          axis.command(word, 2);
        }
        const auto raw = raw_from_number(row.type, std::clamp(wanted, least, most));
        axis.write(row.index, row.subindex, static_cast<std::uint32_t>(raw), static_cast<unsigned>(size));
        axis.target_position += 20'000;
        axis.target_velocity = 3'000'000;
        for (int i = 0; i < 40; ++i) {
          axis.control ^= 0x10;
          axis.cycle();
          ASSERT_TRUE(std::isfinite(axis.drive.position_rad()) && std::isfinite(axis.drive.torque_nm()))
              << std::hex << row.index << ':' << int{row.subindex} << " = " << wanted << " mode " << mode;
        }
      }
    }
  }
}

TEST_P(MsdAdversary, ModesChangedInMotionNeverJump) {
  std::mt19937 random(3);
  ASSERT_EQ(rig.write(0x6072, 0, 1000, 2), 0U);  // the plant could deliver three times as much
  rig.start(8);
  constexpr std::array<std::int8_t, 9> kModes = {1, 2, 3, 6, 7, 8, 9, 10, 0};
  double before = rig.drive.velocity_rad_s();
  // Largest change of speed in a bus cycle: the torque limit over the inertia, and friction that helps.
  const double most = 2.43 / MotorParameters{}.inertia_kg_m2 * 125e-6 * 1.1;
  for (int i = 0; i < 8000; ++i) {
    if (i % 20 == 0) {
      rig.mode = kModes[random() % kModes.size()];
      rig.target_velocity = static_cast<std::int32_t>(random() % 20'000'000) - 10'000'000;
      rig.target_position = rig.position + static_cast<std::int32_t>(random() % 20'000) - 10'000;
      rig.target_torque = static_cast<std::int16_t>(static_cast<int>(random() % 400) - 200);
      rig.control = static_cast<std::uint16_t>(0x000F | (random() & 0x0070));
    }
    rig.cycle();
    const double now = rig.drive.velocity_rad_s();
    ASSERT_LE(std::abs(now - before), most) << "cycle " << i << " mode " << int{rig.mode};
    before = now;
    if (rig.drive.state() != PowerState::kOperationEnabled) {  // a following error is a valid reaction
      rig.command(0x80, 400);
      rig.enable(8);
      before = rig.drive.velocity_rad_s();
    }
  }
}

TEST_P(MsdAdversary, ModesThatDoNotExistLeaveTheOneThatRuns) {
  rig.start(9);
  rig.turn(2'000'000, 800);
  for (int mode = -128; mode <= 127; ++mode) {
    const bool exists = mode >= 0 && mode <= 10 && mode != 4 && mode != 5;
    if (exists) continue;
    rig.mode = static_cast<std::int8_t>(mode);
    rig.cycles(4);
    ASSERT_EQ(rig.read(0x6061), 9U) << mode;
    ASSERT_NEAR(rig.velocity, 2'000'000, 30'000) << mode;
  }
}

INSTANTIATE_TEST_SUITE_P(Variants, MsdAdversary,
                         testing::Values(Variant::kMsd, Variant::kServoOne, Variant::kServoOneJunior));

/// Parameters given in C++ are checked like values from the bus.
TEST(MsdAdversary, ParametersThatAreNotFiniteNeverReachTheDictionary) {
  using Limits = std::numeric_limits<double>;
  for (const double value : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), -1.0, Limits::max()}) {
    SCOPED_TRACE(value);
    MsdParameters parameters;
    auto& c = parameters.controller;
    c.position_gain_per_s = c.velocity_gain_nm_s = c.velocity_reset_s = c.velocity_filter_s = value;
    c.max_velocity_rad_s = c.max_torque_nm = value;
    parameters.dc_link_volts = value;
    DriveRig rig(parameters);
    for (const unsigned index : {0x2140U, 0x2141U, 0x215FU, 0x2168U, 0x219AU}) {  // the last: DC link
      const auto real = std::bit_cast<float>(rig.read(static_cast<std::uint16_t>(index)));
      EXPECT_TRUE(std::isfinite(real) && real >= 0.0F) << std::hex << index << ": " << real;
    }
    rig.operate();
    rig.pass(50ms);
    EXPECT_TRUE(std::isfinite(rig.drive.position_rad()));
  }
}

}  // namespace
}  // namespace driveline::slaves::msd
