#pragma once

#include <string>
#include <vector>

#include "driveline/esi/sii.hpp"

namespace driveline::esi {

/// One difference between an EEPROM and its device description.
struct SiiDifference {
  std::string what;     ///< the item that differs, e.g. "revision" or "RxPDO 0x1600, entry 2"
  std::string found;    ///< value in the EEPROM
  std::string planned;  ///< value in the description
  bool operator==(const SiiDifference&) const = default;
};

/// Compares the EEPROM of a device (`found`) with the image made from its description (`planned`, see make_sii()).
/// Serial number and station alias belong to the individual device and are not compared; a checksum difference that
/// results from them is ignored. An invalid checksum is a difference. Names are compared as texts, not by their
/// numbers.
[[nodiscard]] std::vector<SiiDifference> compare_sii(const SiiImage& found, const SiiImage& planned);

}  // namespace driveline::esi
