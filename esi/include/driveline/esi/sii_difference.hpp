#pragma once

#include <string>
#include <vector>

#include "driveline/esi/sii.hpp"

namespace driveline::esi {

/// One thing in which an EEPROM differs from its device description.
struct SiiDifference {
  std::string what;     ///< e.g. "revision" or "RxPDO 0x1600, entry 2"
  std::string found;    ///< in the EEPROM
  std::string planned;  ///< by the description
  bool operator==(const SiiDifference&) const = default;
};

/// Where the EEPROM of a device (`found`) differs from the image that its description makes (make_sii()). Serial number
/// and station alias, which belong to the single device, are not compared, nor is the checksum as far as it follows
/// from them. An invalid checksum is a difference. Names are compared as texts, not by their numbers.
[[nodiscard]] std::vector<SiiDifference> compare_sii(const SiiImage& found, const SiiImage& planned);

}  // namespace driveline::esi
