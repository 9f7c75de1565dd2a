#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "driveline/slaves/msd/core/drive_core.hpp"
#include "driveline/slaves/msd/core/drive_table.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_values.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_words.hpp"

namespace driveline::slaves::msd {

using std::chrono_literals::operator""us;
using std::chrono_literals::operator""ms;

inline constexpr double kTurnRad = 2.0 * std::numbers::pi;
inline constexpr double kUnitRad = kTurnRad / 3'600'000;  ///< of positions in the preferred weighting
inline constexpr double kSpeedUnit = 1e-4 * kRpm;         ///< of speeds
inline constexpr std::int32_t kTurn = 3'600'000;          ///< position units

/// A whole drive without a bus on virtual time: a test writes values, as a front end does, and passes cycles of 125 us.
class CoreRig : private DriveBus {
 public:
  CoreRig(const DictionaryTable& table, ProfileKind profile, const MsdParameters& parameters = {})
      : drive(parameters, table, *this, profile), table_(&table) {
    drive.restart();
    drive.enter_network_state(NetworkState::kPreOperational);
    pass(0ms);
    pass(2ms);
  }

  /// Writes a value like a service of the bus.
  template <typename T>
  void write(Slot<T> slot, T value) {
    drive.dictionary().set(slot, value);
    const auto rows = table_->rows();
    const auto row = std::find_if(rows.begin(), rows.end(),
                                  [&](const EntryRow& one) { return !is_string(one.type) && one.slot == slot.number; });
    // Some values have their row in the table of a bus, which is not here.
    if (row != rows.end()) drive.written(*row);
  }
  /// Sets a value as process data, which count with the next cycle.
  template <typename T>
  void send(Slot<T> slot, T value) {
    drive.process_values().set(slot, value);
  }
  template <typename T>
  [[nodiscard]] T get(Slot<T> slot) {
    return drive.complete_values().get(slot);
  }
  void pass(std::chrono::nanoseconds time) { drive.advance(now_ += time); }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) {
      drive.outputs_written();
      pass(125us);
    }
  }
  /// Passes cycles and returns the speed of the shaft in each.
  [[nodiscard]] std::vector<double> speeds(int count) {
    std::vector<double> all;
    for (int i = 0; i < count; ++i) {
      cycles(1);
      all.push_back(drive.velocity_rad_s());
    }
    return all;
  }

  DriveCore drive;

 private:
  void report(const FaultMessage& /*message*/) noexcept override {}
  [[nodiscard]] bool cause_persists(Fault /*fault*/) const noexcept override { return false; }
  void parameters_replaced() override {}

  const DictionaryTable* table_;
  std::chrono::nanoseconds now_{0};
};

inline const DictionaryTable& sercos_table() {
  static const DictionaryTable kTable({sercos_drive_rows(Variant::kServoOne)}, kSercosValue.end());
  return kTable;
}

/// A drive with SERCOS in phase 4, setpoints every 125 us.
class SercosRig : public CoreRig {
 public:
  explicit SercosRig(std::uint16_t mode, const MsdParameters& parameters = {})
      : CoreRig(sercos_table(), ProfileKind::kSercos, parameters) {
    write(kSercosValue.control_cycle, std::uint16_t{125});
    write(kSercosValue.modes[0], mode);
    drive.enter_network_state(NetworkState::kOperational);
  }

  void control(std::uint16_t word, int count = 2) {
    send(kSercosValue.control_word, word);
    cycles(count);
  }
  [[nodiscard]] std::uint16_t status() { return get(kSercosValue.status_word); }
  /// Enables by edge; the position command is the actual position.
  void enable() {
    send(kSercosValue.position_command, get(kValue.position_actual));
    send(kSercosValue.target_position, get(kValue.position_actual));
    for (const std::uint16_t word : {std::uint16_t{0}, std::uint16_t{0x4000}, std::uint16_t{0xE000}}) control(word, 4);
    ASSERT_EQ(drive.state(), PowerState::kOperationEnabled);
  }
};

/// The same motor with the profile CiA 402, setpoints every 125 us.
class SiblingRig : public CoreRig {
 public:
  explicit SiblingRig(std::int8_t mode) : CoreRig(table(), ProfileKind::kCia402), mode_(mode) {
    write(kValue.reference_cycle, 0.125F);
    write(kValue.interpolation_period_value, std::uint8_t{125});
    write(kValue.interpolation_period_index, std::int8_t{-6});
    write(kValue.interpolation_type, std::uint8_t{3});
    drive.enter_network_state(NetworkState::kOperational);
  }

  void enable() {
    send(kValue.target_position, get(kValue.position_actual));
    send(kValue.mode, mode_);
    for (const std::uint16_t word : {std::uint16_t{0x06}, std::uint16_t{0x07}, std::uint16_t{0x0F}}) {
      send(kValue.control_word, word);
      cycles(4);
    }
    ASSERT_EQ(drive.state(), PowerState::kOperationEnabled);
  }

 private:
  static const DictionaryTable& table() {
    static const DictionaryTable kTable({drive_rows(Variant::kServoOne)}, kValue.end());
    return kTable;
  }

  std::int8_t mode_;
};

}  // namespace driveline::slaves::msd
