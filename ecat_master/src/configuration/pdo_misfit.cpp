#include "driveline/ecat_master/configuration/pdo_misfit.hpp"

#include <fmt/format.h>

namespace driveline::ecat_master {
namespace {

/// Visitor that makes the message.
struct MisfitSentence {
  std::uint16_t pdo;

  std::string operator()(const misfits::UnknownPdo& /*facts*/) const {
    return fmt::format("the device has no PDO {:04X}h in this direction", pdo);
  }
  std::string operator()(const misfits::FixedEntries& /*facts*/) const {
    return fmt::format("PDO {:04X}h is fixed: its entries cannot be changed", pdo);
  }
  std::string operator()(const misfits::NoPdoConfiguration& /*facts*/) const {
    return fmt::format("the entries of PDO {:04X}h cannot be changed: the device has no PDO configuration", pdo);
  }
  std::string operator()(const misfits::WrongSyncManager& facts) const {
    return fmt::format("PDO {:04X}h is assigned to sync manager {}, which carries no {}", pdo, facts.planned,
                       facts.output ? "outputs" : "inputs");
  }
  std::string operator()(const misfits::FixedSyncManager& facts) const {
    return fmt::format("PDO {:04X}h is fixed in sync manager {}, sync manager {} is planned", pdo, facts.fixed,
                       facts.planned);
  }
  std::string operator()(const misfits::ExcludedPdo& facts) const {
    return fmt::format("PDO {:04X}h excludes PDO {:04X}h", pdo, facts.other);
  }
  std::string operator()(const misfits::MandatoryPdo& /*facts*/) const {
    return fmt::format("PDO {:04X}h is mandatory and missing", pdo);
  }
  std::string operator()(const misfits::FixedAssignment& facts) const {
    return fmt::format("PDO {:04X}h is {}assigned by the device, which cannot be changed", pdo,
                       facts.assigned ? "" : "not ");
  }
};

}  // namespace

std::string describe(const PdoMisfit& misfit) {
  return std::visit(MisfitSentence{misfit.pdo}, misfit.facts);
}

}  // namespace driveline::ecat_master
