#pragma once

#include <cstdint>
#include <string>
#include <variant>

namespace driveline::ecat_master {

/// Why a device cannot exchange the planned PDOs: one type per reason.
namespace misfits {

/// The device has no such PDO in this direction.
struct UnknownPdo {};
/// The PDO is fixed, but other entries are planned.
struct FixedEntries {};
/// Other entries are planned, but the device has no PDO configuration.
struct NoPdoConfiguration {};
/// The planned sync manager does not carry this direction.
struct WrongSyncManager {
  std::uint8_t planned = 0;  ///< number of the sync manager
  bool output = false;       ///< the PDO carries outputs; else inputs
};
/// The PDO is fixed to another sync manager.
struct FixedSyncManager {
  std::uint8_t fixed = 0;    ///< sync manager of the device
  std::uint8_t planned = 0;  ///< planned sync manager
};
/// The PDO excludes another planned PDO.
struct ExcludedPdo {
  std::uint16_t other = 0;  ///< index of the other PDO
};
/// The PDO is mandatory, but not planned.
struct MandatoryPdo {};
/// The assignment of the PDO is fixed and differs from the plan.
struct FixedAssignment {
  bool assigned = false;  ///< the device assigns the PDO; the plan has the opposite
};

}  // namespace misfits

/// One of the reasons with its details.
using MisfitFacts =
    std::variant<misfits::UnknownPdo, misfits::FixedEntries, misfits::NoPdoConfiguration, misfits::WrongSyncManager,
                 misfits::FixedSyncManager, misfits::ExcludedPdo, misfits::MandatoryPdo, misfits::FixedAssignment>;

/// A PDO that a device cannot exchange as planned.
struct PdoMisfit {
  std::uint16_t pdo = 0;  ///< index of its mapping object
  MisfitFacts facts;      ///< why
};

/// The misfit as a sentence: "PDO 1A00h is fixed: its entries cannot be changed".
[[nodiscard]] std::string describe(const PdoMisfit& misfit);

}  // namespace driveline::ecat_master
