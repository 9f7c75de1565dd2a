#include "driveline/slaves/coe/coe_access.hpp"

#include <array>
#include <utility>

#include "driveline/wire/coe.hpp"

namespace driveline::slaves {

std::uint16_t coe_access(const EntryRow& row) noexcept {
  namespace coe = wire::entry_access;
  constexpr std::array<std::pair<std::uint16_t, std::uint16_t>, 9> kRights = {{
      {access::kReadConfiguring, coe::kReadPreOp},
      {access::kReadReady, coe::kReadSafeOp},
      {access::kReadOperating, coe::kReadOp},
      {access::kWriteConfiguring, coe::kWritePreOp},
      {access::kWriteReady, coe::kWriteSafeOp},
      {access::kWriteOperating, coe::kWriteOp},
      {access::kRxMappable, coe::kRxMappable},
      {access::kTxMappable, coe::kTxMappable},
      {access::kBackup, coe::kBackup},
  }};
  unsigned bits = 0;
  for (const auto& [right, bit] : kRights) bits |= (row.access & right) != 0 ? bit : 0U;
  return static_cast<std::uint16_t>(bits);
}

}  // namespace driveline::slaves
