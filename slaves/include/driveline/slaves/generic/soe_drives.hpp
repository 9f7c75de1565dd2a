#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "driveline/slaves/idn/idn_dictionary.hpp"

namespace driveline::slaves::generic {

/// A check of a drive in the transition to SAFEOP (S-0-0127) or OP (S-0-0128): the value of a number.
struct SoeRule {
  wire::AlState to = wire::AlState::kSafeOp;  ///< SAFEOP or OP
  wire::Idn idn{};                            ///< operation datum that is a number; others are invalid
  double minimum = 0.0;                       ///< lowest valid value
  double maximum = 0.0;                       ///< highest valid value
};

/// Operation data of the drives of a device, all at standstill: S-0-0001, 0011, 0014, 0017, 0040, 0051, 0095, 0099,
/// 0100 and 0142. With process data also S-0-0016 and S-0-0024, which list the cyclic data and are writable in PREOP,
/// S-0-0187 and S-0-0188, which list the data that may be cyclic, and S-0-0036, 0047, 0134 and 0135. With rules
/// also S-0-0021 and S-0-0022, the lists of data that the last check found invalid, and S-0-0023, which stays empty.
/// Where the standard
/// leaves type, limits and default to the manufacturer, they are ours.
class SoeDrives final : public IdnDictionary {
 public:
  /// Duration of S-0-0099 (reset class 1 diagnostic).
  static constexpr std::chrono::milliseconds kResetTime{2};
  /// Number of drives that a mailbox message can address.
  static constexpr std::size_t kMaxDrives = 8;

  /// Cyclic data of the drives.
  enum class ProcessData : std::uint8_t {
    kNone,    ///< no process data
    kByLists  ///< the data listed in S-0-0016 and S-0-0024
  };

  /// `count`: 1 to kMaxDrives. `rules`: checks of each drive.
  explicit SoeDrives(std::size_t count, ProcessData process_data = ProcessData::kNone, std::vector<SoeRule> rules = {});

  /// Returns the bytes of the MDTs of all drives: for each, its master control word and the data in S-0-0024. \rtsafe
  [[nodiscard]] std::size_t outputs_size() const noexcept;
  /// Returns the bytes of the ATs of all drives: for each, its drive status word and the data in S-0-0016. \rtsafe
  [[nodiscard]] std::size_t inputs_size() const noexcept;
  /// Receives the MDTs of all drives in order; a drive follows its commands at once. \rtsafe
  void write_outputs(std::span<const std::byte> data) noexcept;
  /// Writes the ATs of all drives in order. \rtsafe
  void read_inputs(std::span<std::byte> data) const noexcept;
  /// Sets all data of the MDTs to 0. \rtsafe
  void clear_outputs() noexcept;

  /// Checks all drives in the transition to SAFEOP or OP, and sets the list of the phase and S-0-0095 in each of them.
  /// Returns whether all data are valid; without rules they are. \rtsafe
  [[nodiscard]] bool check_transition(wire::AlState to) noexcept;
  /// Called when no process data arrive any more: sets S-0-0011, S-0-0014 and S-0-0095, and sends the master an
  /// emergency of each drive. \rtsafe
  void communication_failed() noexcept;
  /// Ends procedure commands whose duration has passed. \rtsafe
  void advance(std::chrono::nanoseconds now) noexcept;

 private:
  /// Data of a telegram of a drive in their order; the first is its control or status word.
  using Telegram = std::vector<const IdnRow*>;

  [[nodiscard]] SoeAnswer<void> start_command(std::uint8_t drive, wire::Idn idn) override;
  [[nodiscard]] SoeAnswer<void> check_value(std::uint8_t drive, wire::Idn idn,
                                            std::span<const std::byte> value) override;
  void written(std::uint8_t drive, wire::Idn idn) override;
  void plan_telegrams(std::uint8_t drive);
  void follow_commands() noexcept;
  void set_diagnosis(std::uint8_t drive, std::uint16_t class1, std::uint16_t interface_status,
                     std::string_view text) noexcept;
  void advance(std::uint8_t drive) noexcept;

  [[nodiscard]] bool check_drive(std::uint8_t drive, wire::AlState to) noexcept;

  std::vector<SoeRule> rules_;
  std::chrono::nanoseconds now_{0};
  /// End of the reset in progress, by drive; nullopt: none.
  std::vector<std::optional<std::chrono::nanoseconds>> resets_over_;
  /// Telegrams by drive, made anew when their lists are written; empty without process data.
  std::vector<Telegram> mdts_;
  std::vector<Telegram> ats_;
};

}  // namespace driveline::slaves::generic
