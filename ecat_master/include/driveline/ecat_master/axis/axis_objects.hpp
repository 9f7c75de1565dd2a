#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/cia402/cia402.hpp"
#include "driveline/ecat_master/process_data/pdo_configuration.hpp"

namespace driveline::ecat_master {

/// Where an object lies in the process data of one direction, in bytes from their start; nothing when it is not mapped
/// with that width, or does not begin at a byte.
[[nodiscard]] std::optional<std::size_t> object_offset(const std::vector<PdoMapping>& pdos, std::uint16_t index,
                                                       std::size_t bits, std::uint8_t subindex = 0);

/// An object that an axis needs and that is not mapped, or not as it is needed.
struct MissingObject {
  std::uint16_t index = 0;
  std::uint8_t bits = 0;         ///< length it must have
  bool output = false;           ///< among those of the RxPDOs; else of the TxPDOs
  std::uint8_t mapped_bits = 0;  ///< wrong length it has, or `bits` if not byte aligned; 0: not mapped
  std::uint8_t subindex = 0;
  constexpr bool operator==(const MissingObject&) const = default;
};

/// The objects that an axis of this mode misses in `pdos`: 6040h and 6041h, the target of its mode (607Ah, 6042h,
/// 60FFh, 6071h or 60C1h:01; none for homing), the actual position 6064h, for supervision in every mode and for the
/// loops of CSV and CST, and in CST the actual velocity 606Ch; with `torque_offset`, for a feed-forward of friction and
/// weight, in CSP and CSV 60B2h. Empty: nothing is missing.
[[nodiscard]] std::vector<MissingObject> missing_objects(cia402::Mode mode, const PdoConfiguration& pdos,
                                                         bool torque_offset = false);

/// "csp needs 607Ah (Target position, 32 bits) in an RxPDO; ..." Empty when nothing is missing.
[[nodiscard]] std::string describe_missing(cia402::Mode mode, const std::vector<MissingObject>& missing,
                                           const PdoConfiguration& pdos);

}  // namespace driveline::ecat_master
