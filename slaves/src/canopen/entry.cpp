#include "driveline/slaves/canopen/entry.hpp"

namespace driveline::slaves::cia301 {

SdoResult<void> check_cob_id(canopen::CobId before, canopen::CobId after) noexcept {
  constexpr std::uint32_t kIdentifierBits = canopen::CobId::kExtended | canopen::Identifier::kExtendedMask;
  const bool same_identifier = ((before.raw ^ after.raw) & kIdentifierBits) == 0;
  const bool locked = !before.invalid() && !after.invalid();
  if (!after.well_formed() || (locked && !same_identifier)) return tl::unexpected(sdo::SdoAbort::kValueRange);
  if (!after.invalid() && canopen::is_restricted(after.identifier())) return tl::unexpected(sdo::SdoAbort::kValueRange);
  return {};
}

}  // namespace driveline::slaves::cia301
