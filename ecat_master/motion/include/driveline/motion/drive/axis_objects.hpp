#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driveline/motion/cia301/pdo_configuration.hpp"
#include "driveline/motion/cia402/cia402.hpp"

namespace driveline::motion {

/// Offset of an object in the process data of a direction, in bytes from their start; empty if the object is not mapped
/// with this width, or is not byte aligned.
[[nodiscard]] std::optional<std::size_t> object_offset(const std::vector<PdoMapping>& pdos, std::uint16_t index,
                                                       std::size_t bits, std::uint8_t subindex = 0);

/// An object that an axis needs but that is not mapped, or not with the required width and alignment.
struct MissingObject {
  std::uint16_t index = 0;
  std::uint8_t bits = 0;         ///< required length
  bool output = false;           ///< true: belongs in the RxPDOs; false: in the TxPDOs
  std::uint8_t mapped_bits = 0;  ///< actual length if it is wrong, or `bits` if not byte aligned; 0: not mapped
  std::uint8_t subindex = 0;
  constexpr bool operator==(const MissingObject&) const = default;
};

/// The objects that `pdos`, as the drive of the axis sees them (pdos_of_drive()), lack in this mode. Needed are 6040h
/// and 6041h; the target of the mode (607Ah, 6042h, 60FFh, 6071h or 60C1h:01; none for homing); the actual position
/// 6064h, for supervision in every mode and for the loops of CSV and CST; in CST the actual velocity 606Ch; and with
/// `torque_offset`, for a feed-forward of friction and weight, 60B2h in CSP and CSV. Empty: nothing is missing.
[[nodiscard]] std::vector<MissingObject> missing_objects(cia402::Mode mode, const PdoConfiguration& pdos,
                                                         bool torque_offset = false);

/// Message text, such as "csp needs 607Ah (Target position, 32 bits) in an RxPDO; ..."; empty if nothing is missing.
/// `pdos`: those of the device; `drive`: number of the drive there.
[[nodiscard]] std::string describe_missing(cia402::Mode mode, const std::vector<MissingObject>& missing,
                                           const PdoConfiguration& pdos, unsigned drive = 0);

}  // namespace driveline::motion
