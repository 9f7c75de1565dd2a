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

/// What a drive tells about itself, as far as it does (CiA 402-2).
struct DriveFacts {
  std::optional<std::uint32_t> supported_modes{};  ///< 6502h, bit n for mode n + 1; 0: it does not tell
  std::optional<DriveRatio> gear{};                ///< 6091h: turns of the motor over turns of the shaft
  std::optional<DriveRatio> feed{};                ///< 6092h: position units over turns of the shaft
  std::optional<DriveRatio> encoder{};             ///< 608Fh: increments over turns of the motor
  std::optional<std::uint8_t> polarity{};          ///< 607Eh
  std::optional<DriveRatio> velocity_factor{};     ///< 604Ch: what a count of 6042h is multiplied with
  std::optional<std::int32_t> range_min{};         ///< 607Bh:01
  std::optional<std::int32_t> range_max{};         ///< 607Bh:02
};

/// Position units per turn of the motor: the feed over the gear ratio, or the increments of the encoder where the drive
/// has no factors. None: it does not tell, or tells a zero.
[[nodiscard]] std::optional<double> increments_per_revolution(const DriveFacts& facts) noexcept;

/// Reads an object of a drive by index and sub-index; none: it cannot be read.
using ReadObject = std::function<std::optional<std::vector<std::byte>>(std::uint16_t, std::uint8_t)>;
/// Asks one drive, object by object; what cannot be read is left out.
[[nodiscard]] DriveFacts ask_drive_facts(const ReadObject& read);

/// Asks the drives of all axes, side by side; objects that they do not have are left out. After Master::configure().
/// Nothing is asked of slaves without CoE and of those that are not on the line. One result per axis.
[[nodiscard]] std::vector<ecat_master::Result<DriveFacts>> read_drive_facts(ecat_master::Master& master,
                                                                            const LineConfig& config);

/// Two words about the scale of an axis, in increments per turn of the motor.
struct ScaleDifference {
  double described = 0.0;  ///< by the line description
  double told = 0.0;       ///< by the drive
};

/// Completes the axis by what its drive tells: its modes, how positions are scaled where the line description leaves
/// that out, what the target of its velocity mode counts in, and the range after which they begin anew. The difference
/// where the line description scales otherwise, which then counts. Errors: the drive does not have the mode of the
/// axis, counts positions in another direction than velocities, or both in another than torques that the axis uses, or
/// tells a scale that cannot be.
[[nodiscard]] Result<std::optional<ScaleDifference>> take_drive_facts(ecat_master::AxisConfig& axis,
                                                                      const DriveFacts& facts);

}  // namespace driveline::runtime
