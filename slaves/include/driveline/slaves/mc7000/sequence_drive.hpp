#pragma once

#include <cstdint>
#include <optional>

#include "driveline/slaves/mc7000/posmod_location.hpp"
#include "driveline/slaves/mc7000/program.hpp"

namespace driveline::slaves::mc7000 {

/// Where the axis is in its last motion.
struct MotionState {
  /// A move, reference run or jog is not at its end, also while its feed is held.
  bool moving = false;
  /// The axis is in the window around its last target.
  bool in_position = false;
  /// Why the last motion has ended before its target; kNone otherwise.
  PosModLocation failure = PosModLocation::kNone;
};

/// The drive as the sequence control sees it. Called in the control cycle.
class SequenceDrive {
 public:
  SequenceDrive() = default;
  SequenceDrive(const SequenceDrive&) = delete;
  SequenceDrive& operator=(const SequenceDrive&) = delete;
  virtual ~SequenceDrive() = default;

  /// State of the last motion. From the order to its end it is `moving`, from the moment of the order on. \rtsafe
  [[nodiscard]] virtual MotionState motion() const noexcept = 0;
  /// Returns whether the reference point is defined. \rtsafe
  [[nodiscard]] virtual bool referenced() const noexcept = 0;
  /// Starts a reference run. \rtsafe
  virtual void start_reference_run() noexcept = 0;
  /// Starts a move to an absolute position in increments with a speed above 0 in increments per 5 ms. Returns why the
  /// drive refuses it (limits, range, speed), kNone when it has started. \rtsafe
  [[nodiscard]] virtual PosModLocation start_move(std::int32_t position, std::int32_t speed) noexcept = 0;
  /// Lets motions run (true), or holds them where they are until the next call. Called on a change. \rtsafe
  virtual void release_feed(bool released) noexcept = 0;
  /// Moves the axis at jog speed in positive (1) or negative (-1) direction, 0 stops it. Called on a change. \rtsafe
  virtual void jog(int direction) noexcept = 0;
  /// Stops the axis, drops its motion and clears its failure. \rtsafe
  virtual void stop() noexcept = 0;
  /// Returns the state of an input (kExtensionInput, kServoInput), none when the drive lacks it. \rtsafe
  [[nodiscard]] virtual std::optional<bool> input(ConditionSource source, std::uint8_t number) const noexcept = 0;
  /// Sets the reference state of output OS00 (0) or OS01 (1). Called on a change. \rtsafe
  virtual void set_output(std::uint8_t number, bool state) noexcept = 0;
  /// A program has set the flag of TxPDO 1 or 2. The drive sends it when its EVST1 or EVST2 says POMOD. \rtsafe
  virtual void tx_pdo_event(std::uint8_t tx_pdo) noexcept = 0;
};

}  // namespace driveline::slaves::mc7000
