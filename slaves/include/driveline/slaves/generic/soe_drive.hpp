#pragma once

#include <chrono>
#include <optional>
#include <string_view>

#include "driveline/slaves/mailbox/soe_table.hpp"

namespace driveline::slaves::generic {

/// Operation data of a drive at rest: S-0-0001, 0011, 0014, 0017, 0040, 0051, 0095, 0099 and 0100, drive 0. Where the
/// standard leaves type, limits and default to the manufacturer, they are ours.
class SoeDrive final : public SoeTable {
 public:
  /// Time that S-0-0099 (reset class 1 diagnostic) takes.
  static constexpr std::chrono::milliseconds kResetTime{2};

  SoeDrive();

  /// The process data have stopped to come: S-0-0011, S-0-0014 and S-0-0095 tell it, and the master hears an emergency.
  /// \rtsafe
  void communication_failed() noexcept;
  /// Brings a procedure command to its end when it is time. \rtsafe
  void advance(std::chrono::nanoseconds now) noexcept;

 private:
  [[nodiscard]] SoeAnswer<void> start_command(std::uint8_t drive, wire::Idn idn) override;
  void set(wire::Idn idn, std::uint16_t value) noexcept;
  void set_diagnosis(std::string_view text) noexcept;

  std::chrono::nanoseconds now_{0};
  std::optional<std::chrono::nanoseconds> reset_over_;  ///< nothing: no reset is in progress
};

}  // namespace driveline::slaves::generic
