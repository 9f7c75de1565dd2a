#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "driveline/slaves/mailbox/soe_table.hpp"

namespace driveline::slaves::generic {

/// Operation data of the drives of a device, all at rest: S-0-0001, 0011, 0014, 0017, 0040, 0051, 0095, 0099, 0100 and
/// 0142. With process data also S-0-0016 and S-0-0024, which say what is exchanged cyclically and can be written in
/// PREOP, S-0-0187 and S-0-0188, which say what may be, and S-0-0036, 0047, 0134 and 0135. Where the standard leaves
/// type, limits and default to the manufacturer, they are ours.
class SoeDrives final : public SoeTable {
 public:
  /// Time that S-0-0099 (reset class 1 diagnostic) takes.
  static constexpr std::chrono::milliseconds kResetTime{2};
  /// A mail names one of so many.
  static constexpr std::size_t kMaxDrives = 8;

  /// What the drives exchange cyclically.
  enum class ProcessData : std::uint8_t {
    kNone,    ///< nothing that they know of
    kByLists  ///< what S-0-0016 and S-0-0024 name
  };

  /// `count`: 1 to kMaxDrives.
  explicit SoeDrives(std::size_t count, ProcessData process_data = ProcessData::kNone);

  /// Bytes of the MDTs of all drives: of each its master control word, and what S-0-0024 names. \rtsafe
  [[nodiscard]] std::size_t outputs_size() noexcept;
  /// Bytes of the ATs of all drives: of each its drive status word, and what S-0-0016 names. \rtsafe
  [[nodiscard]] std::size_t inputs_size() noexcept;
  /// The MDTs have come, drive after drive; a drive follows its commands at once. \rtsafe
  void write_outputs(std::span<const std::byte> data) noexcept;
  /// The ATs, drive after drive. \rtsafe
  void read_inputs(std::span<std::byte> data) noexcept;
  /// All that the MDTs bring becomes 0. \rtsafe
  void clear_outputs() noexcept;

  /// The process data have stopped to come: S-0-0011, S-0-0014 and S-0-0095 tell it, and the master hears an emergency
  /// of each drive. \rtsafe
  void communication_failed() noexcept;
  /// Brings procedure commands to their end when it is time. \rtsafe
  void advance(std::chrono::nanoseconds now) noexcept;

 private:
  [[nodiscard]] SoeAnswer<void> start_command(std::uint8_t drive, wire::Idn idn) override;
  [[nodiscard]] SoeAnswer<void> check_value(std::uint8_t drive, wire::Idn idn,
                                            std::span<const std::byte> value) override;
  /// Calls `visit` with the value of each operation datum that a telegram carries, in its order.
  template <typename Visit>
  void for_each_cyclic(wire::Idn word, wire::Idn list, Visit&& visit) noexcept;
  void follow_commands() noexcept;
  void set(std::uint8_t drive, wire::Idn idn, std::uint16_t value) noexcept;
  void set_diagnosis(std::uint8_t drive, std::string_view text) noexcept;
  void advance(std::uint8_t drive) noexcept;

  bool cyclic_;
  std::chrono::nanoseconds now_{0};
  /// Of each drive; nothing: no reset is in progress.
  std::vector<std::optional<std::chrono::nanoseconds>> resets_over_;
};

}  // namespace driveline::slaves::generic
