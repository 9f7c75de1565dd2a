#pragma once

#include "driveline/canopen_master/node_error.hpp"
#include "driveline/canopen_master/node_plan.hpp"

namespace driveline::canopen {

/// The last transmission type of PDOs that go with SYNC (CiA 301 7.5.2.35).
inline constexpr std::uint8_t kLastSynchronous = 240;

/// The identifier of a PDO of a node: that of the plan, or that of the predefined connection set; 0: it has neither.
/// `rpdo`: the node receives the PDO. \rtsafe
[[nodiscard]] constexpr std::uint16_t pdo_identifier(const PdoPlan& pdo, bool rpdo, std::uint8_t node) noexcept {
  if (pdo.identifier != 0) return pdo.identifier;
  const auto& bases = rpdo ? predefined::kRxPdo : predefined::kTxPdo;
  if (pdo.number == 0 || pdo.number > bases.size()) return 0;
  return static_cast<std::uint16_t>(bases[pdo.number - 1U] + node);
}

/// What is wrong with a plan, all of it: errors of kind kBadPlan. Whether the PDOs fit the bus is checked elsewhere,
/// when all mappings are known.
[[nodiscard]] NodeErrors check(const MasterPlan& plan);

}  // namespace driveline::canopen
