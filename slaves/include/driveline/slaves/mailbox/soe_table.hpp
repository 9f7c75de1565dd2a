#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "driveline/slaves/mailbox/soe_parameters.hpp"
#include "driveline/wire/soe.hpp"

namespace driveline::slaves {

/// An operation datum with its elements.
struct SoeRow {
  wire::Idn idn;                    ///< number of the operation datum
  std::string name;                 ///< empty: none
  wire::SoeAttribute attribute;     ///< length, display, write protection
  std::string unit{};               ///< empty: none
  std::vector<std::byte> value{};   ///< little endian; of a list, its content without the list header
  std::vector<std::byte> min{};     ///< empty: none
  std::vector<std::byte> max{};     ///< empty: none
  std::vector<std::byte> preset{};  ///< default value; empty: none
  std::uint16_t capacity = 0;       ///< maximum size of a list in bytes
  wire::SoeCommandState state{};    ///< data state, of a procedure command
};

/// Table of the operation data of a device's drives. Checks lengths, limits and write protection of the master's
/// writes, and stores the data state of procedure commands. S-0-0017, if present, is set to the list of all operation
/// data of the drive.
class SoeTable : public SoeParameters {
 public:
  /// Rows of each drive, for at most eight drives.
  explicit SoeTable(std::vector<std::vector<SoeRow>> drives);

  /// Returns the row; null: there is none. Its value may be set; a list has memory for its capacity. \rtsafe
  [[nodiscard]] SoeRow* find(std::uint8_t drive, wire::Idn idn) noexcept;
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

 private:
  /// Capacity of the message queue.
  static constexpr std::size_t kMaxMessages = 16;

  [[nodiscard]] SoeAnswer<void> write_value(SoeRow& row, const SoeAccess& access, std::span<const std::byte> data);
  [[nodiscard]] SoeAnswer<void> command(SoeRow& row, std::uint8_t drive, std::span<const std::byte> data);

  std::vector<std::vector<SoeRow>> drives_;
  std::array<SoeMessage, kMaxMessages> messages_{};
  std::size_t oldest_ = 0;
  std::size_t waiting_ = 0;
};

}  // namespace driveline::slaves
