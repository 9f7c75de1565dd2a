#include "checked_exchange.hpp"

#include <algorithm>

namespace driveline::ecat_master::dc {

Result<void> exchange_checked(Bus& bus, std::span<const SlaveRef> slaves, std::span<Request> requests) {
  // Slaves write their own count into the position part of an address, but not into a station address.
  if (auto done = bus.exchange().exchange(requests); !done) return done;
  const auto silent = std::find_if(requests.begin(), requests.end(),
                                   [](const Request& request) { return request.working_counter != 1; });
  if (silent == requests.end()) return {};
  const auto slave = std::find_if(slaves.begin(), slaves.end(),
                                  [&](const SlaveRef& ref) { return ref.station == silent->address.adp(); });
  Error error;
  error.kind = ErrorKind::kWorkingCounter;
  if (slave != slaves.end()) error.slave = slave->position;
  error.address = silent->address.ado();
  error.expected = 1;
  error.received = silent->working_counter;
  return tl::unexpected(error);
}

}  // namespace driveline::ecat_master::dc
