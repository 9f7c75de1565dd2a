#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// A fraction of the factor group: sub-index 1 over sub-index 2.
struct DriveRatio {
  std::uint32_t numerator = 0;
  std::uint32_t divisor = 0;
};

/// Facts that a drive reports about itself, as far as it has the objects (CiA 402-2).
struct DriveFacts {
  std::optional<std::uint32_t> supported_modes{};  ///< 6502h, bit n for mode n + 1; 0: not reported
  std::optional<DriveRatio> gear{};                ///< 6091h: turns of the motor over turns of the shaft
  std::optional<DriveRatio> feed{};                ///< 6092h: position units over turns of the shaft
  std::optional<DriveRatio> encoder{};             ///< 608Fh: increments over turns of the motor
  std::optional<std::uint8_t> polarity{};          ///< 607Eh
  std::optional<DriveRatio> velocity_factor{};     ///< 604Ch: factor of a count of 6042h
  std::optional<std::int32_t> range_min{};         ///< 607Bh:01
  std::optional<std::int32_t> range_max{};         ///< 607Bh:02
};

/// Returns the position units per turn of the motor: feed divided by gear ratio, or the increments of the encoder if
/// the drive has no factors. None: not reported, or zero.
[[nodiscard]] std::optional<double> increments_per_revolution(const DriveFacts& facts) noexcept;

/// Reads an object of a drive by index and sub-index; none: it cannot be read.
using ReadObject = std::function<std::optional<std::vector<std::byte>>(std::uint16_t, std::uint8_t)>;
/// Reads the facts of a drive, object by object; objects that cannot be read are left out.
[[nodiscard]] DriveFacts ask_drive_facts(const ReadObject& read);

/// Reads the facts of the drives of all axes in parallel; missing objects are left out. Skips slaves without CoE and
/// slaves that are not on the line. Returns one result per axis. Call after Master::configure().
[[nodiscard]] std::vector<ecat_master::Result<DriveFacts>> read_drive_facts(ecat_master::Master& master,
                                                                            const LineConfig& config);

/// Two different scales of an axis, in increments per turn of the motor.
struct ScaleDifference {
  double described = 0.0;          ///< scale in the line description
  double reported_by_drive = 0.0;  ///< scale reported by the drive
};

/// Completes the axis with the facts of its drive: its modes, the scale of positions if the line description leaves it
/// out, the unit of the target in velocity mode, and the range after which positions wrap. Returns the difference if
/// the line description has another scale, which then takes precedence. Errors: the drive does not support the mode of
/// the axis, counts positions in another direction than velocities, or counts both in another direction than torques
/// that the axis uses, or reports an impossible scale.
[[nodiscard]] Result<std::optional<ScaleDifference>> take_drive_facts(motion::AxisConfig& axis,
                                                                      const DriveFacts& facts);

}  // namespace driveline::runtime
