#include "checked_exchange.hpp"

#include <algorithm>

namespace driveline::ecat_master::dc {

Result<void> exchange_checked(Bus& bus, std::span<const SlaveRef> slaves, std::span<Request> requests) {
  // Slaves modify the position part of an auto-increment address, but not a station address.
  if (auto done = bus.exchange().exchange(requests); !done) return done;
  const auto silent = std::find_if(requests.begin(), requests.end(),
                                   [](const Request& request) { return request.working_counter != 1; });
  if (silent == requests.end()) return {};
  const auto slave = std::find_if(slaves.begin(), slaves.end(),
                                  [&](const SlaveRef& ref) { return ref.station == silent->address.adp(); });
  return tl::unexpected(
      Error{facts::WorkingCounter{.address = silent->address.ado(), .received = silent->working_counter},
            slave == slaves.end() ? Error::kNoSlave : slave->position});
}

}  // namespace driveline::ecat_master::dc
