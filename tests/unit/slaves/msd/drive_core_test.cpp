// The drive without EtherCAT: no slave controller, no AL state, no mailbox. A replacement for the bus writes and reads
// objects.
#include "driveline/slaves/msd/core/drive_core.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "driveline/slaves/msd/core/drive_table.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

using std::chrono_literals::operator""us;
using std::chrono_literals::operator""ms;

constexpr std::int8_t kCyclicPosition = 8;
constexpr std::uint16_t kEnable = 0x0F;
constexpr std::uint16_t kResetFault = 0x80;
constexpr std::int32_t kTurn = 1 << 20;  ///< increments

/// The drive's own rows form a complete dictionary.
const DictionaryTable& core_table() {
  static const DictionaryTable kTable({drive_rows(Variant::kMsd)}, kValue.end());
  return kTable;
}

/// Another bus: setpoints every 125 us, and its own faults.
class OtherBus : public testing::Test, private DriveBus {
 protected:
  OtherBus() {
    drive.restart();
    drive.enter_network_state(NetworkState::kPreOperational);
    pass(0ms);  // time begins
    pass(2ms);  // the self-test
    set_cycle(0.125F, 125, -6);
    drive.enter_network_state(NetworkState::kOperational);
  }

  void set_cycle(float milliseconds, std::uint8_t value, std::int8_t index) {
    write(kValue.reference_cycle, milliseconds);
    write(kValue.interpolation_period_value, value);
    write(kValue.interpolation_period_index, index);
  }
  /// Writes a parameter, like any service of the bus.
  template <typename T>
  void write(Slot<T> slot, T value) {
    drive.dictionary().set(slot, value);
    drive.written(row_of(slot.number));
  }
  static const EntryRow& row_of(std::uint16_t slot) {
    const auto rows = core_table().rows();
    return *std::find_if(rows.begin(), rows.end(),
                         [&](const EntryRow& row) { return !is_string(row.type) && row.slot == slot; });
  }
  void pass(std::chrono::nanoseconds time) { drive.advance(now += time); }
  /// Runs a cycle of the bus: outputs, time, inputs.
  void cycle() {
    drive.dictionary().set(kValue.control_word, control);
    drive.dictionary().set(kValue.mode, kCyclicPosition);
    drive.dictionary().set(kValue.target_position, target);
    drive.outputs_written();
    pass(125us);
    position = drive.dictionary().get(kValue.position_actual);
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  void enable() {
    target = drive.dictionary().get(kValue.position_actual);
    for (const std::uint16_t word : {std::uint16_t{0x06}, std::uint16_t{0x07}, kEnable}) {
      control = word;
      cycles(2);
    }
  }

  void report(const FaultMessage& message) noexcept override { messages.push_back(message); }
  [[nodiscard]] bool cause_persists(Fault fault) const noexcept override { return fault == broken; }
  void parameters_replaced() override {}

  DriveCore drive{MsdParameters{}, core_table(), *this};
  std::chrono::nanoseconds now{0};
  std::uint16_t control = 0;
  std::int32_t target = 0;
  std::int32_t position = 0;
  std::vector<FaultMessage> messages;
  Fault broken = Fault::kCount;  ///< fault reported by the bus
};

TEST_F(OtherBus, EnablesByControlWord) {
  EXPECT_EQ(drive.state(), PowerState::kSwitchOnDisabled);
  enable();
  EXPECT_EQ(drive.state(), PowerState::kOperationEnabled);
  EXPECT_EQ(drive.status() & 0x006F, 0x0027);
  EXPECT_TRUE(drive.power_on());
  control = 0;
  cycles(2);
  EXPECT_EQ(drive.state(), PowerState::kSwitchOnDisabled);
}

/// Two turns of the shaft in 0.1 s, smoothly; the axis reaches its target, in its own units and in radians.
TEST_F(OtherBus, FollowsAPosition) {
  enable();
  ASSERT_EQ(drive.state(), PowerState::kOperationEnabled);
  const std::int32_t start = target;
  constexpr int kCycles = 800;
  for (int i = 1; i <= kCycles; ++i) {
    const double share = 0.5 - 0.5 * std::cos(std::numbers::pi * i / kCycles);
    target = start + static_cast<std::int32_t>(std::lrint(2.0 * kTurn * share));
    cycle();
    ASSERT_LT(std::abs(position - target), kTurn / 20) << i;
  }
  cycles(800);
  EXPECT_NEAR(position, start + 2 * kTurn, 50);
  EXPECT_NEAR(drive.position_rad(), 4.0 * std::numbers::pi, 1e-3);
  EXPECT_TRUE(messages.empty());
}

TEST_F(OtherBus, IsToldOfFaultsAndAcknowledgesThem) {
  enable();
  drive.set_cause(Fault::kOvercurrent, true);
  cycles(16);
  EXPECT_EQ(drive.fault(), Fault::kOvercurrent);
  EXPECT_EQ(drive.state(), PowerState::kFault);
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].error_code, facts(Fault::kOvercurrent).error_code);
  EXPECT_EQ(drive.dictionary().get(kValue.error_code), facts(Fault::kOvercurrent).error_code);

  drive.set_cause(Fault::kOvercurrent, false);
  control = kResetFault;
  cycles(2);
  EXPECT_EQ(drive.fault(), std::nullopt);
  EXPECT_EQ(drive.state(), PowerState::kSwitchOnDisabled);
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[1].error_code, 0);
  enable();
  EXPECT_EQ(drive.state(), PowerState::kOperationEnabled);
}

TEST_F(OtherBus, AFaultOfTheBusStaysWhileTheBusSaysSo) {
  broken = Fault::kEepromData;
  drive.raise(Fault::kEepromData);
  cycles(2);
  ASSERT_EQ(drive.state(), PowerState::kFault);
  drive.press_buttons();
  EXPECT_EQ(drive.fault(), Fault::kEepromData);
  EXPECT_EQ(messages.size(), 3U) << "raised, acknowledged, raised again";
  broken = Fault::kCount;
  cycles(2);
  drive.press_buttons();
  EXPECT_EQ(drive.fault(), std::nullopt);
}

TEST_F(OtherBus, ShowsHowFarTheBusIs) {
  pass(1ms);
  EXPECT_EQ(drive.dictionary().get(kValue.nmt_state), 5);
  drive.enter_network_state(NetworkState::kPreOperational);
  EXPECT_EQ(drive.dictionary().get(kValue.nmt_state), 127);
  drive.restart();
  EXPECT_EQ(drive.dictionary().get(kValue.nmt_state), 0) << "the self-test";
}

TEST_F(OtherBus, RefusesValuesThatMakeNoSense) {
  const EntryRow& mode = row_of(kValue.mode.number);
  EXPECT_TRUE(drive.accept(mode, static_cast<std::uint64_t>(kCyclicPosition)));
  EXPECT_FALSE(drive.accept(mode, 4)) << "no such mode";
  write(kValue.position_limit_max, 100);
  EXPECT_FALSE(drive.accept(row_of(kValue.position_limit_min.number), 101)) << "beyond the other limit";
}

/// The signals of the machine do not need a bus, either.
TEST_F(OtherBus, HearsItsMachineByName) {
  const auto enpo = drive.signals().find_signal(SignalId::Direction::kInput, "ENPO");
  ASSERT_TRUE(enpo);
  enable();
  drive.signals().set_signal(enpo->number, 0.0);
  cycles(2);
  EXPECT_EQ(drive.state(), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(drive.signals().signal(*enpo), 0.0);
}

/// A complete dictionary, without objects of a particular bus.
TEST(DriveTable, HasNoObjectsOfEtherCat) {
  const auto rows = core_table().rows();
  EXPECT_GT(rows.size(), 200U);
  for (const EntryRow& row : rows) {
    const bool process_data = row.index >= 0x1600 && row.index < 0x2000;
    EXPECT_FALSE(process_data || row.index == 0x10F1) << std::hex << row.index;
  }
}

/// The values of the dictionary are typed: rows have the type of their slot.
template <typename T, typename Place>
concept ReadableAs = requires(const ObjectDictionary& dictionary, Place place) {
  dictionary.get<T>(place);
};
static_assert(ReadableAs<float, decltype(kValue.velocity_gain)>);
static_assert(!ReadableAs<double, decltype(kValue.velocity_gain)>);
static_assert(!ReadableAs<std::int32_t, decltype(kValue.target_torque)>);

}  // namespace
}  // namespace driveline::slaves::msd
