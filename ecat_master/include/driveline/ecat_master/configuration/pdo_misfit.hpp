#pragma once

#include <cstdint>
#include <string>
#include <variant>

namespace driveline::ecat_master {

/// Why a device cannot exchange PDOs as they are planned, one type for each reason.
namespace misfits {

/// The device has no such PDO in this direction.
struct UnknownPdo {};
/// The PDO is fixed, other entries are planned.
struct FixedEntries {};
/// Other entries are planned, and the device has no PDO configuration.
struct NoPdoConfiguration {};
/// The planned sync manager does not carry this direction.
struct WrongSyncManager {
  std::uint8_t planned = 0;  ///< number of the sync manager
  bool output = false;       ///< the PDO carries outputs; else inputs
};
/// The PDO is fixed in another sync manager.
struct FixedSyncManager {
  std::uint8_t fixed = 0;    ///< where it is
  std::uint8_t planned = 0;  ///< where it was to be
};
/// The PDO excludes another one that is planned as well.
struct ExcludedPdo {
  std::uint16_t other = 0;  ///< index of the other PDO
};
/// The PDO is mandatory, and not planned.
struct MandatoryPdo {};
/// The device assigns the PDO, or does not, and that cannot be changed.
struct FixedAssignment {
  bool assigned = false;  ///< by the device; the plan has the opposite
};

}  // namespace misfits

/// One of the reasons with its facts.
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
