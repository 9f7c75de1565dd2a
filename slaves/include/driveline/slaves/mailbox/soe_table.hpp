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
  wire::Idn idn;                    ///< its number
  std::string name;                 ///< empty: it has none
  wire::SoeAttribute attribute;     ///< length, display, write protection
  std::string unit{};               ///< empty: it has none
  std::vector<std::byte> value{};   ///< little endian; of a list what is in it
  std::vector<std::byte> min{};     ///< empty: it has none
  std::vector<std::byte> max{};     ///< empty: it has none
  std::vector<std::byte> preset{};  ///< its default; empty: it has none
  std::uint16_t capacity = 0;       ///< of a list: most bytes
  wire::SoeCommandState state{};    ///< of a procedure command
};

/// The operation data of the drives of a device as a table. Checks lengths, limits and write protection of what the
/// master writes, and keeps the data state of procedure commands. S-0-0017, if it is there, lists what there is.
class SoeTable : public SoeParameters {
 public:
  /// Rows of each drive, at most eight drives.
  explicit SoeTable(std::vector<std::vector<SoeRow>> drives);

  /// The row; null: there is none. Its value may be set; a list has room for its capacity. \rtsafe
  [[nodiscard]] SoeRow* find(std::uint8_t drive, wire::Idn idn) noexcept;
  /// A procedure command that is in progress has come to its end, which the master is told; other ones stay as they
  /// are. \rtsafe
  void end_command(std::uint8_t drive, wire::Idn idn, wire::SoeCommandState state) noexcept;
  /// Tells the master. \rtsafe
  void say(const SoeMessage& message) noexcept;

  [[nodiscard]] bool has_drive(std::uint8_t drive) const noexcept override { return drive < drives_.size(); }
  [[nodiscard]] SoeAnswer<std::vector<std::byte>> read_element(const SoeAccess& access) override;
  [[nodiscard]] SoeAnswer<void> write_element(const SoeAccess& access, std::span<const std::byte> data) override;
  [[nodiscard]] std::optional<SoeMessage> next_message() override;

 protected:
  /// The master has started a procedure command, which is in progress until end_command(). Refused: it is not.
  [[nodiscard]] virtual SoeAnswer<void> start_command(std::uint8_t drive, wire::Idn idn) = 0;
  /// The row may have this value, which its length, limits and write protection allow; of a list what is in it.
  [[nodiscard]] virtual SoeAnswer<void> check_value(std::uint8_t /*drive*/, wire::Idn /*idn*/,
                                                    std::span<const std::byte> /*value*/) {
    return {};
  }

 private:
  /// Messages that wait for the master; the oldest goes first.
  static constexpr std::size_t kMaxMessages = 16;

  [[nodiscard]] SoeAnswer<void> write_value(SoeRow& row, const SoeAccess& access, std::span<const std::byte> data);
  [[nodiscard]] SoeAnswer<void> command(SoeRow& row, std::uint8_t drive, std::span<const std::byte> data);

  std::vector<std::vector<SoeRow>> drives_;
  std::array<SoeMessage, kMaxMessages> messages_{};
  std::size_t oldest_ = 0;
  std::size_t waiting_ = 0;
};

}  // namespace driveline::slaves
