#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
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

 private:
  /// Capacity of the message queue.
  static constexpr std::size_t kMaxMessages = 16;

  [[nodiscard]] SoeAnswer<void> write_value(const IdnRow& row, const SoeAccess& access,
                                            std::span<const std::byte> data);
  [[nodiscard]] SoeAnswer<void> command(const IdnRow& row, std::uint8_t drive, std::uint16_t order);

  std::vector<IdnValues> drives_;
  std::array<SoeMessage, kMaxMessages> messages_{};
  std::size_t oldest_ = 0;
  std::size_t waiting_ = 0;
};

}  // namespace driveline::slaves
