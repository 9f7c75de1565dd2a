#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/slaves/mc7000/posmod_location.hpp"
#include "driveline/slaves/mc7000/process_values.hpp"
#include "driveline/slaves/mc7000/program_line.hpp"
#include "driveline/slaves/mc7000/program_run.hpp"
#include "driveline/slaves/mc7000/program_store.hpp"
#include "driveline/slaves/mc7000/sequence_drive.hpp"

namespace driveline::slaves::mc7000 {

/// Time of automatic mode before which a start does not count (MC7000 manual, line 946).
inline constexpr std::chrono::milliseconds kStartDelay{10};

/// Control word bits of PosMod (MC7000 manual, line 879).
struct SequenceOrders {
  bool automatic = false;
  bool start = false;
  bool feed = false;
  bool jog_positive = false;
  bool jog_negative = false;
  /// Reference states of the outputs OS00 and OS01.
  bool outputs[2] = {};

  /// Reads bits 4, 5, 6 and 12 to 15. Bit 11 (update) has no stated effect and is not read. \rtsafe
  [[nodiscard]] static SequenceOrders from_control_word(std::uint16_t word) noexcept;
};

/// What the sequence control does.
enum class SequenceState : std::uint8_t {
  /// Jog and download.
  kManual,
  /// Automatic, no program has been started.
  kReady,
  kRunning,
  /// The program has come to its end.
  kEnded,
  /// An error has stopped axis and program; see SequenceControl::fault().
  kFault,
};

/// Positioning and sequence control: modes, jog, outputs, and the run of the selected program, one step per control
/// period.
class SequenceControl {
 public:
  /// @param[in] drive outlives this
  /// @param[in] period time between two steps, above 0
  SequenceControl(SequenceDrive& drive, std::chrono::nanoseconds period) noexcept
      : drive_(drive), period_(period), run_(drive, values_, period) {}
  SequenceControl(const SequenceControl&) = delete;
  SequenceControl& operator=(const SequenceControl&) = delete;

  /// Executes a string that is written to parameter 551 (POCMD), in manual mode only.
  tl::expected<void, LineError> command(std::string_view line);
  /// Selects the program that the next start runs, 0 to 99; at first 0. \rtsafe
  void select(std::uint8_t program) noexcept { selected_ = program; }
  /// One control period. `enabled`: the state machine of the drive is in "operation enabled". \rtsafe
  void step(std::uint16_t control_word, bool enabled) noexcept;
  /// Takes an RxPDO21; a field beyond 99 is an error. \rtsafe
  void receive_rx_pdo21(std::span<const std::byte, ProcessValues::kRxPdo21Size> pdo) noexcept;
  /// Acknowledges the error. A program runs again after a new edge of the start bit. \rtsafe
  void acknowledge() noexcept;
  /// Supply off and on: unsaved programs, variables, flags and the error are gone. To be followed by step().
  void restart();

  /// Returns what the control does. \rtsafe
  [[nodiscard]] SequenceState state() const noexcept { return state_; }
  /// Returns the error, kNone without one. \rtsafe
  [[nodiscard]] PosModLocation fault() const noexcept { return fault_; }
  /// Returns the number of the record that the program executed last, or that waits. \rtsafe
  [[nodiscard]] std::uint16_t record() const noexcept { return run_.record(); }
  /// Returns bits 12 (in position), 13 (reference defined) and 14 (program end) of the status word. \rtsafe
  [[nodiscard]] std::uint16_t status_bits() const noexcept;
  /// Variables and flags. \rtsafe
  [[nodiscard]] ProcessValues& values() noexcept { return values_; }
  /// Programs. \rtsafe
  [[nodiscard]] const ProgramStore& programs() const noexcept { return programs_; }

 private:
  void follow(const SequenceOrders& orders) noexcept;
  void follow_manual(const SequenceOrders& orders, bool enabled) noexcept;
  void follow_automatic(const SequenceOrders& orders, bool enabled) noexcept;
  void set_jog(int direction) noexcept;
  void start(bool feed, bool enabled) noexcept;
  void run(bool enabled) noexcept;
  void fail(PosModLocation location) noexcept;

  SequenceDrive& drive_;
  std::chrono::nanoseconds period_;
  ProgramStore programs_;
  ProcessValues values_;
  ProgramRun run_;
  SequenceState state_ = SequenceState::kManual;
  PosModLocation fault_ = PosModLocation::kNone;
  std::uint8_t selected_ = 0;
  std::chrono::nanoseconds automatic_for_{};
  int jog_ = 0;
  SequenceOrders last_;
  /// The drive has had feed and outputs once.
  bool told_ = false;
};

}  // namespace driveline::slaves::mc7000
