#pragma once

#include <span>
#include <vector>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/coe/sdo_script.hpp"
#include "driveline/motion/cia301/pdo_configuration.hpp"

namespace driveline::ecat_master {

/// The assignment object of sync manager 0; the other sync managers follow (ETG.1000.6 Table 67).
inline constexpr std::uint16_t kPdoAssignment = 0x1C10;

/// The planned PDOs of one sync manager, and the SDOs that configure them.
struct AssignmentPlan {
  std::uint8_t sync_manager = 0;  ///< number of the sync manager
  bool outputs = false;           ///< it carries outputs; else inputs
  std::vector<motion::PdoMapping>
      pdos{};  ///< in the order of their assignment; objects only where the mapping is written
  std::vector<SdoScript::Step> steps{};  ///< in the order of write_pdo_configuration()
};

/// The plans of sync managers 2 and 3 (1C12h, 1C13h).
[[nodiscard]] std::vector<AssignmentPlan> plan_assignments(const motion::PdoConfiguration& configuration);
/// The SDOs of several plans, one after the other.
[[nodiscard]] std::vector<SdoScript::Step> steps_of(std::span<const AssignmentPlan> plans);

/// The SDOs written by write_pdo_configuration(), for run_scripts().
[[nodiscard]] std::vector<SdoScript::Step> pdo_script(const motion::PdoConfiguration& configuration);

/// Writes mapping and assignment over CoE in the order that the standard requires: clear the assignment; clear, fill
/// and count each mapping; fill and count the assignment (ETG.1000.6 5.6.7.4). The slave must be in PREOP.
[[nodiscard]] Result<void> write_pdo_configuration(CoeClient& coe, const motion::PdoConfiguration& configuration);

/// Reads the PDOs that the slave has assigned to a sync manager (`assignment`: 1C10h + its number), and their mapping.
/// An assignment of which at least one element could be read ends at the first one that the slave aborts; elements that
/// are 0 are skipped. Errors: those of CoeClient.
[[nodiscard]] Result<std::vector<motion::PdoMapping>> read_assigned_pdos(CoeClient& coe, std::uint16_t assignment);

/// Reads back the assigned PDOs of 1C12h or 1C13h and returns their total length in bytes.
[[nodiscard]] Result<std::size_t> read_assigned_bytes(CoeClient& coe, std::uint16_t assignment);

}  // namespace driveline::ecat_master
