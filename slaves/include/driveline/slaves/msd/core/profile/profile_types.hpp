#pragma once

#include <cstdint>

/// What every drive profile shares with the core.
namespace driveline::slaves::msd {

/// The profiles.
enum class ProfileKind : std::uint8_t {
  kCia402,  ///< CiA 402 (IEC 61800-7-201)
  kSercos,  ///< SERCOS, of a table with the values SercosValues
};

/// Effect of a write to an object of a profile.
enum class ProfileEffect : std::uint8_t {
  kNone,      ///< none, or it is not an object of the profile
  kCommand,   ///< a command, which may reset a fault
  kSetpoint,  ///< a setpoint of the active mode: it starts a segment of the interpolation
  kPrepared,  ///< a setpoint for another mode, or an offset
  kSetting,   ///< the settings of the drive have changed
};

/// Conditions of the drive for its state machine.
struct ProfileConditions {
  bool power_ready = false;  ///< ENPO, ISDSH and the DC link voltage are present
  bool standstill = false;   ///< the motor is at standstill, a ramp has ended, and the brake has settled
};

/// Facts for the status of the drive.
struct StatusFacts {
  bool warning = false;          ///< at least one warning is active
  bool following_error = false;  ///< too large, or the cause of the active fault
};

}  // namespace driveline::slaves::msd
