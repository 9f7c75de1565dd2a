#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/slaves/idn/idn_values.hpp"
#include "driveline/slaves/mailbox/soe_parameters.hpp"

namespace driveline::slaves {

/// Operation data of a device's drives: elements by IDN with all checks of the table for the master, and values by
/// typed slot for the application. Checks lengths, limits and write protection of the master's writes, and stores the
/// data states of procedure commands.
class IdnDictionary : public SoeParameters {
 public:
  /// Table of each drive, for at most eight drives. Allocates the memory of all values in advance; the tables must
  /// outlive this.
  explicit IdnDictionary(const std::vector<const IdnTable*>& drives);

  /// Returns the values of a drive. Precondition: has_drive(drive). \rtsafe
  [[nodiscard]] IdnValues& values(std::uint8_t drive) noexcept { return drives_[drive]; }
  /// See values() above; read only. \rtsafe
  [[nodiscard]] const IdnValues& values(std::uint8_t drive) const noexcept { return drives_[drive]; }
  /// Ends a procedure command in progress and notifies the master; other commands do not change. \rtsafe
  void end_command(std::uint8_t drive, wire::Idn idn, wire::SoeCommandState state) noexcept;
  /// Queues a message for the master; when the queue is full, the oldest message is dropped. \rtsafe
  void say(const SoeMessage& message) noexcept;

  [[nodiscard]] bool has_drive(std::uint8_t drive) const noexcept override { return drive < drives_.size(); }
  [[nodiscard]] SoeAnswer<std::vector<std::byte>> read_element(const SoeAccess& access) override;
  [[nodiscard]] SoeAnswer<void> write_element(const SoeAccess& access, std::span<const std::byte> data) override;
  [[nodiscard]] std::optional<SoeMessage> next_message() override;

 protected:
  /// Called when the master starts a procedure command. Unless refused, the command is in progress until end_command().
  [[nodiscard]] virtual SoeAnswer<void> start_command(std::uint8_t drive, wire::Idn idn) = 0;
  /// Checks a value with valid length, limits and write protection; of a list, its content without the list header.
  [[nodiscard]] virtual SoeAnswer<void> check_value(std::uint8_t /*drive*/, wire::Idn /*idn*/,
                                                    std::span<const std::byte> /*value*/) {
    return {};
  }
  /// Called after a value that is no procedure command has been stored.
  virtual void written(std::uint8_t /*drive*/, wire::Idn /*idn*/) {}

  /// \name Where values and units are
  /// In IdnValues and in the row, unless a device keeps some of them elsewhere.
  /// @{

  /// Returns the value of a row that is_number(), as bits.
  [[nodiscard]] virtual std::uint64_t number(std::uint8_t drive, const IdnRow& row) const noexcept {
    return drives_[drive].raw(row);
  }
  /// Stores the value of a row that is_number(), as bits; it has been checked.
  virtual void set_number(std::uint8_t drive, const IdnRow& row, std::uint64_t raw) noexcept {
    drives_[drive].set_raw(row, raw);
  }
  /// Returns the content of a list or text that does not follow from the table; valid until the next call.
  [[nodiscard]] virtual std::span<const std::byte> content(std::uint8_t drive, const IdnRow& row) const noexcept {
    return drives_[drive].get(Slot<IdnList>{row.slot});
  }
  /// Stores the content of a list or text, at most as long as its capacity.
  virtual void set_content(std::uint8_t drive, const IdnRow& row, std::span<const std::byte> content) {
    drives_[drive].set(Slot<IdnList>{row.slot}, content);
  }
  /// Returns the attribute for the master; length, list and command are those of the row.
  [[nodiscard]] virtual wire::SoeAttribute attribute(std::uint8_t /*drive*/, const IdnRow& row) const noexcept {
    return row.attribute;
  }
  /// Returns the unit for the master; empty: none.
  [[nodiscard]] virtual std::string unit(std::uint8_t /*drive*/, const IdnRow& row) const {
    return std::string(row.unit);
  }
  /// @}

 private:
  /// Capacity of the message queue.
  static constexpr std::size_t kMaxMessages = 16;

  [[nodiscard]] std::vector<std::byte> value_of(std::uint8_t drive, const IdnRow& row) const;
  [[nodiscard]] SoeAnswer<void> write_value(const IdnRow& row, const SoeAccess& access,
                                            std::span<const std::byte> data);
  [[nodiscard]] SoeAnswer<void> command(const IdnRow& row, std::uint8_t drive, std::uint16_t order);

  std::vector<IdnValues> drives_;
  std::array<SoeMessage, kMaxMessages> messages_{};
  std::size_t oldest_ = 0;
  std::size_t waiting_ = 0;
};

}  // namespace driveline::slaves
