#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "driveline/slaves/cia402/power_state_machine.hpp"
#include "driveline/slaves/cia402/setpoint_handshake.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::generic {

/// Number of CiA 402 drives that a device with this dictionary has, at most IdealDrives::kMaxDrives: drive n has a
/// control word at 6040h + n * 800h and a status word at 6041h + n * 800h (CiA 301 "Object dictionary structure",
/// ETG.6010), and there are no gaps between the drives.
[[nodiscard]] std::size_t count_drives(const DictionaryTable& table) noexcept;

/// The CiA 402 drives of a device that is known by its description only. They have neither motor nor load: an enabled
/// drive moves exactly as commanded, in cyclic synchronous position and velocity mode, in interpolated position mode,
/// and in profile position and velocity mode, as far as its dictionary has 607Ah, 60FFh, 60C1h:01 and 6081h. A position
/// setpoint is reached one exchange after its reception (linear interpolation), a velocity setpoint at once, the target
/// of a profile at the velocity 6081h. Ramps take no time: a drive that is not enabled, or is halted on a profile,
/// stands still.
///
/// The values of the objects are those of the device's dictionary. Belongs to the thread that drives the line.
class IdealDrives {
 public:
  static constexpr std::size_t kMaxDrives = 8;            ///< room for drives in the object dictionary
  static constexpr std::uint16_t kNoMasterData = 0x7500;  ///< 603Fh: process data do not arrive (CiA 402-2)

  /// The drives of a device with this dictionary; the table outlives them.
  explicit IdealDrives(const DictionaryTable& table);

  /// Whether the drives read or set the value in this slot. \rtsafe
  [[nodiscard]] bool owns(std::uint16_t slot) const noexcept;
  /// Takes the setpoints in `dictionary`, which have just arrived in an exchange, at the time of the last advance().
  /// \rtsafe
  void exchange(const ObjectDictionary& dictionary) noexcept;
  /// Moves the drives on to `now` and sets their actual values. \rtsafe
  void advance(ObjectDictionary& dictionary, std::chrono::nanoseconds now) noexcept;
  /// Switches the drives off and on again; they keep their positions. \rtsafe
  void restart() noexcept;
  /// Puts every drive into Fault with kNoMasterData: the process data have ended in OP. \rtsafe
  void communication_failed(ObjectDictionary& dictionary) noexcept;

 private:
  struct Drive {
    // Objects of the first drive in this order; null: the dictionary does not have the object.
    const EntryRow* control_word = nullptr;
    const EntryRow* status_word = nullptr;
    const EntryRow* error_code = nullptr;
    const EntryRow* mode = nullptr;
    const EntryRow* mode_display = nullptr;
    const EntryRow* target_position = nullptr;
    const EntryRow* interpolation_data = nullptr;
    const EntryRow* target_velocity = nullptr;
    const EntryRow* profile_velocity = nullptr;
    const EntryRow* actual_position = nullptr;
    const EntryRow* actual_velocity = nullptr;

    PowerStateMachine power{};
    OperationMode active = OperationMode::kNone;
    bool reset_bit = false;       ///< bit 7 of the control word in the last step
    std::uint16_t commanded = 0;  ///< control word in the last step
    SetpointHandshake targets{};  ///< handshake of profile position mode
    // Increments, continuing beyond the range of the objects.
    double position = 0.0;
    double velocity = 0.0;                 ///< increments per second
    double from = 0.0;                     ///< position at the last exchange
    double to = 0.0;                       ///< position setpoint of the last exchange
    double goal = 0.0;                     ///< target of profile position mode
    std::chrono::nanoseconds since{0};     ///< time of the last exchange
    std::chrono::nanoseconds interval{0};  ///< time between the last two exchanges

    [[nodiscard]] bool follows() const noexcept { return power.motion() == MotionCommand::kFollow; }
    [[nodiscard]] bool interpolates() const noexcept { return active == OperationMode::kInterpolatedPosition; }
    [[nodiscard]] bool has(OperationMode wanted) const noexcept;
    [[nodiscard]] bool stands() const noexcept;
    [[nodiscard]] std::uint16_t mode_bits() const noexcept;
    void move_to_goal(const ObjectDictionary& dictionary, double dt_s) noexcept;
    void step_power(ObjectDictionary& dictionary, std::chrono::nanoseconds dt) noexcept;
    void choose_mode(const ObjectDictionary& dictionary) noexcept;
    void move(const ObjectDictionary& dictionary, std::chrono::nanoseconds now, std::chrono::nanoseconds dt) noexcept;
    void publish(ObjectDictionary& dictionary) const noexcept;
  };

  std::vector<Drive> drives_;
  std::optional<std::chrono::nanoseconds> now_{};
};

}  // namespace driveline::slaves::generic
