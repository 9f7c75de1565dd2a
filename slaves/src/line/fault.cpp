#include "driveline/slaves/line/fault.hpp"

namespace driveline::slaves {

namespace {

constexpr bool rows_are_in_order() noexcept {
  for (std::size_t i = 0; i < kFaultKinds.size(); ++i) {
    if (static_cast<std::size_t>(kFaultKinds[i].kind) != i) return false;
  }
  return true;
}
static_assert(rows_are_in_order(), "fault_kind_row() uses the kind as index");

}  // namespace

bool Fault::same_place(const Fault& other) const noexcept {
  const auto of_mailbox = [](FaultKind k) { return k >= FaultKind::kMailboxSilent && k <= FaultKind::kMailboxForeign; };
  if (of_mailbox(kind) && of_mailbox(other.kind)) return slave == other.slave;
  if (kind != other.kind) return false;
  const auto& row = fault_kind_row(kind);
  const auto has = [&row](FaultParameter p) { return contains(row.needs, p) || contains(row.takes, p); };
  return (!has(FaultParameter::kSlave) || slave == other.slave) &&
         (!has(FaultParameter::kPort) || port == other.port) &&
         (!has(FaultParameter::kDirection) || direction == other.direction);
}

}  // namespace driveline::slaves
